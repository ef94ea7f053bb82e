/* gap_spatial.c - points, segments (capsules), discs and boxes against each other in space.
 *
 * Swept points and segments: closest points of the cores. A capsule along another, or along a box
 * face, touches at both ends of the overlap. */
#include "problems/shapes.h"
#include "problems/vec.h"

static void world_point(const pose *at, const double *local, double *x) {
  m3_mul_vec(at->R, local, x);
  v3_add_scaled(at->x, 1.0, x, x);
}

/* Core points p of a and q of b, radii ra and rb. Coinciding cores use `fallback` as normal. */
static int core_pair(const double *p, double ra, const double *q, double rb, const double *fallback,
                     double margin, uint32_t feature, gap_point *out) {
  double d[3];
  v3_sub(p, q, d);
  const double core = v3_norm(d);
  if (core - ra - rb >= margin) {
    return 0;
  }
  if (core > 0.0) {
    v3_scale(1.0 / core, d, d);
  } else {
    v3_copy(fallback, d);
  }
  for (int k = 0; k < 3; k++) { /* midway between the surfaces */
    out->x[k] = 0.5 * (p[k] - ra * d[k] + q[k] + rb * d[k]);
    out->n[k] = d[k];
  }
  out->gap = core - ra - rb;
  out->feature = feature;
  return 1;
}

void segment_closest(const double *p0, const double *p1, const double *q0, const double *q1,
                     double *on_p, double *on_q) {
  double d1[3], d2[3], r[3];
  v3_sub(p1, p0, d1);
  v3_sub(q1, q0, d2);
  v3_sub(p0, q0, r);
  const double a = v3_dot(d1, d1), e = v3_dot(d2, d2), f = v3_dot(d2, r), c = v3_dot(d1, r);
  const double b = v3_dot(d1, d2), denom = a * e - b * b;
  double s = 0.0, t = 0.0; /* parameters on p and q (Ericson 2005, 5.1.9) */
  if (a > 0.0 && e > 0.0) {
    s = (denom > 1e-14 * a * e) ? fmin(fmax((b * f - c * e) / denom, 0.0), 1.0) : 0.0;
    t = (b * s + f) / e;
    if (t < 0.0) {
      t = 0.0;
      s = fmin(fmax(-c / a, 0.0), 1.0);
    } else if (t > 1.0) {
      t = 1.0;
      s = fmin(fmax((b - c) / a, 0.0), 1.0);
    }
  } else if (a > 0.0) {
    s = fmin(fmax(-c / a, 0.0), 1.0);
  } else if (e > 0.0) {
    t = fmin(fmax(f / e, 0.0), 1.0);
  }
  v3_add_scaled(p0, s, d1, on_p);
  v3_add_scaled(q0, t, d2, on_q);
}

static void any_normal(const double *along, double *n) {
  const double e[3] = {fabs(along[0]) <= 0.7, fabs(along[0]) > 0.7, 0};
  v3_cross(along, e, n);
  const double len = v3_norm(n);
  if (len > 0.0) {
    v3_scale(1.0 / len, n, n);
  } else {
    n[0] = n[1] = 0.0, n[2] = 1.0;
  }
}

/* Ends of the core: a point is a segment of no length. */
static void ends_of(const piece *p, const pose *at, double *e0, double *e1) {
  world_point(at, p->vertex, e0);
  world_point(at, p->vertex + 3 * (ptrdiff_t)(p->n_vertex - 1), e1);
}

/* Parallel segments: the overlap of q's shadow on p has two ends; false if there is none. */
static bool parallel_overlap(const double *p0, const double *p1, const double *q0, const double *q1,
                             double p_at[2][3], double q_at[2][3]) {
  double d1[3], d2[3], r[3], c[3];
  v3_sub(p1, p0, d1);
  v3_sub(q1, q0, d2);
  const double l1 = v3_norm(d1), l2 = v3_norm(d2);
  v3_cross(d1, d2, c);
  if (!(l1 > 0.0) || !(l2 > 0.0) || v3_norm(c) > 1e-6 * l1 * l2) {
    return false;
  }
  v3_sub(q0, p0, r);
  const double s0 = v3_dot(r, d1) / (l1 * l1), s1 = s0 + v3_dot(d2, d1) / (l1 * l1);
  const double lo = fmax(0.0, fmin(s0, s1)), hi = fmin(1.0, fmax(s0, s1));
  if (hi - lo <= 1e-6) {
    return false;
  }
  for (int k = 0; k < 2; k++) {
    const double s = (k == 0) ? lo : hi;
    v3_add_scaled(p0, s, d1, p_at[k]);
    v3_add_scaled(q0, (s - s0) / (s1 - s0), d2, q_at[k]);
  }
  return true;
}

static int cores(const piece *a, const pose *pa, const piece *b, const pose *pb, double margin,
                 gap_point *out) {
  double p0[3], p1[3], q0[3], q1[3], p[2][3], q[2][3], along[3], fallback[3];
  ends_of(a, pa, p0, p1);
  ends_of(b, pb, q0, q1);
  v3_sub(p1, p0, along);
  any_normal(along, fallback);
  if (parallel_overlap(p0, p1, q0, q1, p, q)) {
    int n = 0;
    for (uint32_t k = 0; k < 2; k++) {
      n += core_pair(p[k], a->r, q[k], b->r, fallback, margin, 1 + k, out + n);
    }
    return n;
  }
  segment_closest(p0, p1, q0, q1, p[0], q[0]);
  return core_pair(p[0], a->r, q[0], b->r, fallback, margin, 0, out);
}

/* Swept point at `c` against box b; the normal points from the box to the point. */
static int point_box(const double *c, double r, const piece *b, const pose *pb, double margin,
                     gap_point *out) {
  double R[9], centre[3], d[3], local[3], near[3], n[3];
  m3_mul(pb->R, b->rot, R);
  world_point(pb, b->pos, centre);
  v3_sub(c, centre, d);
  m3_tmul_vec(R, d, local);
  bool outside = false;
  for (int k = 0; k < 3; k++) {
    near[k] = fmin(fmax(local[k], -b->half[k]), b->half[k]);
    outside |= near[k] != local[k];
  }
  if (outside) {
    double on_box[3], fallback[3] = {0, 0, 1};
    m3_mul_vec(R, near, on_box);
    v3_add_scaled(on_box, 1.0, centre, on_box);
    return core_pair(c, r, on_box, 0.0, fallback, margin, 0, out);
  }
  int k = 0; /* inside: out through the nearest face */
  for (int i = 1; i < 3; i++) {
    k = (b->half[i] - fabs(local[i]) < b->half[k] - fabs(local[k])) ? i : k;
  }
  const double sign = (local[k] >= 0.0) ? 1.0 : -1.0, depth = b->half[k] - fabs(local[k]);
  const double axis[3] = {sign * R[k], sign * R[3 + k], sign * R[6 + k]};
  v3_copy(axis, n);
  for (int i = 0; i < 3; i++) {
    out->x[i] = c[i] + 0.5 * (depth - r) * n[i];
    out->n[i] = n[i];
  }
  out->gap = -depth - r;
  out->feature = 0;
  return (out->gap < margin) ? 1 : 0;
}

/* Swept point at `c` against a disc or cylinder b; the normal points from b to the point. */
static int point_disc(const double *c, double r, const piece *b, const pose *pb, double margin,
                      gap_point *out) {
  double R[9], centre[3], d[3], local[3], on[3];
  m3_mul(pb->R, b->rot, R);
  world_point(pb, b->pos, centre);
  v3_sub(c, centre, d);
  m3_tmul_vec(R, d, local);
  const double rho = hypot(local[0], local[1]), half = b->half[2];
  const double z = fmin(fmax(local[2], -half), half);
  if (rho >= b->r || fabs(local[2]) >= half) { /* outside, or on a thin disc */
    const double s = (rho > b->r) ? b->r / rho : 1.0;
    const double near[3] = {s * local[0], s * local[1], z};
    const double axis[3] = {R[2], R[5], R[8]};
    m3_mul_vec(R, near, on);
    v3_add_scaled(on, 1.0, centre, on);
    return core_pair(c, r, on, 0.0, axis, margin, 0, out);
  }
  /* inside a cylinder: out through the mantle or the nearer cap */
  const double to_cap = half - fabs(local[2]), to_side = b->r - rho;
  double n[3] = {0, 0, (local[2] >= 0.0) ? 1.0 : -1.0};
  if (to_side < to_cap && rho > 0.0) {
    n[0] = local[0] / rho, n[1] = local[1] / rho, n[2] = 0.0;
  }
  const double depth = fmin(to_side, to_cap);
  m3_mul_vec(R, n, out->n);
  v3_add_scaled(c, 0.5 * (depth - r), out->n, out->x);
  out->gap = -depth - r;
  out->feature = 0;
  return (out->gap < margin) ? 1 : 0;
}

bool gap_known(int dim, piece_kind a, piece_kind b) {
  if (dim == 2) {
    return a <= PIECE_POLYGON && b <= PIECE_POLYGON;
  }
  const piece_kind lo = (a < b) ? a : b, hi = (a < b) ? b : a;
  if (lo == PIECE_POLYGON || hi == PIECE_POLYGON) {
    return false;
  }
  return hi != PIECE_DISC || lo == PIECE_POINT;
}

/* First piece the simpler one: point < segment < box < disc. */
static int ordered(const piece *a, const pose *pa, const piece *b, const pose *pb, double margin,
                   gap_point *out) {
  double c[3];
  if (b->kind <= PIECE_SEGMENT) {
    return cores(a, pa, b, pb, margin, out);
  }
  if (a->kind != PIECE_POINT) {
    return gap_boxes(a, pa, b, pb, margin, out);
  }
  world_point(pa, a->vertex, c);
  return (b->kind == PIECE_BOX) ? point_box(c, a->r, b, pb, margin, out)
                                : point_disc(c, a->r, b, pb, margin, out);
}

int gap_spatial(const piece *a, const pose *pa, const piece *b, const pose *pb, double margin,
                gap_point *out) {
  if (a->kind <= b->kind) {
    return ordered(a, pa, b, pb, margin, out);
  }
  const int n = ordered(b, pb, a, pa, margin, out);
  for (int i = 0; i < n; i++) {
    v3_scale(-1.0, out[i].n, out[i].n);
  }
  return n;
}
