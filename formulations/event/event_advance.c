#include "formulations/event/event_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Trials of one search; the time is then known to 2^-48 of the substep. */
static const int max_trials = 48;
/* A substep after which a slip has left the direction of its acceleration by more than this, over what cannot be told from
 * none, is taken again at half its length. */
static const double most_across = 4;

int event_rates(double t, const double y[], double dy[], void *params) {
  event_run *s = params;
  world_set_state(s->w, t, y, y + s->n_config);
  world_config_rate(s->w, y, y + s->n_config, dy);
  return (arc_forces(&s->arc, dy + s->n_config, s->err) == BASE_OK) ? GSL_SUCCESS : GSL_EBADFUNC;
}

/* Does the state just evaluated break a mode of the arc? Directions are those at the start of the
 * substep; a sliding contact has turned round once it moves against its direction at a speed that counts. */
static bool broken(const event_run *s) {
  const arc *a = &s->arc;
  if (watch_closes(&s->watch, a) || !arc_carries(a)) {
    return true;
  }
  for (int i = 0; i < a->n; i++) {
    const arc_contact *k = &a->contact[i];
    const double along = k->u[1] * s->old[2 * i] + k->u[2] * s->old[2 * i + 1];
    if (!k->stick && k->mu > 0.0 && along < -0.5 * s->slow) {
      return true;
    }
  }
  return false;
}

/* The state `dt` after s->from, with the contacts' start directions put back first. */
static base_status try_step(event_run *s, double t, double dt, bool *breaks, base_error *err) {
  memcpy(s->y, s->from, ((size_t)s->n_config + (size_t)s->n_dof) * sizeof *s->y);
  for (int i = 0; i < s->arc.n; i++) {
    memcpy(s->arc.contact[i].direction, s->old + 2 * i, 2 * sizeof *s->old);
  }
  if (s->gsl.gsl_odeiv2_step_apply(s->trial, t, dt, s->y, s->dev, NULL, NULL, &s->system) !=
      GSL_SUCCESS) {
    return BASE_FAIL(err, BASE_EEXTERNAL, "event: integrator failed at t=%g s", t);
  }
  world_set_state(s->w, t + dt, s->y, s->y + s->n_config);
  BASE_TRY(arc_forces(&s->arc, s->acc, err));
  *breaks = broken(s);
  return BASE_OK;
}

/* Ends with y at the first instant found that breaks, within 2^-48 of the substep. */
static base_status locate(event_run *s, double t, double *dt, base_error *err) {
  double lo = 0.0, hi = *dt;
  bool breaks = false;
  for (int k = 0; k < max_trials && hi - lo > 1e-15 * (1.0 + fabs(t)); k++) {
    const double mid = 0.5 * (lo + hi);
    BASE_TRY(try_step(s, t, mid, &breaks, err));
    *(breaks ? &hi : &lo) = mid;
  }
  if (!breaks) {
    BASE_TRY(try_step(s, t, hi, &breaks, err));
  }
  *dt = hi;
  return BASE_OK;
}

/* Looks between `old` at t and `now` at t + dt for an instant at which the contact is closed: where its
 * speed changes sign, as long as the tangents there leave it open to doubt. *dt: that instant, if found. */
static base_status search_least(event_run *s, double t, watched old, watched now, double *dt,
                                bool *found, base_error *err) {
  double lo = 0.0, hi = *dt;
  *found = false;
  for (int k = 0; k < max_trials && !*found; k++) {
    const double mid = 0.5 * (lo + hi);
    watched at = now;
    BASE_TRY(try_step(s, t, mid, found, err));
    if (*found) {
      *dt = mid;
    } else if (!watch_find(&s->arc, now.id, &at.gap, &at.u)) {
      return BASE_OK;
    } else if (at.u < 0.0) {
      old = at;
      lo = mid;
    } else {
      now = at;
      hi = mid;
    }
    if (watch_least(old.gap, old.u, now.gap, now.u, hi - lo) > now.base - s->arc.set.tol) {
      return BASE_OK;
    }
  }
  return BASE_OK;
}

/* Contacts that touched and parted again within the substep of length *dt, which ended without an event. */
static base_status search_passing(event_run *s, double t, double *dt, bool *event,
                                  base_error *err) {
  const double whole = *dt;
  watched old, now;
  bool moved = false;
  for (int g = 0; !*event && watch_passes(&s->watch, &s->arc, whole, 0.25, &g, &old, &now);) {
    BASE_TRY(search_least(s, t, old, now, dt, event, err));
    moved = true;
    if (!*event) { /* the next candidate is asked for at the end of the substep */
      bool breaks;
      *dt = whole;
      BASE_TRY(try_step(s, t, whole, &breaks, err));
    }
  }
  if (moved && !*event) { /* y is that of one trial step: the same motion to the same tolerance */
    (void)s->gsl.gsl_odeiv2_evolve_reset(s->driver->e);
  }
  return BASE_OK;
}

/* Directions at the start of the substep. */
static base_status remember_directions(event_run *s, base_error *err) {
  if (s->arc.n > s->cap_old) {
    double *more = realloc(s->old, 2 * (size_t)s->arc.cap * sizeof *more);
    if (more == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "event: no memory for %d contacts", s->arc.n);
    }
    s->old = more;
    s->cap_old = s->arc.cap;
  }
  for (int i = 0; i < s->arc.n; i++) {
    memcpy(s->old + 2 * i, s->arc.contact[i].direction, 2 * sizeof *s->old);
  }
  return BASE_OK;
}

static base_status log_substep(event_run *s, double dt, base_error *err) {
  impulse_log_begin(&s->log);
  for (int i = 0; i < s->arc.n; i++) {
    impulse_entry *e;
    BASE_TRY(impulse_log_at(&s->log, s->arc.contact[i].id, 0.0, &e, err));
    impulse_log_add(e, dt, s->arc.contact[i].force);
  }
  impulse_log_end(&s->log, dt);
  return event_log_joints(s, dt, false, err);
}

base_status event_onto_joints(event_run *s, double t, base_error *err) {
  if ((world_effects(s->w) & EFFECT_JOINTS) == 0) {
    return BASE_OK;
  }
  double left;
  (void)s->gsl.gsl_odeiv2_evolve_reset(s->driver->e);
  return space_onto_joints(&s->space, s->w, t, s->y, s->y + s->n_config, s->from, &left, err);
}

/* One step of the integrator from *t, not beyond `end`; evaluated at its end. */
static base_status integrate(event_run *s, double *t, double end, base_error *err) {
  const double start = *t;
  const gsl_odeiv2_driver *g = s->driver;
  const int status =
      s->gsl.gsl_odeiv2_evolve_apply(g->e, g->c, g->s, &s->system, t, end, &s->substep, s->y);
  if (status != GSL_SUCCESS || !(*t > start)) {
    return (status == GSL_EBADFUNC && err != NULL && err->code != BASE_OK)
               ? err->code
               : BASE_FAIL(err, BASE_EEXTERNAL, "event: integrator gave up at t=%g s", start);
  }
  world_set_state(s->w, *t, s->y, s->y + s->n_config);
  return arc_forces(&s->arc, s->acc, err);
}

/* Does a contact that slides where it is accelerated to leave that direction by more than the integrator's error? */
static bool strays(const event_run *s) {
  for (int i = 0; i < s->arc.n; i++) {
    const arc_contact *k = &s->arc.contact[i];
    if (k->follows && arc_across(k) > most_across * s->slow) {
      return true;
    }
  }
  return false;
}

/* Those that have left it by that much have the direction of their slip from here on. */
static void let_turn(event_run *s) {
  for (int i = 0; i < s->arc.n; i++) {
    arc_contact *k = &s->arc.contact[i];
    k->follows = k->follows && arc_across(k) <= s->slow;
  }
}

base_status event_substep(event_run *s, double *t, double end, bool *event, base_error *err) {
  const double start = *t, before = world_closing_rate(s->w, s->arc.margin);
  const size_t n = (size_t)s->n_config + (size_t)s->n_dof;
  memcpy(s->from, s->y, n * sizeof *s->y);
  BASE_TRY(remember_directions(s, err));
  /* no pair comes nearer by more than half of the margin of the detection or of its distance: none passes unseen */
  double most = fmin(end - start, 0.25 / before);
  BASE_TRY(integrate(s, t, start + most, err));
  while ((*t - start) * (before + world_closing_rate(s->w, s->arc.margin)) > 1.0 || strays(s)) {
    most = 0.5 * (*t - start);
    *t = start;
    memcpy(s->y, s->from, n * sizeof *s->y);
    for (int i = 0; i < s->arc.n; i++) {
      memcpy(s->arc.contact[i].direction, s->old + 2 * i, 2 * sizeof *s->old);
    }
    (void)s->gsl.gsl_odeiv2_evolve_reset(s->driver->e);
    BASE_TRY(integrate(s, t, start + most, err));
  }
  double dt = *t - start;
  *event = broken(s);
  if (!*event) {
    BASE_TRY(search_passing(s, start, &dt, event, err));
  }
  if (*event) {
    BASE_TRY(locate(s, start, &dt, err));
    *t = start + dt;
    (void)s->gsl.gsl_odeiv2_evolve_reset(s->driver->e);
    (void)s->gsl.gsl_odeiv2_step_reset(s->driver->s);
  }
  BASE_TRY(watch_take(&s->watch, &s->arc, false, event_touching * s->arc.set.tol, err));
  let_turn(s);
  BASE_TRY(log_substep(s, dt, err));
  return event_onto_joints(s, *t, err);
}
