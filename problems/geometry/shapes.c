/* shapes.c - shapes as swept convex cores, their gap to a half-space, closest points of segments. */
#include "problems/geometry/shapes.h"

#include "problems/vec.h"

#include <math.h>
#include <stddef.h>

int shape_pieces(const spec_shape *s) {
  if (s->kind != SPEC_COMPOUND) {
    return 1;
  }
  int n = 0;
  for (int i = 0; i < s->n_part; i++) {
    n += shape_pieces(&s->part[i].shape);
  }
  return n;
}

int shape_vertices(const spec_shape *s, int dim) {
  switch (s->kind) {
  case SPEC_POINT:
  case SPEC_SPHERE:
    return 1;
  case SPEC_ROD:
    return 2;
  case SPEC_BOX:
    return (dim == 2) ? 4 : 8;
  case SPEC_POLYGON:
    return s->n_vertex;
  case SPEC_DISC3D:
    return 0;
  case SPEC_COMPOUND:
    break;
  }
  int n = 0;
  for (int i = 0; i < s->n_part; i++) {
    n += shape_vertices(&s->part[i].shape, dim);
  }
  return n;
}

/* Corners of a box: planar counter-clockwise; spatial with bit k of the index choosing the sign
 * along axis k. */
static void box_corners(const spec_shape *s, int dim, double *v) {
  static const double ring[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (int i = 0; i < ((dim == 2) ? 4 : 8); i++, v += 3) {
    if (dim == 2) {
      v[0] = ring[i][0] * s->half[0];
      v[1] = ring[i][1] * s->half[1];
      v[2] = 0.0;
    } else {
      for (int k = 0; k < 3; k++) {
        v[k] = ((i >> k) & 1) ? s->half[k] : -s->half[k];
      }
    }
  }
}

static void split_simple(const spec_shape *s, int dim, piece *out, double **vertex) {
  double *v = *vertex;
  out->vertex = v;
  out->n_vertex = shape_vertices(s, dim);
  memset(v, 0, (size_t)(3 * out->n_vertex) * sizeof *v);
  v3_copy(s->half, out->half);
  out->r = 0.0;
  switch (s->kind) {
  case SPEC_SPHERE:
    out->r = s->r;
    out->kind = PIECE_POINT;
    break;
  case SPEC_ROD:
    out->kind = PIECE_SEGMENT;
    out->r = s->r;
    v[0] = -s->half[0];
    v[3] = s->half[0];
    break;
  case SPEC_BOX:
    out->kind = (dim == 2) ? PIECE_POLYGON : PIECE_BOX;
    box_corners(s, dim, v);
    break;
  case SPEC_POLYGON:
    out->kind = PIECE_POLYGON;
    for (int i = 0; i < s->n_vertex; i++) {
      v[(ptrdiff_t)3 * i] = s->vertex[i][0];
      v[3 * i + 1] = s->vertex[i][1];
    }
    break;
  case SPEC_DISC3D:
    out->kind = PIECE_DISC;
    out->r = s->r;
    break;
  case SPEC_POINT:
  case SPEC_COMPOUND:
    out->kind = PIECE_POINT;
    break;
  }
  *vertex = v + (ptrdiff_t)3 * out->n_vertex;
}

/* Moves a finished piece by the pose (pos, R) of the part that holds it. */
static void move_piece(piece *p, const double *pos, const double *R) {
  for (int i = 0; i < p->n_vertex; i++) {
    double *v = p->vertex + (ptrdiff_t)3 * i;
    m3_mul_vec(R, v, v);
    v3_add_scaled(pos, 1.0, v, v);
  }
  double old[9], at[3];
  memcpy(old, p->rot, sizeof old);
  m3_mul(R, old, p->rot);
  m3_mul_vec(R, p->pos, at);
  v3_add_scaled(pos, 1.0, at, p->pos);
}

void shape_split(const spec_shape *s, int dim, piece *out,
                 double **vertex) { // NOLINT(misc-no-recursion)
  static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  if (s->kind != SPEC_COMPOUND) {
    memset(out->pos, 0, sizeof out->pos);
    memcpy(out->rot, identity, sizeof identity);
    split_simple(s, dim, out, vertex);
    return;
  }
  for (int i = 0; i < s->n_part; i++) {
    const spec_part *part = &s->part[i];
    const int n = shape_pieces(&part->shape);
    shape_split(&part->shape, dim, out, vertex);
    double q[4], R[9];
    memcpy(q, part->quat, sizeof q);
    quat_normalise(q);
    quat_matrix(q, R);
    for (int k = 0; k < n; k++) {
      move_piece(out + k, part->pos, R);
    }
    out += n;
  }
}

double piece_bound(const piece *p) {
  if (p->kind == PIECE_DISC) {
    return v3_norm(p->pos) + hypot(p->r, p->half[2]);
  }
  double far = 0.0;
  for (int i = 0; i < p->n_vertex; i++) {
    far = fmax(far, v3_norm(p->vertex + (ptrdiff_t)3 * i));
  }
  return far + p->r;
}

/* ---- half-space --------------------------------------------------------------------------- */

static void push(gap_point *out, int *n, const double *x, const double *normal, double gap,
                 uint32_t feature) {
  gap_point *g = &out[(*n)++];
  v3_copy(x, g->x);
  v3_copy(normal, g->n);
  g->gap = gap;
  g->feature = feature;
}

/* Rims of a disc or cylinder: the lowest point (feature 0), which moves along the rim, and for a
 * disc lying within `flat` of the plane six points fixed on the rim, so that it can rest. */
static int rim_points(const piece *p, const pose *at, const double *normal, double offset,
                      double margin, gap_point *out) {
  enum { RIM_POINTS = 6 };
  const double flat = 1e-2; /* [rad] */
  double R[9], centre[3], down[3];
  m3_mul(at->R, p->rot, R);
  m3_mul_vec(at->R, p->pos, centre);
  v3_add_scaled(at->x, 1.0, centre, centre);
  const double axis[3] = {R[2], R[5], R[8]};
  v3_add_scaled(normal, -v3_dot(normal, axis), axis, down); /* normal projected on the disc */
  const double sine = v3_norm(down);
  const int rims = (p->half[2] > 0.0) ? 2 : 1;
  int n = 0;
  for (int i = 0; i < rims * (RIM_POINTS + 1); i++) {
    const int k = i % (RIM_POINTS + 1);
    double x[3], arm[3];
    if ((k == 0) ? sine < 1e-9 : sine > flat) {
      continue;
    }
    if (k == 0) {
      v3_scale(-p->r / sine, down, arm);
    } else {
      const double turn = 2.0 * 3.14159265358979323846 * (k - 1) / RIM_POINTS;
      const double local[3] = {p->r * cos(turn), p->r * sin(turn), 0.0};
      m3_mul_vec(R, local, arm);
    }
    v3_add_scaled(centre, 1.0, arm, x);
    v3_add_scaled(x, (i <= RIM_POINTS) ? -p->half[2] : p->half[2], axis, x);
    const double gap = v3_dot(normal, x) - offset;
    if (gap < margin) {
      push(out, &n, x, normal, gap, (uint32_t)i);
    }
  }
  return n;
}

int gap_halfspace(const piece *p, const pose *at, const double *normal, double offset,
                  double margin, gap_point *out) {
  if (p->kind == PIECE_DISC) {
    return rim_points(p, at, normal, offset, margin, out);
  }
  int n = 0;
  for (int i = 0; i < p->n_vertex; i++) {
    double x[3];
    m3_mul_vec(at->R, p->vertex + (ptrdiff_t)3 * i, x);
    v3_add_scaled(at->x, 1.0, x, x);
    const double gap = v3_dot(normal, x) - offset - p->r;
    if (gap < margin) {
      v3_add_scaled(x, -p->r, normal, x);
      push(out, &n, x, normal, gap, (uint32_t)i);
    }
  }
  return n;
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
