#include "tests/support/few_bodies.h"

#include "lcp/base/rng.h"

#include <math.h>

enum { DOF = 6, ARRAYS = 14 };

typedef struct frame {
  double axis[3][3]; /* normal, two tangents */
  double arm[2][3];
} frame;

static void cross(const double *a, const double *b, double *c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

static void normalise(double *a) {
  const double length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
  for (int i = 0; i < 3; ++i) {
    a[i] /= length;
  }
}

static frame draw_frame(base_rng *r, int bodies) {
  frame f = {0};
  double *n = f.axis[0];
  for (int i = 0; i < 3; ++i) {
    n[i] = (bodies == 1) ? (i == 2) : base_rng_normal(r);
  }
  normalise(n);
  const double helper[3] = {fabs(n[0]) < 0.8, fabs(n[0]) >= 0.8, 0};
  cross(n, helper, f.axis[1]);
  normalise(f.axis[1]);
  cross(n, f.axis[1], f.axis[2]);
  for (int i = 0; i < 3; ++i) {
    const double reach = (bodies == 1) ? ((i == 2) ? 0 : 1) : 0.3;
    const double centre = (bodies == 1) ? ((i == 2) ? -0.5 : 0) : -n[i];
    f.arm[0][i] = centre + reach * base_rng_between(r, -1, 1);
    f.arm[1][i] = n[i] + reach * base_rng_between(r, -1, 1);
  }
  return f;
}

/* Row of one side: direction, arm x direction. */
static void jacobian_row(const double *arm, const double *dir, double sign, double *row) {
  double moment[3];
  cross(arm, dir, moment);
  for (int i = 0; i < 3; ++i) {
    row[i] = sign * dir[i];
    row[3 + i] = sign * moment[i];
  }
}

typedef struct arrays {
  int *dof_start, *weight_start, *row_start, *body, *jac_start, *colptr, *rowind;
  double *weight, *jac, *q, *v, *val;
} arrays;

static void draw_bodies(arrays *a, int bodies, base_rng *r) {
  for (int b = 0; b < bodies; ++b) {
    const double inverse_mass = base_rng_between(r, 0.5, 2);
    a->dof_start[b + 1] = DOF * (b + 1);
    a->weight_start[b + 1] = DOF * DOF * (b + 1);
    for (int i = 0; i < DOF; ++i) {
      a->weight[DOF * DOF * b + (DOF + 1) * i] =
          inverse_mass * ((i < 3) ? 1 : base_rng_between(r, 4, 8));
      a->v[DOF * b + i] = (i < 3) ? base_rng_between(r, -0.05, 0.05)
                                  : (bodies > 1) * base_rng_between(r, -0.1, 0.1);
    }
    a->v[DOF * b + 2] = -0.1;
  }
}

static void draw_contact(arrays *a, int c, int bodies, int facets, base_rng *r) {
  const int rows = (facets > 0) ? facets + 2 : 1;
  const frame f = draw_frame(r, bodies);
  const int first = c % bodies;
  const bool ground = bodies == 1 || base_rng_uniform(r) < 0.3;
  const int other = (int)(base_rng_uniform(r) * bodies);
  int *body = a->body + 2 * (ptrdiff_t)c;
  double *jac = a->jac + a->jac_start[c];
  body[0] = first;
  body[1] = (ground || other == first) ? -1 : other;
  a->row_start[c + 1] = rows * (c + 1);
  a->jac_start[c + 1] = a->jac_start[c] + rows * DOF * ((body[1] < 0) ? 1 : 2);
  for (int side = 0; side < 2 && body[side] >= 0; ++side) {
    for (int k = 0; k <= facets; ++k) {
      const double angle = (facets > 0) ? 2 * acos(-1.0) * (k - 1) / facets : 0;
      double dir[3];
      double *row = jac + DOF * (rows * side + k);
      for (int i = 0; i < 3; ++i) {
        dir[i] = (k == 0) ? f.axis[0][i] : cos(angle) * f.axis[1][i] + sin(angle) * f.axis[2][i];
      }
      jacobian_row(f.arm[side], dir, (side == 0) ? 1 : -1, row);
      for (int i = 0; i < DOF; ++i) {
        a->q[rows * c + k] += row[i] * a->v[DOF * body[side] + i];
      }
    }
  }
}

/* S: sigma in the facet rows, mu r_n - sum r_k in the last row. */
static void fill_shift(arrays *a, int contacts, int facets) {
  const int rows = facets + 2;
  int at = 0;
  for (int j = 0; j < rows * contacts; ++j) {
    const int first = j / rows * rows;
    const int k = j % rows;
    a->colptr[j] = at;
    for (int i = 1; k == rows - 1 && i <= facets; ++i) {
      a->rowind[at] = first + i;
      a->val[at++] = 1;
    }
    if (k < rows - 1) {
      a->rowind[at] = first + rows - 1;
      a->val[at++] = (k == 0) ? 0.5 : -1;
    }
  }
  a->colptr[rows * contacts] = at;
}

base_status few_bodies(known_lcp *k, int bodies, int contacts, int facets, uint64_t seed,
                       base_error *err) {
  const int rows = (facets > 0) ? facets + 2 : 1;
  const int n = rows * contacts;
  const size_t shift = (facets > 0) ? (size_t)contacts * (size_t)(2 * facets + 1) : 1;
  base_rng r = base_rng_seeded(seed);
  *k = (known_lcp){.answer = KNOWN_UNSTATED};
  arrays a = {.dof_start = KNOWN_ARRAY(k, int, bodies + 1),
              .weight_start = KNOWN_ARRAY(k, int, bodies + 1),
              .row_start = KNOWN_ARRAY(k, int, contacts + 1),
              .body = KNOWN_ARRAY(k, int, 2 * contacts),
              .jac_start = KNOWN_ARRAY(k, int, contacts + 1),
              .colptr = KNOWN_ARRAY(k, int, n + 1),
              .rowind = KNOWN_ARRAY(k, int, shift),
              .weight = KNOWN_ARRAY(k, double, DOF *DOF *bodies),
              .jac = KNOWN_ARRAY(k, double, 2 * DOF * n),
              .q = KNOWN_ARRAY(k, double, n),
              .v = KNOWN_ARRAY(k, double, DOF *bodies),
              .val = KNOWN_ARRAY(k, double, shift)};
  lcp_factored *f = KNOWN_ARRAY(k, lcp_factored, 1);
  lcp_csc *S = KNOWN_ARRAY(k, lcp_csc, 1);
  if (k->n_owned < ARRAYS) {
    return BASE_FAIL(err, BASE_ENOMEM, "few_bodies: no memory for %d contacts", contacts);
  }
  draw_bodies(&a, bodies, &r);
  for (int c = 0; c < contacts; ++c) {
    draw_contact(&a, c, bodies, facets, &r);
  }
  if (facets > 0) {
    fill_shift(&a, contacts, facets);
    *S = (lcp_csc){n, n, a.colptr, a.rowind, a.val};
  }
  *f = (lcp_factored){.n_body = bodies,
                      .dof_start = a.dof_start,
                      .weight_start = a.weight_start,
                      .weight = a.weight,
                      .n_group = contacts,
                      .row_start = a.row_start,
                      .body = a.body,
                      .jac_start = a.jac_start,
                      .jac = a.jac,
                      .shift = (facets > 0) ? S : NULL};
  k->p = (lcp_problem){.M = {.storage = LCP_FACTORED, .n = n, .factored = f}, .q = a.q};
  k->p.traits = (facets > 0) ? LCP_COPOSITIVE
                             : LCP_SYMMETRIC | LCP_PSD | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  return BASE_OK;
}
