#include "tests/support/rig.h"

#include "lcp/base/rng.h"
#include "tests/support/relax.h"
#include "tests/support/tableau.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int dofs(const rig *r) {
  return (r->dim == 2) ? 3 : 6;
}

rig *rig_new(int dim, double h) {
  rig *r = calloc(1, sizeof *r);
  r->dim = dim;
  r->h = h;
  return r;
}

int rig_body(rig *r, double mass, double ix, double iy, double iz) {
  const int b = r->n_body++;
  r->mass[b] = mass;
  r->inertia[b][0] = ix;
  r->inertia[b][1] = iy;
  r->inertia[b][2] = iz;
  return b;
}

static void cross(const double *a, const double *b, double *out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

rig_contact *rig_touch(rig *r, int a, int b, const double *ra, const double *rb, const double *n,
                       double mu) {
  rig_contact *c = &r->contact[r->n_contact++];
  *c = (rig_contact){.a = a, .b = b, .mu = mu, .mu_k = mu};
  memcpy(c->ra, ra, sizeof c->ra);
  memcpy(c->rb, rb, sizeof c->rb);
  memcpy(c->n, n, sizeof c->n);
  if (r->dim == 2) {
    c->t1[0] = n[1];
    c->t1[1] = -n[0];
    return c;
  }
  const double dot = n[0];
  const double axis[3] = {fabs(dot) < 0.99, fabs(dot) >= 0.99, 0};
  const double d = axis[0] * n[0] + axis[1] * n[1];
  double length = 0;
  for (int k = 0; k < 3; k++) {
    c->t1[k] = axis[k] - d * n[k];
    length += c->t1[k] * c->t1[k];
  }
  for (int k = 0; k < 3; k++) {
    c->t1[k] /= sqrt(length);
  }
  cross(n, c->t1, c->t2);
  return c;
}

/* One row: direction e at offset p; angular part p x e. */
static void row_of(const rig *r, const double *e, const double *p, double sign, double *out) {
  if (r->dim == 2) {
    out[0] = sign * e[0];
    out[1] = sign * e[1];
    out[2] = sign * (p[0] * e[1] - p[1] * e[0]);
    return;
  }
  double m[3];
  cross(p, e, m);
  for (int k = 0; k < 3; k++) {
    out[k] = sign * e[k];
    out[3 + k] = sign * m[k];
  }
}

static void spin_row(const double *e, double sign, double *out) {
  for (int k = 0; k < 3; k++) {
    out[k] = 0;
    out[3 + k] = sign * e[k];
  }
}

static int contact_jacobian(rig *r, const rig_contact *c, contact_rows rows, double *jac) {
  const double *tangent[2] = {c->t1, c->t2};
  const int n = dofs(r);
  int at = 0;
  for (int side = 0; side < 2; side++) {
    if ((side == 0 ? c->a : c->b) < 0) {
      continue;
    }
    const double sign = (side == 0) ? 1 : -1;
    const double *p = (side == 0) ? c->ra : c->rb;
    row_of(r, c->n, p, sign, jac + at);
    at += n;
    for (int k = 0; k < rows.tangent; k++, at += n) {
      row_of(r, tangent[k], p, sign, jac + at);
    }
    for (int k = 0; k < rows.torsion; k++, at += n) {
      spin_row(c->n, sign, jac + at);
    }
    for (int k = 0; k < rows.rolling; k++, at += n) {
      spin_row(tangent[k], sign, jac + at);
    }
  }
  return at;
}

static void fill_bodies(rig *r) {
  const int n = dofs(r);
  for (int b = 0; b < r->n_body; b++) {
    r->dof_start[b] = n * b;
    r->mass_start[b] = n * n * b;
    double *M = r->M + (ptrdiff_t)n * n * b;
    double *W = r->W + (ptrdiff_t)n * n * b;
    memset(M, 0, (size_t)(n * n) * sizeof *M);
    memset(W, 0, (size_t)(n * n) * sizeof *W);
    for (int k = 0; k < n; k++) {
      const double m = (k < r->dim) ? r->mass[b] : r->inertia[b][(r->dim == 2) ? 2 : k - 3];
      M[k * n + k] = m;
      W[k * n + k] = 1 / m;
      r->v_free[n * b + k] = r->v[n * b + k] + ((k < r->dim) ? r->h * r->gravity[k] : 0);
    }
  }
  r->dof_start[r->n_body] = n * r->n_body;
  r->mass_start[r->n_body] = n * n * r->n_body;
}

static void fill_contact(rig *r, int i, int *row, int *at) {
  const rig_contact *c = &r->contact[i];
  const bool spatial = r->dim == 3;
  r->rows[i] = (contact_rows){.tangent = (unsigned char)((c->mu > 0) ? r->dim - 1 : 0),
                              .torsion = (unsigned char)(spatial && c->torsion > 0),
                              .rolling = (unsigned char)((spatial && c->rolling > 0) ? 2 : 0)};
  const int rows = 1 + r->rows[i].tangent + r->rows[i].torsion + r->rows[i].rolling;
  r->row_start[i] = *row;
  r->jac_start[i] = *at;
  r->body[2 * i] = c->a;
  r->body[2 * i + 1] = c->b;
  *at += contact_jacobian(r, c, r->rows[i], r->jac + *at);
  for (int k = 0; k < rows; k++) {
    r->drift[*row + k] = (k == 1) ? -c->belt : 0;
  }
  *row += rows;
  r->id[i] = (uint64_t)i + 1;
  double gap = 0;
  for (int k = 0; k < 3; k++) {
    const double xa = r->x[c->a][k] + c->ra[k];
    const double xb = (c->b >= 0) ? r->x[c->b][k] + c->rb[k] : c->rb[k];
    gap += c->n[k] * (xa - xb);
    r->frame[9 * i + k] = c->n[k];
    r->frame[9 * i + 3 + k] = c->t1[k];
    r->frame[9 * i + 6 + k] = c->t2[k];
  }
  r->gap[i] = gap;
  r->mu_s[i] = c->mu;
  r->mu_k[i] = c->mu_k;
  r->torsion[i] = c->torsion;
  r->rolling[i] = c->rolling;
  r->e[i] = c->e;
}

void rig_pin(rig *r, int a, int b, const double *ra, const double *rb) {
  rig_joint *j = &r->joint[r->n_joint++];
  j->a = a;
  j->b = b;
  memcpy(j->ra, ra, sizeof j->ra);
  memcpy(j->rb, rb, sizeof j->rb);
}

static void fill_joint(rig *r, int i, int *row, int *at) {
  const rig_joint *j = &r->joint[i];
  const int g = r->n_contact + i;
  r->row_start[g] = *row;
  r->jac_start[g] = *at;
  r->body[2 * g] = j->a;
  r->body[2 * g + 1] = j->b;
  for (int side = 0; side < 2; side++) {
    for (int k = 0; k < r->dim && (side == 0 || j->b >= 0); k++) {
      const double e[3] = {k == 0, k == 1, k == 2};
      row_of(r, e, (side == 0) ? j->ra : j->rb, (side == 0) ? 1 : -1, r->jac + *at);
      *at += dofs(r);
    }
  }
  for (int k = 0; k < r->dim; k++) {
    const double xb = (j->b >= 0) ? r->x[j->b][k] : 0;
    r->drift[*row] = 0;
    r->error[*row - r->row_start[r->n_contact]] = r->x[j->a][k] + j->ra[k] - xb - j->rb[k];
    (*row)++;
  }
}

static void velocities(const rig *r, const double *v, double *u) {
  const int n = dofs(r);
  for (int i = 0; i < r->n_contact + r->n_joint; i++) {
    const double *jac = r->jac + r->jac_start[i];
    const int rows = r->row_start[i + 1] - r->row_start[i];
    for (int k = 0; k < rows; k++) {
      u[r->row_start[i] + k] = r->drift[r->row_start[i] + k];
    }
    for (int side = 0; side < 2; side++) {
      const int b = r->body[2 * i + side];
      for (int k = 0; k < rows && b >= 0; k++) {
        for (int d = 0; d < n; d++) {
          u[r->row_start[i] + k] += jac[k * n + d] * v[n * b + d];
        }
      }
      jac += (b >= 0) ? rows * n : 0;
    }
  }
}

const contact_set *rig_set(rig *r) {
  fill_bodies(r);
  int row = 0;
  int at = 0;
  for (int i = 0; i < r->n_contact; i++) {
    fill_contact(r, i, &row, &at);
  }
  r->row_start[r->n_contact] = row;
  for (int i = 0; i < r->n_joint; i++) {
    fill_joint(r, i, &row, &at);
  }
  r->row_start[r->n_contact + r->n_joint] = row;
  r->jac_start[r->n_contact + r->n_joint] = at;
  memcpy(r->v_start, r->v, sizeof r->v);
  velocities(r, r->v, r->before);
  r->set = (contact_set){.dim = r->dim,
                         .h = r->h,
                         .t = r->t,
                         .tol = 1e-9,
                         .n_body = r->n_body,
                         .n_dof = dofs(r) * r->n_body,
                         .dof_start = r->dof_start,
                         .mass_start = r->mass_start,
                         .mass = r->M,
                         .inv_mass = r->W,
                         .v = r->v_start,
                         .v_free = r->v_free,
                         .n_contact = r->n_contact,
                         .n_group = r->n_contact + r->n_joint,
                         .n_row = row,
                         .row_start = r->row_start,
                         .body = r->body,
                         .jac_start = r->jac_start,
                         .jac = r->jac,
                         .u_drift = r->drift,
                         .u_before = r->before,
                         .u_curve = r->curve,
                         .id = r->id,
                         .rows = r->rows,
                         .gap = r->gap,
                         .mu_static = r->mu_s,
                         .mu_kinetic = r->mu_k,
                         .mu_torsion = r->torsion,
                         .mu_rolling = r->rolling,
                         .restitution = r->e,
                         .frame = r->frame,
                         .spin = r->spin,
                         .joint_error = r->error};
  return &r->set;
}

void rig_step(rig *r, formulation_run *run) {
  base_error err = {0};
  if (formulation_begin(run, rig_set(r), FORM_COLD, &err) != BASE_OK) {
    printf("# %s\n", err.text);
    abort();
  }
  for (;;) {
    lcp_problem p;
    const double *z0;
    bool pending;
    if (formulation_assemble(run, &p, &z0, &pending, &err) != BASE_OK || !pending) {
      break;
    }
    double *z = calloc((size_t)p.M.n + 1, sizeof *z);
    bool plain = true;
    for (int k = 0; k < p.n_block; k++) {
      plain = plain && (p.block[k].set == LCP_ORTHANT || p.block[k].set == LCP_FREE);
    }
    const lcp_outcome out = plain ? tableau_solve(&p, z) : relax_solve(&p, z, 1e-13);
    r->solves++;
    formulation_recover(run, z, out, &err);
    free(z);
  }
  formulation_answer_of(run, &r->answer);
  memcpy(r->v, r->answer.v_next, (size_t)r->set.n_dof * sizeof *r->v);
  for (int b = 0; b < r->n_body; b++) {
    for (int k = 0; k < r->dim; k++) {
      r->x[b][k] += r->h * r->v[dofs(r) * b + k];
    }
  }
  r->t += r->h;
}

double rig_kinetic(const rig *r) {
  double e = 0;
  const int n = dofs(r);
  for (int b = 0; b < r->n_body; b++) {
    for (int k = 0; k < n; k++) {
      e += 0.5 * r->M[n * n * b + k * n + k] * r->v[n * b + k] * r->v[n * b + k];
    }
  }
  return e;
}

rig *rig_box(int dim, double h, double mu, double incline) {
  rig *r = rig_new(dim, h);
  const int up = dim - 1;
  r->gravity[0] = 9.81 * sin(incline);
  r->gravity[up] = -9.81 * cos(incline);
  const int b = rig_body(r, 2, 0.1, 0.1, 0.1);
  r->x[b][up] = 0.1;
  const double n[3] = {0, dim == 2, dim == 3};
  const double ground[3] = {0, 0, 0};
  for (int k = 0; k < (dim == 2 ? 2 : 4); k++) {
    const double x = (k & 1) ? 0.2 : -0.2;
    const double y = (k & 2) ? 0.2 : -0.2;
    const double ra[3] = {x, (dim == 2) ? -0.1 : y, (dim == 2) ? 0 : -0.1};
    rig_touch(r, b, -1, ra, ground, n, mu);
  }
  return r;
}

rig *rig_stack(int n, double h, double mu) {
  rig *r = rig_new(3, h);
  r->gravity[2] = -9.81;
  const double up[3] = {0, 0, 1};
  const double ground[3] = {0, 0, 0};
  for (int i = 0; i < n; i++) {
    const int b = rig_body(r, 1, 1.0 / 6, 1.0 / 6, 1.0 / 6);
    r->x[b][2] = 0.5 + i;
    for (int k = 0; k < 4; k++) {
      const double low[3] = {(k & 1) ? 0.5 : -0.5, (k & 2) ? 0.5 : -0.5, -0.5};
      const double high[3] = {low[0], low[1], 0.5};
      rig_touch(r, b, b - 1, low, (b == 0) ? ground : high, up, mu);
    }
  }
  return r;
}

rig *rig_random(uint64_t seed, int dim, double mu_most) {
  base_rng g = base_rng_seeded(seed);
  rig *r = rig_new(dim, 0.01);
  const int bodies = 1 + (int)base_rng_between(&g, 0, 3);
  for (int b = 0; b < bodies; b++) {
    rig_body(r, base_rng_between(&g, 0.2, 3), base_rng_between(&g, 0.05, 1),
             base_rng_between(&g, 0.05, 1), base_rng_between(&g, 0.05, 1));
    for (int k = 0; k < dofs(r); k++) {
      r->v[dofs(r) * b + k] = base_rng_between(&g, -1, 1);
    }
  }
  const int contacts = 1 + (int)base_rng_between(&g, 0, 6);
  for (int i = 0; i < contacts; i++) {
    double ra[3] = {0};
    double rb[3] = {0};
    double n[3] = {0};
    double length = 0;
    for (int k = 0; k < dim; k++) {
      ra[k] = base_rng_between(&g, -1, 1);
      rb[k] = base_rng_between(&g, -1, 1);
      n[k] = base_rng_normal(&g);
      length += n[k] * n[k];
    }
    const int a = (int)base_rng_between(&g, 0, bodies);
    const int b = (int)base_rng_between(&g, -1, bodies);
    for (int k = 0; k < dim; k++) {
      n[k] /= sqrt(length);
      rb[k] = (b < 0 || b == a) ? ra[k] : rb[k] + 0;
    }
    const int other = (b == a) ? -1 : b;
    for (int k = 0; k < dim && other >= 0; k++) {
      rb[k] = ra[k]; /* bodies share their origin: touching at the same point */
    }
    rig_touch(r, a, other, ra, rb, n, base_rng_between(&g, 0.01, mu_most));
  }
  return r;
}

struct rig_run {
  formulation_run *run;
  void *opt;
};
static struct rig_run runs[64];

formulation_run *rig_open(const char *name, const char *options) {
  const formulation *f = formulation_find(name);
  base_error err = {0};
  if (f == NULL) {
    printf("# no formulation %s\n", name);
    abort();
  }
  void *opt = calloc(1, f->options_size + 1);
  base_fields_default(f->fields, f->n_fields, opt);
  formulation_run *run = NULL;
  if (base_fields_parse(f->fields, f->n_fields, opt, options, &err) != BASE_OK ||
      formulation_open(&run, f, opt, &err) != BASE_OK) {
    printf("# %s\n", err.text);
    abort();
  }
  for (int i = 0; i < 64; i++) {
    if (runs[i].run == NULL) {
      runs[i] = (struct rig_run){run, opt};
      return run;
    }
  }
  abort();
}

void rig_close(formulation_run *run) {
  for (int i = 0; i < 64; i++) {
    if (runs[i].run == run) {
      formulation_close(run);
      free(runs[i].opt);
      runs[i] = (struct rig_run){0};
    }
  }
}
