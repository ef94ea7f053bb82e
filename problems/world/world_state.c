/* world_state.c - the configuration as one vector, for formulations that integrate themselves, and the whole state as
 * one, to come back to. */
#include "problems/vec.h"
#include "problems/world/world_data.h"

/* Numbers of a body's configuration: position, then angle or quaternion where it can turn. */
static int n_config(const world *w, const body *b) {
  return w->dim + (b->spins ? ((w->dim == 2) ? 1 : 4) : 0);
}

int world_n_config(const world *w) {
  if (w->model != NULL) {
    return w->n_dof;
  }
  int n = 0;
  for (int i = 0; i < w->n_free; i++) {
    n += n_config(w, &w->body[w->free_body[i]]);
  }
  return n;
}

void world_get_state(const world *w, double *config, double *v) {
  if (w->model != NULL) {
    memcpy(config, w->q, (size_t)w->n_dof * sizeof *config);
    memcpy(v, w->qv, (size_t)w->n_dof * sizeof *v);
    return;
  }
  for (int i = 0; i < w->n_free; i++) {
    const body *b = &w->body[w->free_body[i]];
    memcpy(config, b->at.x, (size_t)w->dim * sizeof *config);
    if (b->spins && w->dim == 2) {
      config[2] = b->angle;
    } else if (b->spins) {
      memcpy(config + 3, b->quat, sizeof b->quat);
    }
    config += n_config(w, b);
    for (int k = 0; k < b->n_dof; k++) {
      v[b->dof + k] = b->v[b->axis[k]];
    }
  }
}

/* A kinematic body at time t, from the closed form of its motion. */
static void place_kinematic(world *w, int i) {
  body *b = &w->body[i];
  if (!b->driven) {
    return;
  }
  v3_copy(w->spec.body[i].pos, b->at.x);
  v3_add_scaled(b->at.x, w->t, b->driven_v0, b->at.x);
  v3_add_scaled(b->at.x, 0.5 * w->t * w->t, b->driven_a, b->at.x);
  body_driven(b, w->t, b->v);
  if (!b->spins) {
    return;
  }
  double mean[3]; /* angular velocity from 0 to t; its axis stands still (spec_check_all) */
  v3_add_scaled(b->driven_v0 + 3, 0.5 * w->t, b->driven_a + 3, mean);
  if (w->dim == 2) {
    b->angle = w->spec.body[i].angle + w->t * mean[2];
  } else {
    memcpy(b->quat, w->spec.body[i].quat, sizeof b->quat);
    quat_normalise(b->quat);
    quat_rotate(b->quat, mean, w->t);
  }
  body_orient(b, w->dim);
}

void world_set_state(world *w, double t, const double *config, const double *v) {
  w->t = t;
  if (w->model != NULL) {
    memcpy(w->q, config, (size_t)w->n_dof * sizeof *config);
    memcpy(w->qv, v, (size_t)w->n_dof * sizeof *v);
    return;
  }
  for (int i = 0; i < w->n_body; i++) {
    body *b = &w->body[i];
    if (b->n_dof == 0) {
      if (b->sleeps == 0) {
        place_kinematic(w, i);
      }
      continue;
    }
    memcpy(b->at.x, config, (size_t)w->dim * sizeof *config);
    if (b->spins && w->dim == 2) {
      b->angle = config[2];
    } else if (b->spins) {
      memcpy(b->quat, config + 3, sizeof b->quat);
      quat_normalise(b->quat);
    }
    body_orient(b, w->dim);
    body_set_velocity(b, v, t);
    config += n_config(w, b);
  }
}

void world_config_rate(const world *w, const double *config, const double *v, double *rate) {
  if (w->model != NULL) {
    memcpy(rate, v, (size_t)w->n_dof * sizeof *rate);
    return;
  }
  for (int i = 0; i < w->n_free; i++) {
    body moving = w->body[w->free_body[i]];
    body_set_velocity(&moving, v, w->t);
    memcpy(rate, moving.v, (size_t)w->dim * sizeof *rate);
    if (moving.spins && w->dim == 2) {
      rate[2] = moving.v[5];
    } else if (moving.spins) { /* qdot = (0, omega) q / 2 */
      const double half[4] = {0.0, 0.5 * moving.v[3], 0.5 * moving.v[4], 0.5 * moving.v[5]};
      quat_mul(half, config + 3, rate + 3);
    }
    config += n_config(w, &moving);
    rate += n_config(w, &moving);
  }
}

/* ---- saved states ---------------------------------------------------------------------------- */

/* What of a body changes with time. */
typedef struct body_state {
  pose at;
  double quat[4], angle, v[6];
} body_state;
_Static_assert(sizeof(body_state) % sizeof(double) == 0, "a saved body is a list of numbers");

enum { BODY_NUMBERS = sizeof(body_state) / sizeof(double) };

size_t world_saved_size(const world *w) {
  return (w->model != NULL) ? 1 + 2 * (size_t)w->n_dof : 1 + BODY_NUMBERS * (size_t)w->n_body;
}

void world_save(const world *w, double *state) {
  *state++ = w->t;
  if (w->model != NULL) {
    memcpy(state, w->q, (size_t)w->n_dof * sizeof *state);
    memcpy(state + w->n_dof, w->qv, (size_t)w->n_dof * sizeof *state);
    return;
  }
  for (int i = 0; i < w->n_body; i++, state += BODY_NUMBERS) {
    const body *b = &w->body[i];
    body_state now = {.at = b->at, .angle = b->angle};
    memcpy(now.quat, b->quat, sizeof now.quat);
    memcpy(now.v, b->v, sizeof now.v);
    memcpy(state, &now, sizeof now);
  }
}

/* An axis that is neither free nor driven does not move, whatever it did with other effects. */
static void still_locked(body *b) {
  unsigned moves = 0;
  for (int k = 0; k < b->n_dof; k++) {
    moves |= 1u << b->axis[k];
  }
  for (int k = 0; k < 6 && !b->driven; k++) {
    b->v[k] = ((moves & 1u << k) != 0) ? b->v[k] : 0.0;
  }
}

void world_saved_body(const double *state, int i, body *out) {
  body_state then;
  memcpy(&then, state + 1 + BODY_NUMBERS * (ptrdiff_t)i, sizeof then);
  out->at = then.at;
  out->angle = then.angle;
  memcpy(out->quat, then.quat, sizeof out->quat);
  memcpy(out->v, then.v, sizeof out->v);
}

void world_load(world *w, const double *state) {
  w->t = *state++;
  if (w->model != NULL) {
    memcpy(w->q, state, (size_t)w->n_dof * sizeof *state);
    memcpy(w->qv, state + w->n_dof, (size_t)w->n_dof * sizeof *state);
    return;
  }
  for (int i = 0; i < w->n_body; i++) {
    world_saved_body(state - 1, i, &w->body[i]);
  }
}

void world_still_locked(world *w) {
  for (int i = 0; i < w->n_body && w->model == NULL; i++) {
    still_locked(&w->body[i]);
  }
}

/* sqrt of the sum of squares of a - b. */
static double apart(const double *a, const double *b, int n) {
  double sum = 0.0;
  for (int k = 0; k < n; k++) {
    sum += (a[k] - b[k]) * (a[k] - b[k]);
  }
  return sqrt(sum);
}

/* How far velocities of the points of body i are from each other in two saved states. */
static double faster(const world *w, int i, const double *a, const double *b) {
  body_state s;
  body_state t;
  memcpy(&s, a + 1 + BODY_NUMBERS * (ptrdiff_t)i, sizeof s);
  memcpy(&t, b + 1 + BODY_NUMBERS * (ptrdiff_t)i, sizeof t);
  return apart(s.v, t.v, 3) + w->body[i].bound * apart(s.v + 3, t.v + 3, 3);
}

double world_saved_swerve(const world *w, const saved_step *own, const saved_step *next,
                          double slight) {
  double most = 0.0;
  for (int i = 0; w->model == NULL && i < w->n_body; i++) {
    const double before = faster(w, i, own->start, own->fine);
    const double other = faster(w, i, next->start, next->fine);
    most = (other > slight * before) ? fmax(most, other) : most;
  }
  return most;
}

void world_saved_distance(const world *w, const double *a, const double *b, double *position,
                          double *velocity) {
  *position = *velocity = 0.0;
  if (w->model != NULL) {
    *position = apart(a + 1, b + 1, w->n_dof);
    *velocity = apart(a + 1 + w->n_dof, b + 1 + w->n_dof, w->n_dof);
    return;
  }
  for (int i = 0; i < w->n_body; i++) {
    body_state s;
    body_state t;
    memcpy(&s, a + 1 + BODY_NUMBERS * (ptrdiff_t)i, sizeof s);
    memcpy(&t, b + 1 + BODY_NUMBERS * (ptrdiff_t)i, sizeof t);
    /* |R_s - R_t| is 2 sqrt(2) sin of half the angle between them, in Frobenius' norm */
    const double turn =
        (w->dim == 2) ? fabs(s.angle - t.angle) : apart(s.at.R, t.at.R, 9) / sqrt(2.0);
    *position = fmax(*position, apart(s.at.x, t.at.x, 3) + w->body[i].bound * turn);
    *velocity = fmax(*velocity, faster(w, i, a, b));
  }
}

/* ---- one step and two halves ----------------------------------------------------------------- */

/* 2 fine - coarse. */
static void beyond(const double *coarse, const double *fine, int n, double *out) {
  for (int k = 0; k < n; k++) {
    out[k] = 2.0 * fine[k] - coarse[k];
  }
}

/* The rotation from `coarse` to `fine`. */
static void quat_between(const double *coarse, const double *fine, double *turn) {
  const double back[4] = {coarse[0], -coarse[1], -coarse[2], -coarse[3]};
  quat_mul(fine, back, turn);
}

static void body_extrapolate(body *b, int dim, const body_state *coarse, const body_state *fine) {
  double turn[4];
  beyond(coarse->at.x, fine->at.x, 3, b->at.x);
  beyond(coarse->v, fine->v, 6, b->v);
  b->angle = 2.0 * fine->angle - coarse->angle;
  if (b->spins && dim == 3) {
    quat_between(coarse->quat, fine->quat, turn);
    quat_mul(turn, fine->quat, b->quat);
    quat_normalise(b->quat);
  }
  body_orient(b, dim);
  still_locked(b);
}

void world_extrapolate(world *w, const double *coarse, const double *fine) {
  world_load(w, fine);
  if (w->model != NULL) {
    beyond(coarse + 1, fine + 1, w->n_dof, w->q);
    beyond(coarse + 1 + w->n_dof, fine + 1 + w->n_dof, w->n_dof, w->qv);
    return;
  }
  for (int i = 0; i < w->n_body; i++) {
    body_state s;
    body_state t;
    memcpy(&s, coarse + 1 + BODY_NUMBERS * (ptrdiff_t)i, sizeof s);
    memcpy(&t, fine + 1 + BODY_NUMBERS * (ptrdiff_t)i, sizeof t);
    if (w->body[i].n_dof > 0 || w->body[i].driven) {
      body_extrapolate(&w->body[i], w->dim, &s, &t);
    }
  }
}

/* sqrt of the sum of squares of x_fine - x_coarse + h (v_fine - v_start) / 4. */
static double bent(const double *apart, const double *v_start, const double *v_fine, double h,
                   int n) {
  double sum = 0.0;
  for (int k = 0; k < n; k++) {
    const double e = apart[k] + 0.25 * h * (v_fine[k] - v_start[k]);
    sum += e * e;
  }
  return sqrt(sum);
}

static double body_bend(const world *w, int i, double h, const double *start, const double *coarse,
                        const double *fine) {
  const ptrdiff_t at = 1 + BODY_NUMBERS * (ptrdiff_t)i;
  body_state o;
  body_state s;
  body_state t;
  double way[3];
  double turn[4];
  memcpy(&o, start + at, sizeof o);
  memcpy(&s, coarse + at, sizeof s);
  memcpy(&t, fine + at, sizeof t);
  v3_add_scaled(t.at.x, -1.0, s.at.x, way);
  if (w->dim == 3) {
    quat_between(s.quat, t.quat, turn);
  } else {
    turn[0] = 1.0, turn[1] = turn[2] = 0.0, turn[3] = 0.5 * (t.angle - s.angle);
  }
  const double angle[3] = {2.0 * turn[1], 2.0 * turn[2], 2.0 * turn[3]};
  return bent(way, o.v, t.v, h, 3) + w->body[i].bound * bent(angle, o.v + 3, t.v + 3, h, 3);
}

double world_saved_bend(const world *w, double h, const double *start, const double *coarse,
                        const double *fine) {
  double most = 0.0;
  if (w->model != NULL) {
    const int n = w->n_dof;
    double sum = 0.0;
    for (int k = 1; k <= n; k++) {
      const double apart = fine[k] - coarse[k];
      const double e = bent(&apart, start + n + k, fine + n + k, h, 1);
      sum += e * e;
    }
    return sqrt(sum);
  }
  for (int i = 0; i < w->n_body; i++) {
    most = fmax(most, body_bend(w, i, h, start, coarse, fine));
  }
  return most;
}

/* Of n velocities: what acceleration and lag of two steps in a row say of the later one, h^3 |j| 7/16 + h^2 |dr|. */
static double unsteady(const saved_step *before, const saved_step *now, ptrdiff_t at, int n) {
  double jerk = 0.0;
  double lag = 0.0;
  for (ptrdiff_t k = at; k < at + n; k++) {
    const double a_before = (before->coarse[k] - before->start[k]) / before->h;
    const double a_now = (now->coarse[k] - now->start[k]) / now->h;
    const double r_before = (before->fine[k] - before->coarse[k]) / before->h;
    const double r_now = (now->fine[k] - now->coarse[k]) / now->h;
    jerk += pow((a_now - a_before) / fmin(before->h, now->h), 2);
    lag += pow(r_now - r_before, 2);
  }
  return now->h * now->h * (now->h * sqrt(jerk) * 7.0 / 16.0 + sqrt(lag));
}

double world_saved_unsteady(const world *w, const saved_step *before, const saved_step *now) {
  const ptrdiff_t velocity = offsetof(body_state, v) / sizeof(double);
  double most = 0.0;
  if (w->model != NULL) {
    return unsteady(before, now, 1 + w->n_dof, w->n_dof);
  }
  for (int i = 0; i < w->n_body; i++) {
    const ptrdiff_t at = 1 + BODY_NUMBERS * (ptrdiff_t)i + velocity;
    most = fmax(most,
                unsteady(before, now, at, 3) + w->body[i].bound * unsteady(before, now, at + 3, 3));
  }
  return most;
}
