/* world_touch.c - do bodies that turn come near each other between the ends of a step? */
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

/* How far the points of a body come at most about its centre. */
static double spun(const path *p) {
  return fastest(p->w, p->w2) * p->start.bound;
}

enum { LOOKS_MOST = 200 }; /* at one pair; it is taken to be as near where they end */

/* When two sides that are further apart than `near` at first are as near, in parts of the step; `most`: not before. A gap of g lasts for g
 * over the speed at which their points come nearer at most (Mirtich 1996). b: of a plane NULL. */
static double touch(world *w, const path *a, const path *b, int ia, int ib, double near,
                    double most) {
  double v[3];
  double x2[3];
  v3_copy(a->v, v);
  v3_copy(a->x2, x2);
  if (b != NULL) {
    v3_sub(a->v, b->v, v);
    v3_sub(a->x2, b->x2, x2);
  }
  const double speed = fastest(v, x2) + spun(a) + ((b != NULL) ? spun(b) : 0.0);
  double s = 0.0;
  for (int k = 0; k < LOOKS_MOST && s < most; k++) {
    pose_at(&w->body[ia], a, s, w->dim);
    if (b != NULL) {
      pose_at(&w->body[ib], b, s, w->dim);
    }
    const double gap = detect_pair_gap(w, ia, ib);
    if (gap <= near) {
      return (k > 0) ? s : most;
    }
    s += gap / speed;
  }
  return fmin(s, most);
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

/* The two sides of a pair; `most` where neither turns, or the step knows of them: they carry, or are near at its end. */
static double touch_of(world *w, const double *start, int a, int b, double h, double near,
                       double most) {
  const bool plane = b >= w->n_body;
  path pa;
  path pb;
  path_of(&pa, w, start, a, h);
  if (!plane) {
    path_of(&pb, w, start, b, h);
  }
  const bool turns = spun(&pa) > 0.0 || (!plane && spun(&pb) > 0.0);
  if (!turns || carried(w, a, b) || detect_pair_gap(w, a, b) <= near) {
    return most;
  }
  const body end_a = w->body[a];
  const body end_b = w->body[plane ? a : b];
  const double at = touch(w, &pa, plane ? NULL : &pb, a, b, near, most);
  w->body[plane ? a : b] = end_b;
  w->body[a] = end_a;
  return at;
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

base_status world_first_touch(world *w, double h, const double *start, double near, double *at,
                              base_error *err) {
  double first = 1.0;
  *at = h;
  if (w->model != NULL || !world_has(w, EFFECT_CONTACT)) {
    return BASE_OK;
  }
  BASE_TRY(fill_balls(w, start, h, err));
  BASE_TRY(broad_find(&w->broad, w->dim, err));
  for (int k = 0; k < w->broad.n_pair; k++) {
    const broad_pair p = w->broad.pair[k];
    if (detect_may_collide(w, p.a, p.b)) {
      first = touch_of(w, start, p.a, p.b, h, near, first);
    }
  }
  for (int a = 0; a < w->n_body; a++) {
    const broad_ball *ball = &w->broad.ball[a];
    for (int i = 0; i < w->spec.n_static; i++) {
      const spec_static *plane = &w->spec.fixed[i];
      const double away = v3_dot(plane->normal, ball->x) - plane->offset - ball->r;
      if (away < 0.0 && detect_may_collide(w, a, w->n_body + i)) {
        first = touch_of(w, start, a, w->n_body + i, h, near, first);
      }
    }
  }
  *at = first * h;
  return BASE_OK;
}
