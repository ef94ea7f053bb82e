/* gap_boxes.c - two boxes in space; a segment is a box of no thickness.
 *
 * Separating axis test over 3 + 3 face normals and 9 edge products (Gottschalk, Lin & Manocha
 * 1996). Then every point of the pair of most facing faces that lies within the margin: vertices of
 * either standing over the other's face, and crossings of the outlines, up to 8 points, all kept
 * (hyperstatic scenes rely on it); and the edge pair, where an edge product separates best. Boxes
 * apart by more than any axis shows pass corner to corner or corner to edge: then the closest
 * features are searched.
 *
 * Ids: vertex of a, vertex of b, or edge of a x edge of b, whichever box is the reference. */
#include "problems/geometry/shapes.h"
#include "problems/vec.h"

typedef struct obox {
  double c[3], R[9], h[3], r; /* axis k is column k of R; r: sweeping radius */
  int thick;                  /* bit k: h[k] > 0. Coinciding corners go by one number. */
} obox;

typedef struct sat_axis {
  double sep;  /* along n, negative when overlapping */
  double n[3]; /* unit, from b to a */
  int i, j;    /* face: i of its box, j = -1; edge product: a's axis i, b's axis j */
} sat_axis;

typedef struct contact_list {
  gap_point *out;
  int n;
  double margin, slack;
  double
      deepest; /* overlap of the cores, as a gap: no point is deeper. In deep overlaps a corner may
                     be far behind a face that is not the way out. */
  double ra, rb;
} contact_list;

enum { VERTEX_B = 8, EDGE_PAIR = 16 };

static void column(const double *R, int k, double *axis) {
  axis[0] = R[k], axis[1] = R[3 + k], axis[2] = R[6 + k];
}

static obox place(const piece *p, const pose *at) {
  obox o;
  double centre[3];
  o.r = p->r;
  o.thick = (p->kind == PIECE_BOX) ? 7 : 1;
  if (p->kind == PIECE_BOX) {
    m3_mul(at->R, p->rot, o.R);
    v3_copy(p->half, o.h);
    v3_copy(p->pos, centre);
  } else { /* segment along the first axis */
    double d[3], u[3], v[3];
    v3_sub(p->vertex + 3, p->vertex, d);
    o.h[0] = 0.5 * v3_norm(d);
    o.h[1] = o.h[2] = 0.0;
    v3_add_scaled(p->vertex, 0.5, d, centre);
    m3_mul_vec(at->R, d, d);
    v3_scale(0.5 / o.h[0], d, d);
    v3_perpendicular(d, u);
    v3_cross(d, u, v);
    const double R[9] = {d[0], u[0], v[0], d[1], u[1], v[1], d[2], u[2], v[2]};
    memcpy(o.R, R, sizeof R);
  }
  m3_mul_vec(at->R, centre, o.c);
  v3_add_scaled(at->x, 1.0, o.c, o.c);
  return o;
}

/* Half extent of a box along a unit vector. */
static double extent(const obox *o, const double *n) {
  double s[3];
  m3_tmul_vec(o->R, n, s);
  return o->h[0] * fabs(s[0]) + o->h[1] * fabs(s[1]) + o->h[2] * fabs(s[2]);
}

static void try_axis(const obox *a, const obox *b, const double *n, int i, int j, sat_axis *best) {
  double d[3];
  v3_sub(a->c, b->c, d);
  const double along = v3_dot(d, n);
  const double sep = fabs(along) - extent(a, n) - extent(b, n);
  if (sep > best->sep) {
    best->sep = sep;
    best->i = i;
    best->j = j;
    v3_scale((along >= 0.0) ? 1.0 : -1.0, n, best->n);
  }
}

static void vertex_of(const obox *o, int v, double *x) {
  const double local[3] = {(v & 1) ? o->h[0] : -o->h[0], (v & 2) ? o->h[1] : -o->h[1],
                           (v & 4) ? o->h[2] : -o->h[2]};
  m3_mul_vec(o->R, local, x);
  v3_add_scaled(o->c, 1.0, x, x);
}

/* Edge along axis k through vertex v: 4 k + the signs on the two other axes. */
static int edge_of(const obox *o, int k, int v) {
  v &= o->thick;
  return 4 * k + ((v >> ((k + 1) % 3)) & 1) + 2 * ((v >> ((k + 2) % 3)) & 1);
}

/* Vertex of the corner farthest along n. */
static int support(const obox *o, const double *n) {
  double s[3];
  m3_tmul_vec(o->R, n, s);
  return (s[0] > 0.0) + 2 * (s[1] > 0.0) + 4 * (s[2] > 0.0);
}

/* Adds the core point x of one box, the other's core at x - gap n ... of width `core`: the impulse
 * acts midway between the swept surfaces. `at_a`: x lies on a. */
static void add_point(contact_list *l, const double *x, bool at_a, const double *n, double core,
                      int feature) {
  const double gap = core - l->ra - l->rb;
  if (gap >= l->margin) {
    return;
  }
  gap_point *g = &l->out[l->n];
  const double shift = at_a ? -l->ra - 0.5 * gap : l->rb + 0.5 * gap;
  v3_add_scaled(x, shift, n, g->x);
  v3_copy(n, g->n);
  g->gap = gap;
  g->feature = (uint32_t)feature;
  for (int k = 0; k < l->n; k++) { /* coinciding corners stand for one another */
    double d[3];
    v3_sub(l->out[k].x, g->x, d);
    if (v3_dot(d, d) <= 4.0 * l->slack * l->slack) {
      return;
    }
  }
  l->n++;
}

/* One face of a box. */
typedef struct box_face {
  const obox *o;
  int k, sign; /* axis and side */
  double m[3]; /* outward normal */
  bool is_a;
} box_face;

static box_face face_towards(const obox *o, int k, const double *n, bool is_a) {
  box_face f = {.o = o, .k = k, .is_a = is_a};
  column(o->R, k, f.m);
  f.sign = (v3_dot(f.m, n) >= 0.0) ? 1 : -1;
  v3_scale(f.sign, f.m, f.m);
  return f;
}

/* Coordinates of x over the face: (u, v) in its plane, height above it. */
static void over_face(const box_face *f, const double *x, double *u, double *v, double *height) {
  double d[3], s[3];
  v3_sub(x, f->o->c, d);
  m3_tmul_vec(f->o->R, d, s);
  *u = s[(f->k + 1) % 3];
  *v = s[(f->k + 2) % 3];
  *height = f->sign * s[f->k] - f->o->h[f->k];
}

/* Vertex number of the corner of f with signs (su, sv). */
static int face_corner(const box_face *f, int su, int sv) {
  return ((f->sign > 0) << f->k) | (su << ((f->k + 1) % 3)) | (sv << ((f->k + 2) % 3));
}

/* Corners of f in cyclic order. */
static void outline(const box_face *f, int v[4]) {
  for (int i = 0; i < 4; i++) {
    v[i] = face_corner(f, i == 1 || i == 2, i >= 2);
  }
}

/* Corners of `from` that stand over face `to`. */
static void corners_over(const box_face *from, const box_face *to, contact_list *l) {
  int v[4];
  double n[3];
  outline(from, v);
  v3_scale(to->is_a ? -1.0 : 1.0, to->m, n);
  const double *h = to->o->h;
  const double hu = h[(to->k + 1) % 3] + l->slack, hv = h[(to->k + 2) % 3] + l->slack;
  for (int i = 0; i < 4; i++) {
    double x[3], u, w, height;
    vertex_of(from->o, v[i], x);
    over_face(to, x, &u, &w, &height);
    if (fabs(u) <= hu && fabs(w) <= hv && height >= l->deepest) {
      const int corner = v[i] & from->o->thick;
      add_point(l, x, from->is_a, n, height, from->is_a ? corner : VERTEX_B + corner);
    }
  }
}

/* Axis along which the face outline runs between two of its corners. */
static int edge_axis(int v0, int v1) {
  const int bit = v0 ^ v1;
  return (bit == 1) ? 0 : (bit == 2) ? 1 : 2;
}

/* Lines through vertex va of a along its axis i and vb of b along j: the foot points, and whether
 * both lie on their edges. */
static bool edge_feet(const obox *a, int i, int va, const obox *b, int j, int vb, double *pa,
                      double *pb) {
  double ua[3], ub[3], ca[3], cb[3], d[3];
  column(a->R, i, ua);
  column(b->R, j, ub);
  vertex_of(a, va, ca);
  vertex_of(b, vb, cb);
  v3_add_scaled(ca, ((va >> i) & 1) ? -a->h[i] : a->h[i], ua, ca); /* middles of the edges */
  v3_add_scaled(cb, ((vb >> j) & 1) ? -b->h[j] : b->h[j], ub, cb);
  v3_sub(cb, ca, d);
  const double c = v3_dot(ua, ub), da = v3_dot(d, ua), db = v3_dot(d, ub), sine2 = 1.0 - c * c;
  const double s = (da - c * db) / sine2, t = (c * da - db) / sine2;
  v3_add_scaled(ca, s, ua, pa);
  v3_add_scaled(cb, t, ub, pb);
  return fabs(s) <= a->h[i] && fabs(t) <= b->h[j];
}

/* Where two outlines cross, seen along the face normal m. */
typedef struct crossing {
  double p[3], m[3], height;
  bool at_a; /* p lies on a */
} crossing;

/* Crossing of an edge of each box: along their common normal where that is well defined and near
 * the face normal m (from b to a), else along m, through the point p of box `at_a` at `height`. */
static void add_crossing(const obox *a, const obox *b, int ia, int va, int ib, int vb,
                         const crossing *c, contact_list *l) {
  double ua[3], ub[3], n[3], pa[3], pb[3], d[3];
  const int feature = EDGE_PAIR + 12 * edge_of(a, ia, va) + edge_of(b, ib, vb);
  column(a->R, ia, ua);
  column(b->R, ib, ub);
  v3_cross(ua, ub, n);
  const double sine = v3_norm(n), along = v3_dot(n, c->m);
  if (sine > 0.1 && fabs(along) > 0.87 * sine && edge_feet(a, ia, va, b, ib, vb, pa, pb)) {
    v3_scale(((along > 0.0) ? 1.0 : -1.0) / sine, n, n);
    v3_sub(pa, pb, d);
    if (v3_dot(n, d) >= l->deepest) {
      add_point(l, pa, true, n, v3_dot(n, d), feature);
    }
  } else if (c->height >= l->deepest) {
    add_point(l, c->p, c->at_a, c->m, c->height, feature);
  }
}

/* Crossings of the edge v0 v1 of `inc` with the outline of `ref`. */
static void edge_crossings(const box_face *ref, const box_face *inc, int v0, int v1,
                           contact_list *l) {
  double x0[3], x1[3], a[3], b[3];
  vertex_of(inc->o, v0, x0);
  vertex_of(inc->o, v1, x1);
  over_face(ref, x0, &a[0], &a[1], &a[2]);
  over_face(ref, x1, &b[0], &b[1], &b[2]);
  crossing at = {.at_a = inc->is_a};
  v3_scale(ref->is_a ? -1.0 : 1.0, ref->m, at.m);
  const double half[2] = {ref->o->h[(ref->k + 1) % 3], ref->o->h[(ref->k + 2) % 3]};
  for (int side = 0; side < 4; side++) { /* lines u = -h, u = +h, v = -h, v = +h */
    const int c = side / 2, other = 1 - c;
    const double line = (side & 1) ? half[c] : -half[c];
    const double s0 = a[c] - line, s1 = b[c] - line;
    if (!(s0 * s1 < 0.0) || fabs(s0) <= l->slack || fabs(s1) <= l->slack) {
      continue;
    }
    const double t = s0 / (s0 - s1);
    if (fabs(a[other] + t * (b[other] - a[other])) >= half[other] - l->slack) {
      continue;
    }
    for (int k = 0; k < 3; k++) {
      at.p[k] = x0[k] + t * (x1[k] - x0[k]);
    }
    at.height = a[2] + t * (b[2] - a[2]);
    const int su = (c == 0) ? (side & 1) : 0, sv = (c == 1) ? (side & 1) : 0;
    const int axis = (ref->k + ((c == 0) ? 2 : 1)) % 3, corner = face_corner(ref, su, sv);
    if (ref->is_a) {
      add_crossing(ref->o, inc->o, axis, corner, edge_axis(v0, v1), v0, &at, l);
    } else {
      add_crossing(inc->o, ref->o, edge_axis(v0, v1), v0, axis, corner, &at, l);
    }
  }
}

static void face_manifold(const obox *a, const obox *b, const sat_axis *best, bool ref_is_a,
                          contact_list *l) {
  double towards[3]; /* out of the reference box */
  v3_scale(ref_is_a ? -1.0 : 1.0, best->n, towards);
  const obox *r = ref_is_a ? a : b, *o = ref_is_a ? b : a;
  const box_face ref = face_towards(r, best->i, towards, ref_is_a);
  double s[3], back[3];
  int v[4], k = 0;
  m3_tmul_vec(o->R, ref.m, s);
  for (int i = 1; i < 3; i++) {
    k = (fabs(s[i]) > fabs(s[k])) ? i : k;
  }
  v3_scale(-1.0, ref.m, back);
  const box_face inc = face_towards(o, k, back, !ref_is_a);
  corners_over(&inc, &ref, l);
  corners_over(&ref, &inc, l);
  outline(&inc, v);
  for (int i = 0; i < 4; i++) {
    edge_crossings(&ref, &inc, v[i], v[(i + 1) % 4], l);
  }
}

/* Nearest point of a box to x. */
static void clamp_to(const obox *o, const double *x, double *near) {
  double d[3], s[3];
  v3_sub(x, o->c, d);
  m3_tmul_vec(o->R, d, s);
  for (int k = 0; k < 3; k++) {
    s[k] = fmin(fmax(s[k], -o->h[k]), o->h[k]);
  }
  m3_mul_vec(o->R, s, near);
  v3_add_scaled(o->c, 1.0, near, near);
}

typedef struct closest {
  double distance, pa[3], pb[3];
  int feature;
} closest;

static void keep_closer(closest *c, const double *pa, const double *pb, int feature, double bias) {
  double d[3];
  v3_sub(pa, pb, d);
  const double distance = v3_norm(d);
  if (distance < c->distance - bias) {
    c->distance = distance;
    c->feature = feature;
    v3_copy(pa, c->pa);
    v3_copy(pb, c->pb);
  }
}

/* Closest points of two boxes that do not overlap, over all features. */
static closest closest_features(const obox *a, const obox *b, double slack) {
  closest c = {.distance = HUGE_VAL};
  double x[3], y[3], pa[3], pb[3];
  for (int v = 0; v < 8; v++) {
    vertex_of(a, v, x);
    clamp_to(b, x, y);
    keep_closer(&c, x, y, v & a->thick, 0.0);
    vertex_of(b, v, x);
    clamp_to(a, x, y);
    keep_closer(&c, y, x, VERTEX_B + (v & b->thick), 0.0);
  }
  for (int e = 0; e < 144; e++) {
    const int i = e / 48, j = (e % 12) / 4;
    const int sa = (e / 12) % 4, sb = e % 4;
    const int va = ((sa & 1) << ((i + 1) % 3)) | ((sa >> 1) << ((i + 2) % 3));
    const int vb = ((sb & 1) << ((j + 1) % 3)) | ((sb >> 1) << ((j + 2) % 3));
    double a0[3], a1[3], b0[3], b1[3];
    vertex_of(a, va, a0);
    vertex_of(a, va | (1 << i), a1);
    vertex_of(b, vb, b0);
    vertex_of(b, vb | (1 << j), b1);
    segment_closest(a0, a1, b0, b1, pa, pb);
    keep_closer(&c, pa, pb, EDGE_PAIR + 12 * edge_of(a, i, va) + edge_of(b, j, vb), slack);
  }
  return c;
}

/* Adds the closest features unless they are at least `limit` apart; takes the place of a point of
 * the same feature. */
static void add_closest(const obox *a, const obox *b, double limit, contact_list *l) {
  const closest c = closest_features(a, b, l->slack);
  double n[3];
  if (!(c.distance > 0.0) || c.distance >= limit) {
    return;
  }
  v3_sub(c.pa, c.pb, n);
  v3_scale(1.0 / c.distance, n, n);
  int kept = 0;
  for (int i = 0; i < l->n; i++) {
    if (l->out[i].feature != (uint32_t)c.feature) {
      l->out[kept++] = l->out[i];
    }
  }
  l->n = kept;
  add_point(l, c.pa, true, n, c.distance, c.feature);
}

/* The edge pair of the best edge product, unless the face manifold holds it already. */
static void edge_point(const obox *a, const obox *b, const sat_axis *edge, contact_list *l) {
  double back[3], pa[3], pb[3];
  v3_scale(-1.0, edge->n, back);
  const int va = support(a, back), vb = support(b, edge->n);
  const int feature = EDGE_PAIR + 12 * edge_of(a, edge->i, va) + edge_of(b, edge->j, vb);
  for (int k = 0; k < l->n; k++) {
    if (l->out[k].feature == (uint32_t)feature) {
      return;
    }
  }
  if (edge_feet(a, edge->i, va, b, edge->j, vb, pa, pb)) {
    add_point(l, pa, true, edge->n, edge->sep, feature);
  }
}

static void find_axes(const obox *a, const obox *b, sat_axis *fa, sat_axis *fb, sat_axis *e) {
  *fa = *fb = *e = (sat_axis){.sep = -HUGE_VAL, .j = -1};
  for (int i = 0; i < 3; i++) {
    double ua[3], ub[3], n[3];
    column(a->R, i, ua);
    try_axis(a, b, ua, i, -1, fa);
    column(b->R, i, ub);
    try_axis(a, b, ub, i, -1, fb);
    for (int j = 0; j < 3; j++) {
      column(b->R, j, ub);
      v3_cross(ua, ub, n);
      const double length = v3_norm(n);
      if (length > 1e-6 && a->h[i] > 0.0 && b->h[j] > 0.0) { /* parallel edges: a face decides */
        v3_scale(1.0 / length, n, n);
        try_axis(a, b, n, i, j, e);
      }
    }
  }
}

/* A box of no thickness has no faces across its length. */
static bool has_faces(const obox *o) {
  return o->h[1] > 0.0 || o->h[2] > 0.0;
}

int gap_boxes(const piece *pa, const pose *at_a, const piece *pb, const pose *at_b, double margin,
              gap_point *out) {
  const obox a = place(pa, at_a), b = place(pb, at_b);
  sat_axis fa, fb, edge;
  find_axes(&a, &b, &fa, &fb, &edge);
  const double sep = fmax(fmax(fa.sep, fb.sep), edge.sep);
  if (sep - a.r - b.r >= margin) {
    return 0;
  }
  contact_list l = {.out = out, .margin = margin, .ra = a.r, .rb = b.r};
  l.slack = 1e-6 * fmin(v3_norm(a.h), v3_norm(b.h));
  l.deepest = fmin(sep, 0.0) - l.slack;
  const bool ref_is_a = has_faces(&a) && (!has_faces(&b) || fb.sep <= fa.sep + l.slack);
  const sat_axis *face = ref_is_a ? &fa : &fb;
  face_manifold(&a, &b, face, ref_is_a, &l);
  if (edge.j >= 0 && edge.sep > face->sep + l.slack) {
    edge_point(&a, &b, &edge, &l);
  }
  double nearest = HUGE_VAL;
  for (int i = 0; i < l.n; i++) {
    nearest = fmin(nearest, l.out[i].gap + l.ra + l.rb);
  }
  if (sep > l.slack && nearest > sep + l.slack) {
    add_closest(&a, &b, nearest - l.slack, &l);
  }
  return l.n;
}
