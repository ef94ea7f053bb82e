/* round_pair.c - the largest separation of two cores. With the support function h(n) = h(-n) of each in
 * closed form, the separation along a unit normal n from b to a is
 *   s(n) = n . (c_a - c_b) - h_a(n) - h_b(n),   distance = max over n of s(n).
 * The maximum lies at a normal of one of these kinds, which are all tried: normals of faces and caps;
 * normals at right angles to an edge, or to the axis of a disc (one angle each: the roots of s' are
 * bracketed and bisected); from a vertex or end to the nearest point of the disc; rim against rim (two
 * angles, steepest ascent and Newton). Apart, the features nearest to each other are among them; in
 * an overlap the smooth parts of the boundary of the Minkowski difference are, and only there can the
 * shortest way out lie. */
#include "problems/geometry/round_pair.h"

#include "problems/vec.h"

enum { ANGLES = 24 };
static const double pi = 3.14159265358979323846;
static const double ROUNDING = 1e-12; /* a sine below it has no direction */

static void world(const pose *at, const double *local, double *x) {
  m3_mul_vec(at->R, local, x);
  v3_add_scaled(at->x, 1.0, x, x);
}

round_solid round_place(const piece *p, const pose *at) {
  round_solid s = {.disc = p->kind == PIECE_DISC};
  double R[9];
  if (p->kind == PIECE_SEGMENT) {
    double e0[3], e1[3], along[3];
    world(at, p->vertex, e0);
    world(at, p->vertex + 3, e1);
    v3_sub(e1, e0, along);
    s.h[0] = 0.5 * v3_norm(along);
    v3_add_scaled(e0, 0.5, along, s.c);
    v3_scale(0.5 / s.h[0], along, s.e[0]);
    v3_perpendicular(s.e[0], s.e[1]);
    v3_cross(s.e[0], s.e[1], s.e[2]);
    s.sweep = p->r;
    return s;
  }
  m3_mul(at->R, p->rot, R);
  world(at, p->pos, s.c);
  for (int k = 0; k < 3; k++) {
    for (int i = 0; i < 3; i++) {
      s.e[k][i] = R[3 * i + k];
    }
    s.h[k] = (!s.disc || k == 2) ? p->half[k] : 0.0;
  }
  s.r = s.disc ? p->r : 0.0;
  return s;
}

/* The part of n across the axis of a disc; its length. Twice: a small part is at right angles too. */
double round_across(const round_solid *s, const double *n, double *out) {
  v3_add_scaled(n, -v3_dot(n, s->e[2]), s->e[2], out);
  v3_add_scaled(out, -v3_dot(out, s->e[2]), s->e[2], out);
  return v3_norm(out);
}

/* Point of the core, from its centre, that is furthest along n. Where several are, the middle one:
 * `flat` is the sine below which n counts as at right angles. */
void round_support(const round_solid *s, const double *n, double flat, double *out) {
  double t[3];
  out[0] = out[1] = out[2] = 0.0;
  for (int k = 0; k < 3; k++) {
    const double along = v3_dot(n, s->e[k]);
    if (s->h[k] > 0.0 && fabs(along) > flat) {
      v3_add_scaled(out, copysign(s->h[k], along), s->e[k], out);
    }
  }
  const double sine = s->disc ? round_across(s, n, t) : 0.0;
  if (sine > flat) {
    v3_add_scaled(out, s->r / sine, t, out);
  }
}

/* Support function of the core about its centre. */
static double extent(const round_solid *s, const double *n) {
  double t[3], sum = s->disc ? s->r * round_across(s, n, t) : 0.0;
  for (int k = 0; k < 3; k++) {
    sum += s->h[k] * fabs(v3_dot(n, s->e[k]));
  }
  return sum;
}

static double separation(const round_pair *p, const double *n) {
  return v3_dot(n, p->d) - extent(&p->a, n) - extent(&p->b, n);
}

/* Gradient of the separation: from the extreme point of b to that of a. */
static void apart(const round_pair *p, const double *n, double *out) {
  double s[3];
  v3_copy(p->d, out);
  round_support(&p->a, n, ROUNDING, s);
  v3_sub(out, s, out);
  round_support(&p->b, n, ROUNDING, s);
  v3_sub(out, s, out);
}

void round_try(round_pair *p, const double *n) {
  const double s = separation(p, n);
  if (s > p->best) {
    p->best = s;
    v3_copy(n, p->n);
  }
}

static void try_both(round_pair *p, const double *n) {
  double back[3];
  v3_scale(-1.0, n, back);
  round_try(p, n);
  round_try(p, back);
}

/* ---- one angle ------------------------------------------------------------------------------ */

/* Normal and its derivative at an angle of the circle at right angles to an axis. */
void round_circle(const double *u, const double *v, double angle, double *n, double *slope) {
  const double c = cos(angle), s = sin(angle);
  for (int k = 0; k < 3; k++) {
    n[k] = c * u[k] + s * v[k];
    slope[k] = c * v[k] - s * u[k];
  }
}

static double rate(const round_pair *p, const double *u, const double *v, double angle) {
  double n[3], slope[3], g[3];
  round_circle(u, v, angle, n, slope);
  apart(p, n, g);
  return v3_dot(g, slope);
}

/* A maximum between two angles: the slope falls through zero, perhaps in a jump. */
static void bisect(round_pair *p, const double *u, const double *v, double lo, double hi) {
  double n[3], slope[3];
  for (int i = 0; i < 52; i++) {
    const double mid = 0.5 * (lo + hi);
    *(rate(p, u, v, mid) > 0.0 ? &lo : &hi) = mid;
  }
  round_circle(u, v, 0.5 * (lo + hi), n, slope);
  round_try(p, n);
}

static void try_circle(round_pair *p, const double *axis) {
  double u[3], v[3];
  v3_perpendicular(axis, u);
  v3_cross(axis, u, v);
  double before = rate(p, u, v, 0.0);
  for (int i = 0; i < ANGLES; i++) {
    const double hi = 2.0 * pi * (i + 1) / ANGLES, after = rate(p, u, v, hi);
    if (before > 0.0 && after <= 0.0) {
      bisect(p, u, v, hi - 2.0 * pi / ANGLES, hi);
    }
    before = after;
  }
}

/* ---- rim against rim ------------------------------------------------------------------------ */

/* Part of the gradient in the tangent plane at n; its length. */
static double uphill(const round_pair *p, const double *n, double *t) {
  apart(p, n, t);
  v3_add_scaled(t, -v3_dot(t, n), n, t);
  return v3_norm(t);
}

static void newton_step(const round_pair *p, double *n) {
  const double step = 1e-6;
  double g[3], u[3], v[3], H[4];
  const double slope = uphill(p, n, g);
  if (!(slope > 0.0)) {
    return;
  }
  v3_scale(1.0 / slope, g, u);
  v3_cross(n, u, v);
  for (int k = 0; k < 2; k++) {
    double m[3], t[3];
    v3_add_scaled(n, step, k == 0 ? u : v, m);
    v3_scale(1.0 / v3_norm(m), m, m);
    (void)uphill(p, m, t);
    H[k] = (v3_dot(t, u) - slope) / step;
    H[2 + k] = v3_dot(t, v) / step;
  }
  const double det = H[0] * H[3] - H[1] * H[2];
  if (H[0] < 0.0 && det > 0.0) { /* a maximum */
    v3_add_scaled(n, -H[3] * slope / det, u, n);
    v3_add_scaled(n, H[2] * slope / det, v, n);
    v3_scale(1.0 / v3_norm(n), n, n);
  }
}

static void climb(round_pair *p, const double *from) {
  double n[3], g[3];
  v3_copy(from, n);
  for (int i = 0; i < 20; i++) { /* steepest ascent, each time to the top of the great circle */
    const double slope = uphill(p, n, g);
    if (!(slope > 1e-6 * p->size)) {
      break;
    }
    v3_scale(1.0 / slope, g, g);
    double lo = 0.0, hi = 0.05;
    while (hi < 1.5 && rate(p, n, g, hi) > 0.0) {
      lo = hi;
      hi *= 2.0;
    }
    for (int k = 0; k < 40; k++) {
      const double mid = 0.5 * (lo + hi);
      *(rate(p, n, g, mid) > 0.0 ? &lo : &hi) = mid;
    }
    double next[3], slope_there[3];
    round_circle(n, g, 0.5 * (lo + hi), next, slope_there);
    v3_copy(next, n);
  }
  for (int i = 0; i < 6; i++) {
    newton_step(p, n);
  }
  round_try(p, n);
}

/* In an overlap there is a top for each side. */
static void try_rims(round_pair *p) {
  double from[4][3], sine;
  const double far = v3_norm(p->d);
  v3_copy(p->n, from[0]);
  v3_scale((far > 0.0) ? 1.0 / far : 0.0, p->d, from[1]);
  v3_cross(p->a.e[2], p->b.e[2], from[2]);
  sine = v3_norm(from[2]);
  v3_scale((sine > 0.0) ? 1.0 / sine : 0.0, from[2], from[2]);
  v3_scale(-1.0, from[2], from[3]);
  for (int i = 0; i < 4; i++) {
    if (v3_norm(from[i]) > 0.5) {
      climb(p, from[i]);
    }
  }
}

/* ---- candidates ----------------------------------------------------------------------------- */

/* Vertex i of a box (0..7) or end of a segment (0, 1). */
void round_vertex(const round_solid *s, int i, double *x) {
  v3_copy(s->c, x);
  for (int k = 0; k < 3; k++) {
    v3_add_scaled(x, (i >> k & 1) != 0 ? s->h[k] : -s->h[k], s->e[k], x);
  }
}

int round_vertices(const round_solid *s) {
  return s->disc ? 0 : (s->h[1] > 0.0) ? 8 : 2;
}

/* From the nearest point of the disc to x outside it. */
static void try_vertex(round_pair *p, const round_solid *disc, const double *x, double sign) {
  double y[3], t[3], near[3];
  v3_sub(x, disc->c, y);
  const double z = v3_dot(y, disc->e[2]), rho = round_across(disc, y, t);
  v3_scale(fmin(fmax(z, -disc->h[2]), disc->h[2]), disc->e[2], near);
  v3_add_scaled(near, (rho > disc->r) ? disc->r / rho : 1.0, t, near);
  v3_sub(y, near, y);
  const double far = v3_norm(y);
  if (far > 1e-9 * p->size) { /* nearer ones are found with the smooth parts */
    v3_scale(sign / far, y, y);
    round_try(p, y);
  }
}

void round_search(round_pair *p) {
  const round_solid *const s[2] = {&p->a, &p->b};
  for (int i = 0; i < 2; i++) {
    for (int k = 0; k < 3; k++) {
      if (s[i]->disc ? k == 2 : s[i]->h[1] > 0.0) {
        try_both(p, s[i]->e[k]);
      }
      if (s[i]->disc ? k == 2 : s[i]->h[k] > 0.0) {
        try_circle(p, s[i]->e[k]);
      }
    }
    for (int k = 0; k < round_vertices(s[i]); k++) {
      double x[3];
      round_vertex(s[i], k, x);
      try_vertex(p, s[1 - i], x, i == 0 ? 1.0 : -1.0);
    }
  }
  if (p->a.disc && p->b.disc) {
    try_rims(p);
  }
}
