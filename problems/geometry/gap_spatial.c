/* gap_spatial.c - points, segments (capsules), discs and boxes against each other in space.
 *
 * Swept points and segments: closest points of the cores, and for capsules along one another both
 * ends of the overlap. */
#include "problems/geometry/gap_round.h"
#include "problems/geometry/shapes.h"
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

/* Ends of the core: a point is a segment of no length. */
static void ends_of(const piece *p, const pose *at, double *e0, double *e1) {
  world_point(at, p->vertex, e0);
  world_point(at, p->vertex + 3 * (ptrdiff_t)(p->n_vertex - 1), e1);
}

/* Nearly parallel segments touch at both ends of their overlap: each end of either that stands
 * beside the other one (features 1 to 4), exact for any angle. */
static int ends_beside(const double *e, double ra, double rb, const double *fallback, double margin,
                       gap_point *out) {
  int n = 0;
  for (int i = 0; i < 4; i++) {
    const double *x = e + (ptrdiff_t)3 * i, *s0 = (i < 2) ? e + 6 : e, *s1 = s0 + 3;
    double d[3], r[3], foot[3];
    v3_sub(s1, s0, d);
    v3_sub(x, s0, r);
    const double t = v3_dot(r, d) / v3_dot(d, d);
    if (t < 0.0 || t > 1.0) {
      continue;
    }
    v3_add_scaled(s0, t, d, foot);
    const uint32_t feature = 1 + (uint32_t)i;
    n += (i < 2) ? core_pair(x, ra, foot, rb, fallback, margin, feature, out + n)
                 : core_pair(foot, ra, x, rb, fallback, margin, feature, out + n);
  }
  return n;
}

static bool nearly_parallel(const double *d1, const double *d2) {
  const double sine = 0.1; /* [rad] of lying along one another */
  double c[3];
  v3_cross(d1, d2, c);
  const double l1 = v3_norm(d1), l2 = v3_norm(d2);
  return l1 > 0.0 && l2 > 0.0 && v3_norm(c) <= sine * l1 * l2;
}

/* A normal for cores that meet: at right angles to both, or to the one that has a length. */
static void normal_across(const double *d1, const double *d2, double *n) {
  const double l1 = v3_norm(d1), l2 = v3_norm(d2);
  if (!(l1 > 0.0) && !(l2 > 0.0)) {
    n[0] = n[1] = 0.0, n[2] = 1.0;
    return;
  }
  v3_cross(d1, d2, n);
  const double sine = v3_norm(n);
  if (sine > 1e-6 * l1 * l2) {
    v3_scale(1.0 / sine, n, n);
    return;
  }
  double along[3];
  v3_scale(1.0 / fmax(l1, l2), (l1 >= l2) ? d1 : d2, along);
  v3_perpendicular(along, n);
}

static int cores(const piece *a, const pose *pa, const piece *b, const pose *pb, double margin,
                 gap_point *out) {
  double e[12] = {0}, p[3], q[3], d1[3], d2[3], fallback[3]; /* e: the four ends */
  ends_of(a, pa, e, e + 3);
  ends_of(b, pb, e + 6, e + 9);
  v3_sub(e + 3, e, d1);
  v3_sub(e + 9, e + 6, d2);
  normal_across(d1, d2, fallback);
  int n = 0;
  if (nearly_parallel(d1, d2)) {
    n = ends_beside(e, a->r, b->r, fallback, margin, out);
  }
  segment_closest(e, e + 3, e + 6, e + 9, p, q);
  n += core_pair(p, a->r, q, b->r, fallback, margin, 0, out + n);
  for (int i = 0; i + 1 < n; i++) { /* the closest pair is an end: listed already */
    if (out[i].gap <= out[n - 1].gap + 1e-9 * (v3_norm(d1) + v3_norm(d2))) {
      return n - 1;
    }
  }
  return n;
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
  if (to_side < to_cap) { /* from the axis any way is the nearest */
    n[0] = (rho > 0.0) ? local[0] / rho : 1.0;
    n[1] = (rho > 0.0) ? local[1] / rho : 0.0;
    n[2] = 0.0;
  }
  const double depth = fmin(to_side, to_cap);
  m3_mul_vec(R, n, out->n);
  v3_add_scaled(c, 0.5 * (depth - r), out->n, out->x);
  out->gap = -depth - r;
  out->feature = 0;
  return (out->gap < margin) ? 1 : 0;
}

/* First piece the simpler one: point < segment < box < disc. */
static int ordered(const piece *a, const pose *pa, const piece *b, const pose *pb, double margin,
                   gap_point *out) {
  double c[3];
  if (b->kind <= PIECE_SEGMENT) {
    return cores(a, pa, b, pb, margin, out);
  }
  if (a->kind != PIECE_POINT && b->kind == PIECE_DISC) {
    return gap_round(a, pa, b, pb, margin, out);
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
