#include "tests/support/random_cones.h"

#include "lcp/base/rng.h"

#include <math.h>
#include <string.h>

enum { DOF = 6, BODIES = 10, CONTACTS = 48, ROWS = 6 };

typedef struct contact {
  int body[2];
  double axis[3][3]; /* normal, two tangents */
  double arm[2][3];
} contact;

typedef struct recipe {
  base_rng r;
  int bodies, contacts;
  double mu_top, spread; /* largest mu; decades of mass */
  bool rolling;
} recipe;

static void cross(const double *a, const double *b, double *c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

/* Tangents for a normal that need not have length one. */
static void frame(contact *c) {
  double *n = c->axis[0];
  const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  for (int i = 0; i < 3; i++) {
    n[i] /= length;
  }
  const double helper[3] = {fabs(n[0]) < 0.8, fabs(n[0]) >= 0.8, 0};
  cross(n, helper, c->axis[1]);
  const double *t = c->axis[1];
  const double size = sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
  for (int i = 0; i < 3; i++) {
    c->axis[1][i] /= size;
  }
  cross(n, c->axis[1], c->axis[2]);
}

static contact draw(recipe *s, const contact *earlier, int count) {
  contact c = {.body = {count % s->bodies, -1}};
  if (count > 0 && base_rng_uniform(&s->r) < 0.25) { /* a copy, exact or nearly */
    c = earlier[(int)(base_rng_uniform(&s->r) * count)];
    const double off =
        (base_rng_uniform(&s->r) < 0.5) ? 0.0 : pow(10.0, -base_rng_between(&s->r, 3.0, 9.0));
    for (int i = 0; i < 3; i++) {
      c.axis[0][i] += off * base_rng_normal(&s->r);
      c.arm[0][i] += off * base_rng_normal(&s->r);
      c.arm[1][i] += off * base_rng_normal(&s->r);
    }
    frame(&c);
    return c;
  }
  const int other = (int)(base_rng_uniform(&s->r) * s->bodies);
  const bool ground = base_rng_uniform(&s->r) < 0.4 || other == c.body[0];
  c.body[1] = ground ? -1 : other;
  for (int i = 0; i < 3; i++) {
    c.axis[0][i] = base_rng_normal(&s->r) * (ground && i < 2 ? 0.2 : 1.0);
  }
  c.axis[0][2] = ground ? fabs(c.axis[0][2]) + 0.1 : c.axis[0][2];
  frame(&c);
  for (int i = 0; i < 3; i++) {
    c.arm[0][i] = -c.axis[0][i] + 0.5 * base_rng_between(&s->r, -1, 1);
    c.arm[1][i] = c.axis[0][i] + 0.5 * base_rng_between(&s->r, -1, 1);
  }
  return c;
}

/* Rows of one side: normal and tangents as forces, then torsion and rolling as moments. */
static void jacobian(const contact *c, int rows, int side, double *row) {
  const double sign = (side == 0) ? 1.0 : -1.0;
  for (int k = 0; k < rows; k++, row += DOF) {
    const double *dir = c->axis[k % 3];
    double moment[3];
    cross(c->arm[side], dir, moment);
    for (int i = 0; i < 3; i++) {
      row[i] = (k < 3) ? sign * dir[i] : 0.0;
      row[3 + i] = sign * ((k < 3) ? moment[i] : dir[i]);
    }
  }
}

static lcp_block draw_block(recipe *s, int start) {
  const double mu = (base_rng_uniform(&s->r) < 0.1) ? 0.0 : s->mu_top * base_rng_uniform(&s->r);
  lcp_block b = {.start = start,
                 .size = 3,
                 .set = LCP_CONE,
                 .n_part = 1,
                 .part_dim = {2, 1, 2},
                 .part_mu = {mu}};
  if (s->rolling && base_rng_uniform(&s->r) < 0.5) {
    b.size = 6;
    b.n_part = 3;
    b.part_mu[1] = 0.1 * base_rng_uniform(&s->r);
    b.part_mu[2] = 0.1 * base_rng_uniform(&s->r);
  }
  return b;
}

static recipe draw_recipe(uint64_t seed) {
  recipe s = {.r = base_rng_seeded(seed)};
  s.bodies = 1 + (int)(base_rng_uniform(&s.r) * BODIES);
  s.contacts = 1 + (int)(base_rng_uniform(&s.r) * CONTACTS);
  s.spread = (seed % 2 == 0) ? 0.0 : base_rng_between(&s.r, 0.0, 6.0);
  s.mu_top = (seed % 3 == 0) ? 10.0 : 1.0;
  s.rolling = seed % 3 == 1;
  return s;
}

typedef struct arrays {
  int *dof_start, *weight_start, *row_start, *body, *jac_start;
  double *weight, *jac, *q, *v;
  lcp_block *block;
} arrays;

static void fill_bodies(recipe *s, const arrays *a) {
  for (int b = 0; b < s->bodies; b++) {
    const double mass = pow(10.0, s->spread * base_rng_uniform(&s->r));
    a->dof_start[b + 1] = DOF * (b + 1);
    a->weight_start[b + 1] = DOF * DOF * (b + 1);
    for (int i = 0; i < DOF; i++) {
      a->weight[DOF * DOF * b + (DOF + 1) * i] =
          ((i < 3) ? 1.0 : base_rng_between(&s->r, 2.0, 8.0)) / mass;
      a->v[DOF * b + i] = base_rng_between(&s->r, -0.1, 0.1) - ((i == 2) ? 0.1 : 0.0);
    }
  }
}

static void fill_contacts(recipe *s, const arrays *a) {
  contact list[CONTACTS];
  for (int c = 0; c < s->contacts; c++) {
    list[c] = draw(s, list, c);
    a->block[c] = draw_block(s, a->row_start[c]);
    const int rows = a->block[c].size, first = a->row_start[c];
    a->row_start[c + 1] = first + rows;
    memcpy(a->body + 2 * (ptrdiff_t)c, list[c].body, sizeof list[c].body);
    double *jac = a->jac + a->jac_start[c];
    for (int side = 0; side < 2 && list[c].body[side] >= 0; side++, jac += DOF * rows) {
      jacobian(&list[c], rows, side, jac);
      for (int k = 0; k < rows * DOF; k++) {
        a->q[first + k / DOF] += jac[k] * a->v[DOF * list[c].body[side] + k % DOF];
      }
    }
    a->q[first] += (base_rng_uniform(&s->r) < 0.3) ? base_rng_between(&s->r, 0.0, 0.1) : 0.0;
    a->jac_start[c + 1] = (int)(jac - a->jac);
  }
}

base_status random_cones(known_lcp *k, uint64_t seed, base_error *err) {
  recipe s = draw_recipe(seed);
  *k = (known_lcp){.answer = KNOWN_UNSTATED};
  const arrays a = {.dof_start = KNOWN_ARRAY(k, int, BODIES + 1),
                    .weight_start = KNOWN_ARRAY(k, int, BODIES + 1),
                    .row_start = KNOWN_ARRAY(k, int, CONTACTS + 1),
                    .body = KNOWN_ARRAY(k, int, 2 * CONTACTS),
                    .jac_start = KNOWN_ARRAY(k, int, CONTACTS + 1),
                    .weight = KNOWN_ARRAY(k, double, DOF *DOF *BODIES),
                    .jac = KNOWN_ARRAY(k, double, 2 * DOF * ROWS * CONTACTS),
                    .q = KNOWN_ARRAY(k, double, ROWS *CONTACTS),
                    .v = KNOWN_ARRAY(k, double, DOF *BODIES),
                    .block = KNOWN_ARRAY(k, lcp_block, CONTACTS)};
  lcp_factored *f = KNOWN_ARRAY(k, lcp_factored, 1);
  if (f == NULL || k->n_owned < 11) {
    return BASE_FAIL(err, BASE_ENOMEM, "random_cones: no memory");
  }
  fill_bodies(&s, &a);
  fill_contacts(&s, &a);
  *f = (lcp_factored){.n_body = s.bodies,
                      .dof_start = a.dof_start,
                      .weight_start = a.weight_start,
                      .weight = a.weight,
                      .n_group = s.contacts,
                      .row_start = a.row_start,
                      .body = a.body,
                      .jac_start = a.jac_start,
                      .jac = a.jac};
  k->p = (lcp_problem){.M = {.storage = LCP_FACTORED, .n = a.row_start[s.contacts], .factored = f},
                       .q = a.q,
                       .block = a.block,
                       .n_block = s.contacts,
                       .traits = LCP_SYMMETRIC | LCP_PSD};
  return BASE_OK;
}
