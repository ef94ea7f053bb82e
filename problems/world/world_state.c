/* world_state.c - the configuration as one vector, for formulations that integrate themselves, and the whole state as
 * one, to come back to. */
#include "problems/vec.h"
#include "problems/world/world_data.h"

/* Numbers of a body's configuration: position, then angle or quaternion where it can turn. */
static int n_config(const world *w, const body *b) {
  return w->dim + (b->spins ? ((w->dim == 2) ? 1 : 4) : 0);
}

int world_n_config(const world *w) {
  int n = (w->model != NULL) ? w->n_dof : 0;
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
      place_kinematic(w, i);
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

void world_load(world *w, const double *state) {
  w->t = *state++;
  if (w->model != NULL) {
    memcpy(w->q, state, (size_t)w->n_dof * sizeof *state);
    memcpy(w->qv, state + w->n_dof, (size_t)w->n_dof * sizeof *state);
    return;
  }
  for (int i = 0; i < w->n_body; i++, state += BODY_NUMBERS) {
    body *b = &w->body[i];
    body_state then;
    memcpy(&then, state, sizeof then);
    b->at = then.at;
    b->angle = then.angle;
    memcpy(b->quat, then.quat, sizeof b->quat);
    memcpy(b->v, then.v, sizeof b->v);
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
    *velocity = fmax(*velocity, apart(s.v, t.v, 3) + w->body[i].bound * apart(s.v + 3, t.v + 3, 3));
  }
}
