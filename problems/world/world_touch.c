/* world_touch.c - do bodies come near each other between the ends of a step? */
#include "problems/vec.h"
#include "problems/world/world_data.h"

#include <math.h>

/* The way of a body over a step, in parts s of it from 0 to 1: x + s v + s^2 x2, and the turn s w + s^2 w2. */
typedef struct path {
  body start;
  double v[3], x2[3], w[3], w2[3]; /* [m], [rad] */
} path;

/* The rotation vector from a to b. */
static void turn_between(const body *a, const body *b, int dim, double *out) {
  const double back[4] = {a->quat[0], -a->quat[1], -a->quat[2], -a->quat[3]};
  double q[4];
  if (dim == 2) {
    out[0] = out[1] = 0.0;
    out[2] = b->angle - a->angle;
    return;
  }
  quat_mul(b->quat, back, q);
  const double sine = v3_norm(q + 1);
  const double angle = 2.0 * atan2(sine, fabs(q[0]));
  v3_scale((sine > 0.0) ? copysign(angle / sine, q[0]) : 2.0, q + 1, out);
}

static void path_of(path *p, const world *w, const double *start, int i, double h) {
  const body *end = &w->body[i];
  double turn[3];
  p->start = *end;
  world_saved_body(start, i, &p->start);
  turn_between(&p->start, end, w->dim, turn);
  v3_scale(h, p->start.v, p->v);
  v3_scale(h, p->start.v + 3, p->w);
  for (int k = 0; k < 3; k++) {
    p->x2[k] = end->at.x[k] - p->start.at.x[k] - p->v[k];
    p->w2[k] = turn[k] - p->w[k];
  }
}

static void pose_at(body *b, const path *p, double s, int dim) {
  double turn[3];
  *b = p->start;
  for (int k = 0; k < 3; k++) {
    b->at.x[k] += s * (p->v[k] + s * p->x2[k]);
    turn[k] = s * (p->w[k] + s * p->w2[k]);
  }
  b->angle += turn[2];
  if (dim == 3) {
    quat_rotate(b->quat, turn, 1.0);
  }
  body_orient(b, dim);
}

/* Largest norm of a + 2 s b for s from 0 to 1: at one of the ends. */
static double fastest(const double *a, const double *b) {
  double end[3];
  v3_add_scaled(a, 2.0, b, end);
  return fmax(v3_norm(a), v3_norm(end));
}

/* How far the points of a body come at most about its centre. A round one has the same places however it spins. */
static double spun(const path *p) {
  return p->start.round ? 0.0 : fastest(p->w, p->w2) * p->start.bound;
}

/* Two sides over a step, b NULL: a plane; v, x2: of their difference; spun: how far the points of both come at most about the centres [m]. */
typedef struct meeting {
  const path *a, *b;
  int ia, ib;
  double v[3], x2[3], spun;
} meeting;

/* The direction from b to a in which the gap now between them lies, where that is known: of planes, and of round bodies. */
static bool direction_of(const world *w, const meeting *m, double n[3]) {
  if (m->b == NULL) {
    v3_copy(w->spec.fixed[m->ib - w->n_body].normal, n);
    return true;
  }
  v3_sub(w->body[m->ia].at.x, w->body[m->ib].at.x, n);
  const double length = v3_norm(n);
  v3_scale((length > 0.0) ? 1.0 / length : 0.0, n, n);
  return m->a->start.round && m->b->start.round && length > 0.0;
}

/* For how long a gap lasts, in parts of the step, from s on. It is not closed before the sides have come nearer by as much along its
 * direction, or, where that is not known, at the speed at which their points come nearer at most (Mirtich 1996). HUGE_VAL: for good. */
static double lasts(const world *w, const meeting *m, double s, double gap) {
  double n[3];
  if (!direction_of(w, m, n)) {
    return gap / (fastest(m->v, m->x2) + m->spun);
  }
  const double p = m->spun - v3_dot(n, m->v) - 2.0 * s * v3_dot(n, m->x2);
  const double q = -v3_dot(n, m->x2);
  /* the least t > 0 of p t + q t^2 = gap */
  const double square = p * p + 4.0 * q * gap;
  const double under = p + sqrt(fmax(square, 0.0));
  return (square >= 0.0 && under > 0.0) ? 2.0 * gap / under : HUGE_VAL;
}

/* Takes both sides to the part s of the step; their gap there [m]. */
static double gap_at(world *w, const meeting *m, double s) {
  pose_at(&w->body[m->ia], m->a, s, w->dim);
  if (m->b != NULL) {
    pose_at(&w->body[m->ib], m->b, s, w->dim);
  }
  return detect_pair_gap(w, m->ia, m->ib);
}

enum { LOOKS_MOST = 200 }; /* at one pair; it is taken to be as near where they end */

/* When two sides are as near as `near` first, in parts of the step; `most`: not before. */
static double touch(world *w, const meeting *m, double near, double most) {
  double s = 0.0;
  for (int k = 0; k < LOOKS_MOST && s < most; k++) {
    const double gap = gap_at(w, m, s);
    if (gap <= near) {
      return s;
    }
    s += lasts(w, m, s, gap);
  }
  return fmin(s, most);
}

/* When the gap is least between two parts of the step that it falls and rises once in: by the golden section, a look for each of its steps. */
static double deepest(world *w, const meeting *m, double from, double to) {
  static const double golden = 0.6180339887498949;
  double early = to - golden * (to - from), late = from + golden * (to - from);
  double gap_early = gap_at(w, m, early), gap_late = gap_at(w, m, late);
  while (to - from > 1e-7) {
    if (gap_early < gap_late) {
      to = late;
      late = early;
      gap_late = gap_early;
      early = to - golden * (to - from);
      gap_early = gap_at(w, m, early);
    } else {
      from = early;
      early = late;
      gap_early = gap_late;
      late = from + golden * (to - from);
      gap_late = gap_at(w, m, late);
    }
  }
  return 0.5 * (from + to);
}

/* The speed at which two sides come into each other that no longer come on so at the end, or are deeper than twice `near` by then, in
 * lengths a step; 0: they do not. */
static double passed(world *w, const meeting *m, double near) {
  static const double little = 1e-3;    /* of the step, and of the smallest body */
  static const double rounding = 1e-12; /* of the smallest body */
  static const double as_fast = 0.9;
  const double from = touch(w, m, 0.0, 1.0);
  if (from >= 1.0) {
    return 0.0;
  }
  const double fast = fastest(m->v, m->x2) + m->spun;
  const double slight = little * fmin(w->size / fast, 1.0);
  const double there = gap_at(w, m, from);
  const double speed = (there - gap_at(w, m, from + slight)) / slight;
  const double end = gap_at(w, m, 1.0);
  const double last = (gap_at(w, m, 1.0 - slight) - end) / slight;
  if (end >= -2.0 * near && last >= as_fast * speed) {
    return 0.0; /* they still come on */
  }
  const double deep = fmin(there, 0.0) - gap_at(w, m, deepest(w, m, from, 1.0));
  return (deep > rounding * w->size) ? fmax(speed, 0.0) : 0.0;
}

/* Did the last contacts carry between two sides? */
static bool carried(const world *w, int a, int b) {
  const uint64_t first = ((uint64_t)a << ID_SIDE_A_SHIFT) | ((uint64_t)b << ID_SIDE_B_SHIFT);
  const uint64_t *id = w->store.id;
  int low = 0;
  for (int n = w->set.n_contact; n > 0;) { /* the first that is not less */
    const int half = n / 2;
    const bool less = id[low + half] < first;
    low = less ? low + half + 1 : low;
    n = less ? n - half - 1 : half;
  }
  for (; low < w->set.n_contact && id[low] - first < (uint64_t)1 << ID_SIDE_B_SHIFT; low++) {
    if (w->store.impulse[w->store.row_start[low]] > 0.0) {
      return true;
    }
  }
  return false;
}

/* What is looked for, and found so far. */
typedef struct touches {
  const double *start;
  double h, near; /* [s], [m] */
  double first;   /* in parts of the step */
  double passed;  /* [m/s] */
} touches;

/* The two sides of a pair; those that carry the step knows of, and of those that are near at its end if they have not passed. */
static void look_at(world *w, void *of, int a, int b) {
  touches *t = of;
  const bool plane = b >= w->n_body;
  path pa;
  path pb;
  if (carried(w, a, b)) {
    return;
  }
  path_of(&pa, w, t->start, a, t->h);
  meeting m = {.a = &pa, .ia = a, .ib = b, .spun = spun(&pa)};
  v3_copy(pa.v, m.v);
  v3_copy(pa.x2, m.x2);
  if (!plane) {
    path_of(&pb, w, t->start, b, t->h);
    m.b = &pb;
    m.spun += spun(&pb);
    v3_sub(pa.v, pb.v, m.v);
    v3_sub(pa.x2, pb.x2, m.x2);
  }
  static const double through =
      0.1; /* of the smallest body: deeper than that it may have come through by the next step */
  const double gap = detect_pair_gap(w, a, b);
  const bool gone = gap > t->near || gap < -through * w->size;
  const body end_a = w->body[a];
  const body end_b = w->body[plane ? a : b];
  const double at = gone ? touch(w, &m, t->near, t->first) : 0.0;
  t->first = (at > 0.0) ? at : t->first;
  t->passed = fmax(t->passed, passed(w, &m, t->near) / t->h);
  w->body[plane ? a : b] = end_b;
  w->body[a] = end_a;
}

/* Balls about where the bodies began, that contain their ways. */
static base_status fill_balls(world *w, const double *start, double h, base_error *err) {
  BASE_TRY(broad_reserve(&w->broad, w->n_body, err));
  for (int i = 0; i < w->n_body; i++) {
    path p;
    broad_ball *ball = &w->broad.ball[i];
    path_of(&p, w, start, i, h);
    v3_copy(p.start.at.x, ball->x);
    ball->r = p.start.bound + v3_norm(p.v) + v3_norm(p.x2);
  }
  return BASE_OK;
}

/* Shows the two sides of every pair that may collide and whose balls meet, after broad_find. */
static void each_pair(world *w, void (*look)(world *, void *, int, int), void *of) {
  for (int k = 0; k < w->broad.n_pair; k++) {
    const broad_pair p = w->broad.pair[k];
    if (detect_may_collide(w, p.a, p.b)) {
      look(w, of, p.a, p.b);
    }
  }
  for (int a = 0; a < w->n_body; a++) {
    const broad_ball *ball = &w->broad.ball[a];
    for (int i = 0; i < w->spec.n_static; i++) {
      const spec_static *plane = &w->spec.fixed[i];
      const double away = v3_dot(plane->normal, ball->x) - plane->offset - ball->r;
      if (away < 0.0 && detect_may_collide(w, a, w->n_body + i)) {
        look(w, of, a, w->n_body + i);
      }
    }
  }
}

base_status world_first_touch(world *w, double h, const double *start, double near, double *at,
                              double *speed, base_error *err) {
  touches t = {.start = start, .h = h, .near = near, .first = 1.0};
  *at = h;
  *speed = 0.0;
  if (w->model != NULL || !world_has(w, EFFECT_CONTACT)) {
    return BASE_OK;
  }
  BASE_TRY(fill_balls(w, start, h, err));
  BASE_TRY(broad_find(&w->broad, w->dim, err));
  each_pair(w, look_at, &t);
  *at = t.first * h;
  *speed = t.passed;
  return BASE_OK;
}

bool world_sides_touch(const world *w) {
  static const uint64_t mask = ((uint64_t)1 << ID_SIDE_BITS) - 1;
  const set_store *s = &w->store;
  bool touch = false;
  for (int i = 0; i < w->set.n_contact && !touch; i++) {
    const uint64_t a = (s->id[i] >> ID_SIDE_A_SHIFT) & mask,
                   b = (s->id[i] >> ID_SIDE_B_SHIFT) & mask;
    const bool both = b < (uint64_t)w->n_body && !(w->body[a].round && w->body[b].round);
    touch = both && s->impulse[s->row_start[i]] > 0.0;
  }
  return touch;
}

typedef struct neighbours {
  double near, speed; /* [m], [m/s] */
} neighbours;

/* Where side i is after h as fast as now; a plane stays. */
static void go_on(world *w, int i, double h) {
  if (i < w->n_body) {
    path p = {.start = w->body[i]};
    v3_scale(h, p.start.v, p.v);
    v3_scale(h, p.start.v + 3, p.w);
    pose_at(&w->body[i], &p, 1.0, w->dim);
  }
}

/* Largest speed of a point of a body. */
static double fast_of(const body *b) {
  return v3_norm(b->v) + b->bound * v3_norm(b->v + 3);
}

/* How fast two sides come nearer that are near now, over so short a time that they stay so. */
static void see_nearing(world *w, void *of, int a, int b) {
  neighbours *n = of;
  const int other = (b < w->n_body) ? b : a; /* of a plane nothing moves */
  const double gap = detect_pair_gap(w, a, b);
  const double fast = fast_of(&w->body[a]) + fast_of(&w->body[other]);
  if (gap > n->near || !(fast > 0.0)) {
    return;
  }
  const double h = 1e-6 * w->size / fast;
  const body now_a = w->body[a];
  const body now_b = w->body[other];
  go_on(w, a, h);
  go_on(w, b, h);
  n->speed = fmax(n->speed, (gap - detect_pair_gap(w, a, b)) / h);
  w->body[other] = now_b;
  w->body[a] = now_a;
}

base_status world_nearing(world *w, double near, double *speed, base_error *err) {
  neighbours n = {.near = near};
  *speed = 0.0;
  if (w->model != NULL || !world_has(w, EFFECT_CONTACT)) {
    return BASE_OK;
  }
  BASE_TRY(broad_reserve(&w->broad, w->n_body, err));
  for (int i = 0; i < w->n_body; i++) {
    broad_ball *ball = &w->broad.ball[i];
    v3_copy(w->body[i].at.x, ball->x);
    ball->r = w->body[i].bound + near;
  }
  BASE_TRY(broad_find(&w->broad, w->dim, err));
  each_pair(w, see_nearing, &n);
  *speed = n.speed;
  return BASE_OK;
}
