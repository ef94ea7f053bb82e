#include "formulations/event/event_space.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void layout(void *state, base_arena *m) {
  event_space *s = state;
  s->gap = BASE_ARRAY(m, double, s->cap_contact);
  s->drift = BASE_ARRAY(m, double, s->cap_row);
  s->zero = BASE_ARRAY(m, double, s->cap_dof);
}

base_status space_reserve(event_space *s, const contact_set *c, base_error *err) {
  if (s->mem != NULL && c->n_row <= s->cap_row && c->n_contact <= s->cap_contact &&
      c->n_dof <= s->cap_dof) {
    return BASE_OK;
  }
  s->cap_row = 2 * c->n_row + 8;
  s->cap_contact = 2 * c->n_contact + 8;
  s->cap_dof = c->n_dof + 1;
  BASE_TRY(form_memory(&s->mem, layout, s, err));
  memset(s->zero, 0, (size_t)s->cap_dof * sizeof *s->zero);
  return BASE_OK;
}

void space_close(event_space *s) {
  form_assembly_close(&s->a);
  contact_memory_close(&s->memory);
  free(s->mem);
  *s = (event_space){0};
}

/* C and r of the contacts whose gap is 0, from v_free and s->drift. */
static base_status pose(event_space *s, const contact_set *c, const double *v_free,
                        base_error *err) {
  static const form_rule rule = {
      .level = FORM_LEVEL_VELOCITY, .activation = FORM_CLOSED, .all_rows = true};
  s->view = *c;
  s->view.gap = s->gap;
  s->view.v_free = v_free;
  s->view.u_drift = s->drift;
  BASE_TRY(
      contact_memory_begin(&s->memory, (contact_layout){.head = PAST_CLOSED + 1}, &s->view, err));
  BASE_TRY(form_assembly_begin(&s->a, &s->view, FORM_ROWS_TANGENT, &rule, &s->memory, err));
  contact_memory_forget(&s->memory);
  return form_assembly_eliminate(&s->a, err);
}

base_status space_impact(event_space *s, const contact_set *c, base_error *err) {
  contact_relative_velocity(c, c->v, NULL, s->drift);
  for (int r = 0; r < c->n_row; r++) {
    s->drift[r] = c->u_before[r] - s->drift[r];
  }
  return pose(s, c, c->v, err);
}

/* (dJ/dt) v and the rate of the drift itself. */
static void curve(event_space *s, const contact_set *c) {
  contact_relative_velocity(c, c->v, NULL, s->drift);
  for (int r = 0; r < c->n_row; r++) {
    s->drift[r] = (c->u_curve[r] + c->u_drift[r] + s->drift[r] - c->u_before[r]) / c->h;
  }
}

base_status space_forces(event_space *s, const contact_set *c, const double *acc, base_error *err) {
  curve(s, c);
  return pose(s, c, acc, err);
}

base_status space_constrain(event_space *s, const contact_set *c, double rate, double *acc,
                            base_error *err) {
  const int first = c->row_start[c->n_contact];
  BASE_TRY(space_reserve(s, c, err));
  for (int g = 0; g < c->n_contact; g++) {
    s->gap[g] = 1.0;
  }
  curve(s, c);
  for (int r = first; r < c->n_row; r++) {
    s->drift[r] += 2.0 * rate * c->u_before[r] + rate * rate * c->joint_error[r - first];
  }
  BASE_TRY(pose(s, c, acc, err));
  form_assembly_answer(&s->a, s->zero);
  memcpy(acc, s->a.v_next, (size_t)c->n_dof * sizeof *acc);
  return BASE_OK;
}

/* ---- joints -------------------------------------------------------------------------------- */

/* A probe of this length finds the joints; no contact takes part [s]. */
static const double probe = 1e-6;

static base_status joints_of(event_space *s, world *w, contact_set *c, base_error *err) {
  BASE_TRY(world_contacts(w, probe, 0.0, c, err));
  BASE_TRY(space_reserve(s, c, err));
  for (int g = 0; g < c->n_contact; g++) {
    s->gap[g] = 1.0;
  }
  return BASE_OK;
}

static double largest_error(const contact_set *c) {
  double largest = 0.0;
  for (int r = c->row_start[c->n_contact]; r < c->n_row; r++) {
    largest = fmax(largest, fabs(c->joint_error[r - c->row_start[c->n_contact]]));
  }
  return largest;
}

/* One Newton step of the configuration: the displacement N v with J_b v = -C(q). */
static base_status correct(event_space *s, world *w, const contact_set *c, double *config,
                           double *rate, base_error *err) {
  const int first = c->row_start[c->n_contact], n_config = world_n_config(w);
  memset(s->drift, 0, (size_t)first * sizeof *s->drift);
  memcpy(s->drift + first, c->joint_error, (size_t)(c->n_row - first) * sizeof *s->drift);
  BASE_TRY(pose(s, c, s->zero, err));
  form_assembly_answer(&s->a, s->zero);
  world_config_rate(w, config, s->a.v_next, rate);
  for (int i = 0; i < n_config; i++) {
    config[i] += rate[i];
  }
  return BASE_OK;
}

base_status space_onto_joints(event_space *s, world *w, double t, double *config, double *v,
                              double *rate, double *left, base_error *err) {
  contact_set c;
  world_set_state(w, t, config, v);
  BASE_TRY(joints_of(s, w, &c, err));
  *left = 0.0;
  if (c.n_group == c.n_contact) {
    return BASE_OK;
  }
  /* Newton's steps end where one no longer halves the error: that is rounding */
  double before = HUGE_VAL;
  *left = largest_error(&c);
  while (*left > 0.0 && *left < 0.5 * before) {
    before = *left;
    BASE_TRY(correct(s, w, &c, config, rate, err));
    world_set_state(w, t, config, v);
    BASE_TRY(joints_of(s, w, &c, err));
    *left = largest_error(&c);
  }
  BASE_TRY(space_impact(s, &c, err));
  form_assembly_answer(&s->a, s->zero);
  memcpy(v, s->a.v_next, (size_t)c.n_dof * sizeof *v);
  world_set_state(w, t, config, v);
  world_get_state(w, config, v); /* quaternions of length one */
  return BASE_OK;
}
