/* tests/support/shapes_any.h - pieces at random poses, and the motion of a gap point. */
#pragma once

#include "lcp/base/rng.h"
#include "problems/geometry/shapes.h"
#include "problems/vec.h"

typedef struct any_piece {
  piece p;
  double vertex[3 * SPEC_VERTICES];
} any_piece;

static inline void any_shape(any_piece *out, const spec_shape *s, int dim) {
  double *v = out->vertex;
  shape_split(s, dim, &out->p, &v);
}

/* Uniform orientation (planar: angle), position in a cube of half width `spread`. */
static inline void any_quat(base_rng *r, int dim, double q[4]) {
  for (int k = 0; k < 4; k++) {
    q[k] = (dim == 3 || k == 0 || k == 3) ? base_rng_normal(r) : 0.0;
  }
  quat_normalise(q);
}

static inline pose any_pose(const double *x, const double *q) {
  pose p;
  v3_copy(x, p.x);
  quat_matrix(q, p.R);
  return p;
}

/* A body state that can be moved by a twist (v, w) for a time. */
typedef struct mover {
  double x[3], q[4], v[3], w[3];
} mover;

static inline mover any_mover(base_rng *r, int dim, double spread) {
  mover m = {{0}, {0}, {0}, {0}};
  any_quat(r, dim, m.q);
  for (int k = 0; k < 3; k++) {
    const int planar = dim == 2;
    m.x[k] = (planar && k == 2) ? 0.0 : base_rng_between(r, -spread, spread);
    m.v[k] = (planar && k == 2) ? 0.0 : base_rng_between(r, -1, 1);
    m.w[k] = (planar && k < 2) ? 0.0 : base_rng_between(r, -1, 1);
  }
  return m;
}

static inline pose mover_at(const mover *m, double t) {
  double x[3], q[4];
  v3_add_scaled(m->x, t, m->v, x);
  memcpy(q, m->q, sizeof q);
  quat_rotate(q, m->w, t);
  return any_pose(x, q);
}

/* n . (v_a(x) - v_b(x)); b may be NULL (at rest). */
static inline double mover_rate(const mover *a, const mover *b, const double *x, const double *n) {
  double arm[3], c[3];
  v3_sub(x, a->x, arm);
  v3_cross(a->w, arm, c);
  double rate = v3_dot(n, a->v) + v3_dot(n, c);
  if (b != NULL) {
    v3_sub(x, b->x, arm);
    v3_cross(b->w, arm, c);
    rate -= v3_dot(n, b->v) + v3_dot(n, c);
  }
  return rate;
}
