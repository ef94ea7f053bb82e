/* gap_planar.c - two planar convex polygons (one vertex: a point, two: a segment), each swept by
 * a radius.
 *
 * Vertex against vertex, vertex against edge, or - both with edges - the separating axis among the
 * edge normals with the facing edges clipped against each other (two points). A point is
 * identified by the vertex it belongs to, so ids survive a change of the reference edge. */
#include "problems/geometry/shapes.h"
#include "problems/vec.h"

typedef struct poly {
  int n;
  double r, size;
  double v[3 * SPEC_VERTICES]; /* world */
} poly;

/* Features: vertex i of the first piece, or VERTEX_OF_B + vertex of the second. */
enum { VERTEX_OF_B = SPEC_VERTICES };

static void place(const piece *p, const pose *at, poly *out) {
  out->n = p->n_vertex;
  out->r = p->r;
  out->size = 0.0;
  for (int i = 0; i < p->n_vertex; i++) {
    double *x = out->v + (ptrdiff_t)3 * i;
    m3_mul_vec(at->R, p->vertex + (ptrdiff_t)3 * i, x);
    v3_add_scaled(at->x, 1.0, x, x);
    const double *first = out->v;
    out->size = fmax(out->size, hypot(x[0] - first[0], x[1] - first[1]));
  }
}

static const double *corner(const poly *p, int i) {
  return p->v + (ptrdiff_t)(3 * ((i == p->n) ? 0 : i));
}

/* Outward unit normal of edge i; length returned. */
static double edge_normal(const poly *p, int i, double *normal) {
  double e[3];
  v3_sub(corner(p, i + 1), corner(p, i), e);
  const double length = hypot(e[0], e[1]);
  normal[0] = e[1] / length;
  normal[1] = -e[0] / length;
  normal[2] = 0.0;
  return length;
}

/* Adds the point whose surfaces are at on_a and on_b along n (from b to a). */
static void add(gap_point *out, int *n_out, const double *on_a, const double *on_b, const double *n,
                double gap, int feature) {
  gap_point *g = &out[(*n_out)++];
  for (int k = 0; k < 3; k++) {
    g->x[k] = 0.5 * (on_a[k] + on_b[k]);
    g->n[k] = n[k];
  }
  g->gap = gap;
  g->feature = (uint32_t)feature;
}

/* Core points p of a and q of b, apart along n: surfaces follow from the radii. */
static void add_cores(gap_point *out, int *n_out, const poly *a, const poly *b, const double *p,
                      const double *q, const double *n, int feature) {
  double on_a[3], on_b[3], d[3];
  v3_sub(p, q, d);
  v3_add_scaled(p, -a->r, n, on_a);
  v3_add_scaled(q, b->r, n, on_b);
  add(out, n_out, on_a, on_b, n, v3_dot(n, d) - a->r - b->r, feature);
}

/* Vertex p of a against vertex q of b; coinciding ones take `fallback` as their normal. */
static int vertex_vertex(const poly *a, const double *p, const poly *b, const double *q,
                         const double *fallback, double margin, int feature, gap_point *out) {
  double d[3];
  v3_sub(p, q, d);
  const double core = v3_norm(d);
  if (core - a->r - b->r >= margin) {
    return 0;
  }
  if (core > 0.0) {
    v3_scale(1.0 / core, d, d);
  } else {
    v3_copy(fallback, d);
  }
  int n = 0;
  add_cores(out, &n, a, b, p, q, d, feature);
  return n;
}

/* Greatest separation of `other` from an edge of `ref`; *edge is that edge, *deepest the vertex of
 * other that is closest to it. */
static double separation(const poly *ref, const poly *other, int *edge, int *deepest) {
  double best = -HUGE_VAL;
  *edge = 0;
  *deepest = 0;
  for (int i = 0; i < ref->n; i++) {
    double n[3], d[3];
    edge_normal(ref, i, n);
    double least = HUGE_VAL;
    int at = 0;
    for (int j = 0; j < other->n; j++) {
      v3_sub(corner(other, j), corner(ref, i), d);
      const double s = v3_dot(n, d);
      if (s < least) {
        least = s;
        at = j;
      }
    }
    if (least > best) {
      best = least;
      *edge = i;
      *deepest = at;
    }
  }
  return best;
}

/* Vertex k of `other` against edge i of `ref`, as seen from the pair (a, b); ref_is_a says which
 * of the two ref is. */
static void vertex_edge(const poly *ref, int i, const poly *other, int k, bool ref_is_a,
                        double margin, gap_point *out, int *n_out) {
  double n[3], d[3], foot[3];
  edge_normal(ref, i, n);
  const double *p = corner(other, k);
  v3_sub(p, corner(ref, i), d);
  const double core = v3_dot(n, d);
  if (core - ref->r - other->r >= margin) {
    return;
  }
  v3_add_scaled(p, -core, n, foot);
  if (ref_is_a) { /* normal must point from b (other) to a (ref) */
    v3_scale(-1.0, n, n);
    add_cores(out, n_out, ref, other, foot, p, n, VERTEX_OF_B + k);
  } else {
    add_cores(out, n_out, other, ref, p, foot, n, k);
  }
}

/* A single vertex (swept) against a polygon or segment. */
static int point_polygon(const poly *point, const poly *ref, bool ref_is_a, double margin,
                         gap_point *out) {
  int i, k, n_out = 0;
  const double s = separation(ref, point, &i, &k);
  if (s - ref->r - point->r >= margin) {
    return 0;
  }
  double n[3], d[3];
  const double length = edge_normal(ref, i, n);
  v3_sub(point->v, corner(ref, i), d);
  const double along = (-n[1] * d[0] + n[0] * d[1]) / length; /* 0..1 over the edge */
  const double *end = (along < 0.0) ? corner(ref, i) : corner(ref, i + 1);
  if (s <= 0.0 || (along >= 0.0 && along <= 1.0)) {
    vertex_edge(ref, i, point, 0, ref_is_a, margin, out, &n_out);
    return n_out;
  }
  if (ref_is_a) {
    v3_scale(-1.0, n, n);
    return vertex_vertex(ref, end, point, point->v, n, margin, VERTEX_OF_B, out);
  }
  return vertex_vertex(point, point->v, ref, end, n, margin, 0, out);
}

/* Edge of `other` that faces the direction n most. */
static int facing_edge(const poly *other, const double *n) {
  double least = HUGE_VAL;
  int at = 0;
  for (int j = 0; j < other->n; j++) {
    double m[3];
    edge_normal(other, j, m);
    const double s = v3_dot(n, m);
    if (s < least) {
      least = s;
      at = j;
    }
  }
  return at;
}

static int next(const poly *p, int i) {
  return (i + 1 == p->n) ? 0 : i + 1;
}

/* Does vertex x stand over edge i of p lengthened by slack at both ends? */
static bool over_edge(const poly *p, int i, const double *x, double slack) {
  double n[3], d[3];
  const double length = edge_normal(p, i, n);
  v3_sub(x, corner(p, i), d);
  const double s = -n[1] * d[0] + n[0] * d[1];
  return s >= -slack && s <= length + slack;
}

/* Edge i of ref against the edge of `other` facing it: vertices of either that stand over the
 * other's edge. A vertex of `other` within `slack` of an end counts and stands for both. */
static int clip_edges(const poly *ref, int i, const poly *other, bool ref_is_a, double slack,
                      double margin, gap_point *out) {
  double n[3];
  edge_normal(ref, i, n);
  const int j = facing_edge(other, n);
  int n_out = 0;
  for (int k = 0; k < 2; k++) {
    const int v = (k == 0) ? j : next(other, j);
    if (over_edge(ref, i, corner(other, v), slack)) {
      vertex_edge(ref, i, other, v, ref_is_a, margin, out, &n_out);
    }
  }
  for (int k = 0; k < 2; k++) {
    const int v = (k == 0) ? i : next(ref, i);
    if (over_edge(other, j, corner(ref, v), -slack)) {
      vertex_edge(other, j, ref, v, !ref_is_a, margin, out, &n_out);
    }
  }
  return n_out;
}

/* The closest pair of corners. */
static int corner_corner(const poly *a, const poly *b, const double *fallback, double margin,
                         gap_point *out) {
  double best = HUGE_VAL;
  int ia = 0, ib = 0;
  for (int i = 0; i < a->n; i++) {
    for (int j = 0; j < b->n; j++) {
      double d[3];
      v3_sub(corner(a, i), corner(b, j), d);
      const double s = v3_dot(d, d);
      if (s < best) {
        best = s;
        ia = i;
        ib = j;
      }
    }
  }
  return vertex_vertex(a, corner(a, ia), b, corner(b, ib), fallback, margin, ia, out);
}

/* Least gap of n points. */
static double least(const gap_point *g, int n) {
  double best = HUGE_VAL;
  for (int i = 0; i < n; i++) {
    best = fmin(best, g[i].gap);
  }
  return best;
}

/* Keeps the points that are not deeper than the overlap: in a deep one a corner may be far behind an edge that is not the way
 * out. */
static int drop_deeper(gap_point *g, int n, double overlap) {
  int kept = 0;
  for (int i = 0; i < n; i++) {
    if (g[i].gap >= overlap) {
      g[kept++] = g[i];
    }
  }
  return kept;
}

static int polygon_polygon(const poly *a, const poly *b, double margin, gap_point *out) {
  /* relative to the sizes, so that equal edges keep one reference in spite of rounding */
  const double slack = 1e-6 * fmin(a->size, b->size);
  int edge_a, edge_b, unused;
  const double sep_a = separation(a, b, &edge_a, &unused);
  const double sep_b = separation(b, a, &edge_b, &unused);
  if (fmax(sep_a, sep_b) - a->r - b->r >= margin) {
    return 0;
  }
  const bool ref_is_a = sep_b <= sep_a + slack;
  double n[3];
  int found;
  if (ref_is_a) {
    found = clip_edges(a, edge_a, b, true, slack, margin, out);
    edge_normal(a, edge_a, n);
    v3_scale(-1.0, n, n);
  } else {
    found = clip_edges(b, edge_b, a, false, slack, margin, out);
    edge_normal(b, edge_b, n);
  }
  const double sep = fmax(sep_a, sep_b), radii = a->r + b->r;
  found = drop_deeper(out, found, fmin(sep, 0.0) - radii - slack);
  /* apart by more than any edge normal shows: they pass corner to corner */
  const double nearest = least(out, found);
  if (sep <= slack || nearest + radii <= sep + slack) {
    return found;
  }
  return found + corner_corner(a, b, n, fmin(margin, nearest - slack), out + found);
}

int gap_planar(const piece *a, const pose *pa, const piece *b, const pose *pb, double margin,
               gap_point *out) {
  static const double up[3] = {0, 1, 0};
  poly A, B;
  place(a, pa, &A);
  place(b, pb, &B);
  if (A.n == 1 && B.n == 1) {
    return vertex_vertex(&A, A.v, &B, B.v, up, margin, 0, out);
  }
  if (A.n == 1) {
    return point_polygon(&A, &B, false, margin, out);
  }
  if (B.n == 1) {
    return point_polygon(&B, &A, true, margin, out);
  }
  return polygon_polygon(&A, &B, margin, out);
}
