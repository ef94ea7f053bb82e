#include "problems/world/contact_merit.h"

#include "lcp/base/crew.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PARTS = 3, MOST_ROWS = 8 };

/* The cone of one contact: parts at rows 1.., each |l_part| <= mu l_n. Torsion and rolling are
 * measured at the arm of their coefficient, which turns them into impulses and speeds with mu = 1. */
typedef struct cone {
  int n_row, n_part;
  int row[PARTS], dim[PARTS];
  double mu[PARTS], arm[PARTS];
} cone;

static cone cone_of(const contact_set *c, int i, double mu) {
  const contact_rows rows = c->rows[i];
  const int dims[PARTS] = {rows.tangent, rows.torsion, rows.rolling};
  cone k = {.n_row = 1};
  for (int p = 0; p < PARTS; p++) {
    if (dims[p] == 0) {
      continue;
    }
    k.row[k.n_part] = k.n_row;
    k.dim[k.n_part] = dims[p];
    k.mu[k.n_part] = (p == 0) ? mu : 1;
    k.arm[k.n_part] = (p == 0) ? 1 : ((p == 1) ? c->mu_torsion[i] : c->mu_rolling[i]);
    k.n_row += dims[p];
    k.n_part++;
  }
  return k;
}

static double norm(const double *x, int n) {
  double sum = 0;
  for (int k = 0; k < n; k++) {
    sum += x[k] * x[k];
  }
  return sqrt(sum);
}

/* Projection onto K: for a given normal component s each part is pulled back to its disc, and
 * s minimises (s - x_n)^2 + sum max(0, |x_p| - mu_p s)^2, which is piecewise quadratic. The
 * stationary point is found by adding the parts that are outside in the order in which they
 * leave. */
static void project(const cone *k, double *x) {
  double reach[PARTS];
  for (int p = 0; p < k->n_part; p++) {
    reach[p] = norm(x + k->row[p], k->dim[p]);
  }
  double s = x[0];
  for (int round = 0; round <= k->n_part; round++) { /* active parts only ever change once each */
    double up = x[0];
    double down = 1;
    for (int p = 0; p < k->n_part; p++) {
      if (reach[p] > k->mu[p] * s) {
        up += k->mu[p] * reach[p];
        down += k->mu[p] * k->mu[p];
      }
    }
    s = up / down;
  }
  s = fmax(s, 0.0);
  x[0] = s;
  for (int p = 0; p < k->n_part; p++) {
    if (reach[p] > k->mu[p] * s) {
      for (int m = 0; m < k->dim[p]; m++) {
        x[k->row[p] + m] *= k->mu[p] * s / reach[p];
      }
    }
  }
}

/* Natural map of one contact at friction mu. */
static double natural_map(const contact_set *c, int i, double mu, double a, double bias,
                          const double *l, const double *u) {
  const cone k = cone_of(c, i, mu);
  double x[MOST_ROWS];
  double al[MOST_ROWS];
  al[0] = a * l[0];
  x[0] = al[0] - u[0] - bias;
  for (int p = 0; p < k.n_part; p++) {
    const double *up = u + k.row[p];
    x[0] -= k.mu[p] * k.arm[p] * norm(up, k.dim[p]);
    for (int m = 0; m < k.dim[p]; m++) {
      al[k.row[p] + m] = a * l[k.row[p] + m] / k.arm[p];
      x[k.row[p] + m] = al[k.row[p] + m] - k.arm[p] * up[m];
    }
  }
  project(&k, x);
  for (int m = 0; m < k.n_row; m++) {
    x[m] -= al[m];
  }
  return norm(x, k.n_row);
}

static void judge_contact(const contact_set *c, int i, double bias, const double *l,
                          const double *u, contact_merit *out) {
  const double a = contact_mobility(c, i, 0);
  const double mu = c->mu_static[i];
  /* between mu_k and mu_s the law has two branches: sticking up to mu_s, sliding at mu_k */
  const double stick = natural_map(c, i, mu, a, bias, l, u);
  const double slide = natural_map(c, i, c->mu_kinetic[i], a, bias, l, u);
  out->ncp = fmax(out->ncp, fmin(stick, slide));
  out->normal = fmax(out->normal, fabs(fmin(a * l[0], u[0] + bias)));
  const cone k = cone_of(c, i, (slide < stick) ? c->mu_kinetic[i] : mu);
  for (int p = 0; p < k.n_part; p++) {
    const double *lp = l + k.row[p];
    const double *up = u + k.row[p];
    const double limit = k.mu[p] * k.arm[p] * fmax(l[0], 0.0);
    out->cone = fmax(out->cone, (norm(lp, k.dim[p]) - limit) / k.arm[p]);
    double power = limit * norm(up, k.dim[p]);
    for (int m = 0; m < k.dim[p]; m++) {
      power += lp[m] * up[m];
    }
    out->dissipation += power;
  }
}

/* force += J_g' l of one group. */
static void push(const contact_set *c, int g, const double *l, double *force) {
  const double *jac = c->jac + c->jac_start[g];
  const int rows = c->row_start[g + 1] - c->row_start[g];
  for (int side = 0; side < 2; side++) {
    const int b = c->body[2 * g + side];
    const int n = (b < 0) ? 0 : c->dof_start[b + 1] - c->dof_start[b];
    for (int r = 0; r < rows; r++) {
      for (int k = 0; k < n; k++) {
        force[c->dof_start[b] + k] += jac[r * n + k] * l[r];
      }
    }
    jac += (ptrdiff_t)rows * n;
  }
}

/* || M (v+ - v_free) - J' l || over the largest of || M v_free ||, || J' l ||. */
static double momentum_residual(const contact_set *c, const double *impulse, const double *v_next,
                                double *force) {
  memset(force, 0, (size_t)c->n_dof * sizeof *force);
  for (int g = 0; g < c->n_group; g++) {
    push(c, g, impulse + c->row_start[g], force);
  }
  double off = 0;
  double pushed = norm(force, c->n_dof);
  double carried = 0;
  for (int b = 0; b < c->n_body; b++) {
    const int start = c->dof_start[b];
    const int n = c->dof_start[b + 1] - start;
    const double *mass = c->mass + c->mass_start[b];
    for (int k = 0; k < n; k++) {
      double change = 0;
      double free = 0;
      for (int m = 0; m < n; m++) {
        change += mass[m * n + k] * (v_next[start + m] - c->v_free[start + m]);
        free += mass[m * n + k] * c->v_free[start + m];
      }
      off += (change - force[start + k]) * (change - force[start + k]);
      carried += free * free;
    }
  }
  const double scale = fmax(sqrt(carried), pushed);
  return (scale > 0) ? sqrt(off) / scale : 0;
}

/* The largest || v+ || + || v_free || of a body. */
static double fastest_body(const contact_set *c, const double *v_next) {
  double most = 0;
  for (int b = 0; b < c->n_body; b++) {
    const int d = c->dof_start[b];
    most =
        fmax(most, norm(v_next + d, contact_dofs(c, b)) + norm(c->v_free + d, contact_dofs(c, b)));
  }
  return most;
}

/* Joint rows of the step: how far from kept. */
static void judge_joints(const contact_set *c, const double *v_next, const double *u,
                         contact_merit *out) {
  const int first = c->row_start[c->n_contact];
  const double fastest = (c->n_group > c->n_contact) ? fastest_body(c, v_next) : 0;
  double speed = 0, beyond = 0;
  for (int g = c->n_contact; g < c->n_group; g++) {
    const double *jac = c->jac + c->jac_start[g];
    const int rows = c->row_start[g + 1] - c->row_start[g];
    const int n[2] = {contact_dofs(c, c->body[2 * g]), contact_dofs(c, c->body[2 * g + 1])};
    for (int r = 0; r < rows; r++) {
      const int row = c->row_start[g] + r;
      const double *of_side[2] = {jac + (ptrdiff_t)r * n[0],
                                  jac + (ptrdiff_t)rows * n[0] + (ptrdiff_t)r * n[1]};
      const double may = fabs(c->joint_error[row - first]) / c->h +
                         ((c->u_curve != NULL) ? fabs(c->u_curve[row]) : 0);
      out->joint = fmax(out->joint, fabs(u[row]));
      beyond = fmax(beyond, fabs(u[row]) - may);
      speed = fmax(speed, (norm(of_side[0], n[0]) + norm(of_side[1], n[1])) * fastest +
                              fabs(c->u_drift[row]));
    }
  }
  out->joint_rel = (speed > 0) ? beyond / speed : 0;
}

/* Of CONTACT_SHARE contacts. */
typedef struct merit_part {
  contact_merit at;
  double speed, strongest; /* largest mu l_n, or l_n where there is torsion or rolling only */
} merit_part;

typedef struct merits {
  const contact_set *c;
  const double *impulse, *bias, *u, *u_free;
  merit_part *part;
} merits;

static void share_contacts(void *of, int part, int hand) {
  const merits *s = of;
  const contact_set *c = s->c;
  merit_part *m = &s->part[part];
  const int end = base_part_end(part, c->n_contact, CONTACT_SHARE);
  (void)hand;
  *m = (merit_part){0};
  for (int i = part * CONTACT_SHARE; i < end; i++) {
    const int row = c->row_start[i];
    const int n = c->row_start[i + 1] - row;
    bool pushed = false;
    for (int k = 0; k < n; k++) {
      pushed = pushed || s->impulse[row + k] != 0;
      const bool tangent = k <= c->rows[i].tangent;
      const double fastest = fmax(fabs(s->u[row + k]), fabs(s->u_free[row + k]));
      m->speed = fmax(m->speed, tangent ? fastest : 0);
    }
    if (s->bias[i] < HUGE_VAL || pushed) {
      const double b = (s->bias[i] < HUGE_VAL) ? s->bias[i] : 0;
      judge_contact(c, i, b, s->impulse + row, s->u + row, &m->at);
      const cone k = cone_of(c, i, c->mu_static[i]);
      m->strongest = (k.n_part > 0) ? fmax(m->strongest, k.mu[0] * s->impulse[row]) : m->strongest;
    }
  }
}

static void judge_contacts(merits *s, contact_merit *out) {
  const int parts = base_parts(s->c->n_contact, CONTACT_SHARE);
  double speed = 0, strongest = 0;
  base_share(parts, share_contacts, s);
  for (int k = 0; k < parts; k++) {
    const merit_part *m = &s->part[k];
    out->ncp = fmax(out->ncp, m->at.ncp);
    out->normal = fmax(out->normal, m->at.normal);
    out->cone = fmax(out->cone, m->at.cone);
    out->dissipation += m->at.dissipation;
    speed = fmax(speed, m->speed);
    strongest = fmax(strongest, m->strongest);
  }
  out->ncp_rel = (speed > 0) ? out->ncp / speed : 0;
  out->cone_rel = (strongest > 0) ? out->cone / strongest : 0;
}

base_status contact_merit_at(const contact_set *c, const double *impulse, const double *v_next,
                             const double *bias, contact_merit *out, base_error *err) {
  *out = (contact_merit){0};
  const size_t rows = (size_t)c->n_row, parts = (size_t)base_parts(c->n_contact, CONTACT_SHARE);
  double *u = malloc((2 * rows + (size_t)c->n_dof + 1) * sizeof *u + parts * sizeof(merit_part));
  if (u == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "physical residual: no memory for %zu rows", rows);
  }
  double *u_free = u + rows, *force = u_free + rows;
  contact_relative_velocity(c, v_next, c->u_drift, u);
  contact_relative_velocity(c, c->v_free, c->u_drift, u_free);
  merits s = {c, impulse, bias, u, u_free, (merit_part *)(force + c->n_dof + 1)};
  judge_contacts(&s, out);
  judge_joints(c, v_next, u, out);
  out->momentum = momentum_residual(c, impulse, v_next, force);
  free(u);
  return BASE_OK;
}
