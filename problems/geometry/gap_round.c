/* gap_round.c - discs and cylinders against segments (capsules), boxes and each other in space.
 *
 * The closest or deepest pair (round_pair.c) is feature 0. Beside it the corners of either that stand
 * over a face, a mantle or a segment of the other are listed (a's: 1 .., b's: 17 ..): vertices and ends,
 * the extreme point of each rim, and for a cap that lies within 0.01 rad of a face six points fixed on
 * the rim, so that cylinders stand and lie as boxes do. */
#include "problems/geometry/gap_round.h"

#include "problems/geometry/round_pair.h"
#include "problems/vec.h"

enum { RIM = 7, SPECIAL = 16 };
static const double pi = 3.14159265358979323846;

/* Nearest to x among the points of the core that are furthest along n. */
static void support_near(const round_solid *s, const double *n, const double *x, double *out) {
  const double flat = 1e-7;
  double y[3], t[3];
  v3_sub(x, s->c, y);
  round_support(s, n, flat, out);
  for (int k = 0; k < 3; k++) {
    if (s->h[k] > 0.0 && fabs(v3_dot(n, s->e[k])) <= flat) {
      v3_add_scaled(out, fmin(fmax(v3_dot(y, s->e[k]), -s->h[k]), s->h[k]), s->e[k], out);
    }
  }
  if (s->disc && round_across(s, n, t) <= flat) {
    const double rho = round_across(s, y, t);
    v3_add_scaled(out, (rho > s->r) ? s->r / rho : 1.0, t, out);
  }
  v3_add_scaled(out, 1.0, s->c, out);
}

/* Ends of that set of points if it is a line: one edge of a box, a segment, a line of a mantle. */
static bool support_line(const round_solid *s, const double *n, double *e0, double *e1) {
  const double flat = 1e-7;
  double middle[3], t[3];
  int lines = 0, along = 0;
  for (int k = 0; k < 3; k++) {
    if (s->h[k] > 0.0 && fabs(v3_dot(n, s->e[k])) <= flat) {
      lines++;
      along = k;
    }
  }
  if (lines != 1 || (s->disc && round_across(s, n, t) <= flat)) {
    return false;
  }
  round_support(s, n, flat, middle);
  v3_add_scaled(middle, 1.0, s->c, middle);
  v3_add_scaled(middle, -s->h[along], s->e[along], e0);
  v3_add_scaled(middle, s->h[along], s->e[along], e1);
  return true;
}

typedef struct list {
  gap_point *out;
  int n;
  double margin;
} list;

/* p on the core of a, q on that of b, along m by `core` apart. */
static void add(list *l, const round_pair *p, const double *x, const double *m, double core,
                uint32_t feature) {
  const double gap = core - p->a.sweep - p->b.sweep;
  if (gap >= l->margin) {
    return;
  }
  gap_point *g = &l->out[l->n++];
  v3_copy(x, g->x);
  v3_copy(m, g->n);
  g->gap = gap;
  g->feature = feature;
}

static void add_closest(list *l, const round_pair *p) {
  double down[3], x[3], y[3], middle[3], a0[3], a1[3], b0[3], b1[3];
  v3_scale(-1.0, p->n, down);
  if (support_line(&p->a, down, a0, a1) && support_line(&p->b, p->n, b0, b1)) {
    segment_closest(a0, a1, b0, b1, x, y);
  } else { /* alternating projections on two convex sets in parallel planes, one a point or a face:
              gap and normal are known, this says where along the planes, so to rounding or not at all */
    double before[3], moved = HUGE_VAL;
    v3_copy(p->b.c, y);
    for (int i = 0; i < 100 && moved > 1e-15 * p->size; i++) {
      v3_copy(y, before);
      support_near(&p->a, down, y, x);
      support_near(&p->b, p->n, x, y);
      v3_sub(y, before, before);
      moved = v3_norm(before);
    }
  }
  for (int k = 0; k < 3; k++) {
    middle[k] = 0.5 * (x[k] - p->a.sweep * p->n[k] + y[k] + p->b.sweep * p->n[k]);
  }
  add(l, p, middle, p->n, p->best, 0);
}

/* Does x stand over a face, the mantle or the side of s, whose outside is towards n? Its distance from
 * there and the normal m, exact for every x fixed on the other body. */
static bool over(const round_solid *s, const double *n, const double *x, double slack, double *m,
                 double *distance) {
  double y[3], t[3];
  v3_sub(x, s->c, y);
  if (s->disc) {
    const double along = v3_dot(n, s->e[2]), z = v3_dot(y, s->e[2]), rho = round_across(s, y, t);
    if (fabs(along) > 0.9) {
      v3_scale(copysign(1.0, along), s->e[2], m);
      *distance = v3_dot(m, y) - s->h[2];
      return rho <= s->r + slack;
    }
    if (fabs(along) > 0.1 || rho < 0.5 * s->r) {
      return false;
    }
    v3_scale(1.0 / rho, t, m);
    *distance = rho - s->r;
    return fabs(z) <= s->h[2] + slack && v3_dot(m, n) > 0.9;
  }
  if (s->h[1] == 0.0) { /* segment */
    const double z = v3_dot(y, s->e[0]);
    v3_add_scaled(y, -z, s->e[0], m);
    *distance = v3_norm(m);
    if (fabs(z) > s->h[0] + slack || *distance <= slack || fabs(v3_dot(n, s->e[0])) > 0.1) {
      return false;
    }
    v3_scale(1.0 / *distance, m, m);
    return v3_dot(m, n) > 0.9;
  }
  for (int k = 0; k < 3; k++) {
    const double along = v3_dot(n, s->e[k]);
    if (fabs(along) > 0.9) {
      v3_scale(copysign(1.0, along), s->e[k], m);
      *distance = v3_dot(m, y) - s->h[k];
      return fabs(v3_dot(y, s->e[(k + 1) % 3])) <= s->h[(k + 1) % 3] + slack &&
             fabs(v3_dot(y, s->e[(k + 2) % 3])) <= s->h[(k + 2) % 3] + slack;
    }
  }
  return false;
}

/* Side of s from its axis to x; false on the axis. */
static bool side(const round_solid *s, const double *x, double *m) {
  const double *axis = s->e[s->disc ? 2 : 0];
  double y[3];
  v3_sub(x, s->c, y);
  v3_add_scaled(y, -v3_dot(y, axis), axis, m);
  const double rho = v3_norm(m);
  v3_scale(1.0 / rho, m, m);
  return rho > 0.0;
}

/* The point of a rim (centre c, axes u and v, radius r) nearest to the axis of a round body: the root of
 * its slope near x, where it starts. */
static bool nearest_on_rim(const double *c, double r, const double *u, const double *v,
                           const round_solid *to, double *x) {
  double arm[3], n[3], slope[3], m[3];
  v3_sub(x, c, arm);
  const double start = atan2(v3_dot(arm, v), v3_dot(arm, u));
  double lo = start - 0.7, hi = start + 0.7;
  for (int i = 0; i < 54; i++) {
    const double mid = 0.5 * (lo + hi);
    round_circle(u, v, mid, n, slope);
    v3_add_scaled(c, r, n, x);
    if (!side(to, x, m)) {
      return false;
    }
    *(v3_dot(m, slope) < 0.0 ? &lo : &hi) = mid;
  }
  return fabs(lo - start) < 0.69; /* else the root is not here */
}

/* Special point i of s, extreme along -n; false: there is none. */
static bool special(const round_solid *s, int i, const double *n, double *x) {
  if (!s->disc) {
    round_vertex(s, i, x);
    return i < round_vertices(s);
  }
  const int rim = i / RIM, k = i % RIM;
  double t[3];
  const double sine = round_across(s, n, t);
  if (rim > (s->h[2] > 0.0 ? 1 : 0) || (k == 0 ? sine < 1e-9 : sine > 1e-2)) {
    return false;
  }
  v3_add_scaled(s->c, rim == 0 ? -s->h[2] : s->h[2], s->e[2], x);
  if (k == 0) {
    v3_add_scaled(x, -s->r / sine, t, x);
    return true;
  }
  const double turn = 2.0 * pi * (k - 1) / (RIM - 1);
  v3_add_scaled(x, s->r * cos(turn), s->e[0], x);
  v3_add_scaled(x, s->r * sin(turn), s->e[1], x);
  return true;
}

/* Is m the normal of a mantle or of the side of a segment, not of a plane? */
static bool is_round(const round_solid *s, const double *m) {
  return s->disc ? fabs(v3_dot(m, s->e[2])) < 0.5 : s->h[1] == 0.0;
}

static bool listed(const list *l, const double *x, double slack) {
  for (int i = 0; i < l->n; i++) {
    double d[3];
    v3_sub(l->out[i].x, x, d);
    if (v3_norm(d) <= slack) {
      return true;
    }
  }
  return false;
}

/* Special points of s over the other body; n from the other to s, sign 1 if s is a. */
static void add_special(list *l, const round_pair *p, const round_solid *s,
                        const round_solid *other, double sign) {
  const double slack = 1e-6 * p->size;
  double n[3];
  v3_scale(sign, p->n, n);
  for (int i = 0; i < SPECIAL; i++) {
    double x[3], m[3], distance = 0.0;
    bool good = special(s, i, n, x) && over(other, n, x, slack, m, &distance);
    if (good && s->disc && i % RIM == 0) { /* extreme along the normal that it is judged by */
      double centre[3];
      v3_add_scaled(s->c, i == 0 ? -s->h[2] : s->h[2], s->e[2], centre);
      good = (is_round(other, m) ? nearest_on_rim(centre, s->r, s->e[0], s->e[1], other, x)
                                 : special(s, i, m, x)) &&
             over(other, n, x, slack, m, &distance);
    }
    if (!good || distance < fmin(p->best, 0.0) - slack) {
      continue;
    }
    double y[3];
    const double shift = 0.5 * (s->sweep + distance - other->sweep);
    v3_add_scaled(x, -shift, m, y); /* midway between the surfaces */
    v3_scale(sign, m, m);
    if (!listed(l, y, slack)) {
      add(l, p, y, m, distance, (uint32_t)((sign > 0.0 ? 1 : 1 + SPECIAL) + i));
    }
  }
}

int gap_round(const piece *pa, const pose *at_a, const piece *pb, const pose *at_b, double margin,
              gap_point *out) {
  round_pair p = {.a = round_place(pa, at_a), .b = round_place(pb, at_b), .best = -HUGE_VAL};
  const double core = margin + p.a.sweep + p.b.sweep;
  v3_sub(p.a.c, p.b.c, p.d);
  p.size = p.a.r + p.b.r + v3_norm(p.a.h) + v3_norm(p.b.h);
  const double far = v3_norm(p.d);
  if (far > 0.0) { /* the line of centres shows most pairs apart */
    double n[3];
    v3_scale(1.0 / far, p.d, n);
    round_try(&p, n);
  }
  if (p.best >= core) {
    return 0;
  }
  round_search(&p);
  if (p.best >= core) {
    return 0;
  }
  list l = {out, 0, margin};
  add_special(&l, &p, &p.a, &p.b, 1.0);
  add_special(&l, &p, &p.b, &p.a, -1.0);
  double nearest = HUGE_VAL;
  for (int i = 0; i < l.n; i++) {
    nearest = fmin(nearest, out[i].gap);
  }
  if (nearest > p.best - p.a.sweep - p.b.sweep + 1e-9 * p.size) {
    add_closest(&l, &p);
  }
  return l.n;
}
