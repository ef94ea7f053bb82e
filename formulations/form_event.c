/* form_event.c - event-driven rigid contact: smooth arcs by GSL under error control, events located
 * on them, impacts by a velocity-level problem with Newton's law, and the contacts that persist
 * chosen by the acceleration-level problem (Pfeiffer & Glocker 1996). The reference for accuracy:
 * between events the error is the integrator's.
 *
 *   arc     event_arc.h: every touching contact sticks or slides
 *   event   an open gap closes; a normal force turns negative; a sticking force leaves the cone; a
 *           sliding speed comes to rest or turns round. Located by bisection of the substep, each
 *           trial one step of the integrator from the substep's start.
 *   after   impact where something closes faster than `touch_speed`: 0 <= l_n _|_ u_n+ + e u_n- >= 0
 *           with a faceted cone; e = 0 below `rest_speed`, which ends bouncing in finite time (the
 *           guard against Zeno sequences); then forces: slip directions from the motion.
 *
 * Where the acceleration-level problem has no solution (Painleve), the step is unsolved and says so.
 */
#include "formulations/event/event_run.h"

#include <gsl/gsl_errno.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const base_field fields[] = {
    BASE_FIELD(event_options, facets, BASE_INT, "1", 16, 3, SLIP_FACETS_MAX,
               "directions of friction in impacts and at rest"),
    BASE_FIELD(event_options, max_events, BASE_INT, "1", 2000, 1, 1e9,
               "events in one step, then it fails"),
    BASE_FIELD(event_options, rest_speed, BASE_REAL, "m/s", 1e-3, 0, 1e3,
               "slower impacts do not bounce"),
    BASE_FIELD(event_options, touch_speed, BASE_REAL, "m/s", 1e-7, 1e-15, 1,
               "slower closing is contact"),
    BASE_FIELD(event_options, stick_speed, BASE_REAL, "m/s", 1e-6, 1e-15, 1,
               "slower sliding is rest"),
    BASE_FIELD(event_options, rate, BASE_REAL, "1/s", 20, 0, 1e6,
               "Baumgarte stabilisation of contacts"),
    BASE_FIELD(event_options, rtol, BASE_REAL, "1", 1e-9, 1e-13, 1, "relative error per substep"),
    BASE_FIELD(event_options, atol, BASE_REAL, "m, m/s", 1e-11, 1e-15, 1,
               "absolute error per substep, never below 64 roundings of the farthest coordinate"),
};

static int right_hand_side(double t, const double y[], double dy[], void *params) {
  event_run *s = params;
  world_set_state(s->w, t, y, y + s->n_config);
  world_config_rate(s->w, y, y + s->n_config, dy);
  return (arc_forces(&s->arc, dy + s->n_config, s->err) == BASE_OK) ? GSL_SUCCESS : GSL_EBADFUNC;
}

/* ---- arcs ---------------------------------------------------------------------------------- */

/* Does the state just evaluated break a mode of the arc? Directions are those at its start. */
static bool broken(const event_run *s, const double *old) {
  const arc *a = &s->arc;
  if (a->open_gap < -a->set.tol) {
    return true;
  }
  for (int i = 0; i < a->n; i++) {
    const arc_contact *k = &a->contact[i];
    const double along = k->u[1] * old[2 * i] + k->u[2] * old[2 * i + 1];
    if (!k->present || k->force[0] < 0.0 ||
        (k->stick && hypot(k->force[1], k->force[2]) > k->mu * k->force[0] * (1.0 + 1e-9)) ||
        (!k->stick && k->mu > 0.0 && along < -1e-12)) {
      return true;
    }
  }
  return false;
}

/* The state `dt` after s->from, with the contacts' start directions put back first. */
static base_status try_step(event_run *s, double t, double dt, const double *old, bool *breaks,
                            base_error *err) {
  memcpy(s->y, s->from, (size_t)(s->n_config + s->n_dof) * sizeof *s->y);
  for (int i = 0; i < s->arc.n; i++) {
    memcpy(s->arc.contact[i].direction, old + 2 * i, 2 * sizeof *old);
  }
  if (gsl_odeiv2_step_apply(s->trial, t, dt, s->y, s->dev, NULL, NULL, &s->system) != GSL_SUCCESS) {
    return BASE_FAIL(err, BASE_EEXTERNAL, "event: integrator failed at t=%g s", t);
  }
  world_set_state(s->w, t + dt, s->y, s->y + s->n_config);
  BASE_TRY(arc_forces(&s->arc, s->acc, err));
  *breaks = broken(s, old);
  return BASE_OK;
}

/* Ends with y at the first instant found that breaks, within 2^-48 of the substep. */
static base_status locate(event_run *s, double t, double *dt, const double *old, base_error *err) {
  double lo = 0.0, hi = *dt;
  bool breaks = true;
  for (int k = 0; k < 48 && hi - lo > 1e-15 * (1.0 + fabs(t)); k++) {
    const double mid = 0.5 * (lo + hi);
    BASE_TRY(try_step(s, t, mid, old, &breaks, err));
    *(breaks ? &hi : &lo) = mid;
  }
  if (!breaks) {
    BASE_TRY(try_step(s, t, hi, old, &breaks, err));
  }
  *dt = hi;
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
  return BASE_OK;
}

/* One accepted substep, cut at the first event; *event says whether it was. */
static base_status substep(event_run *s, double *t, double end, bool *event, base_error *err) {
  double old[2 * 64];
  const double start = *t;
  memcpy(s->from, s->y, (size_t)(s->n_config + s->n_dof) * sizeof *s->y);
  for (int i = 0; i < s->arc.n; i++) {
    memcpy(old + 2 * i, s->arc.contact[i].direction, 2 * sizeof *old);
  }
  gsl_odeiv2_driver *g = s->driver;
  const int status =
      gsl_odeiv2_evolve_apply(g->e, g->c, g->s, &s->system, t, end, &s->substep, s->y);
  if (status != GSL_SUCCESS || !(*t > start)) {
    return (status == GSL_EBADFUNC && err != NULL && err->code != BASE_OK)
               ? err->code
               : BASE_FAIL(err, BASE_EEXTERNAL, "event: integrator gave up at t=%g s", start);
  }
  world_set_state(s->w, *t, s->y, s->y + s->n_config);
  BASE_TRY(arc_forces(&s->arc, s->acc, err));
  double dt = *t - start;
  *event = broken(s, old);
  if (*event) {
    BASE_TRY(locate(s, start, &dt, old, err));
    *t = start + dt;
    (void)gsl_odeiv2_evolve_reset(g->e);
    (void)gsl_odeiv2_step_reset(g->s);
  }
  return log_substep(s, dt, err);
}

/* ---- the step ------------------------------------------------------------------------------ */

static void close(void *st) {
  event_run *s = st;
  arc_close(&s->arc);
  impulse_log_close(&s->log);
  event_resolve_close(s);
  if (s->driver != NULL) {
    gsl_odeiv2_driver_free(s->driver);
  }
  if (s->trial != NULL) {
    gsl_odeiv2_step_free(s->trial);
  }
  free(s->y);
  free(s->impulse);
  free(s->bias);
}

static base_status open(void *st, const void *opt, base_error *err) {
  (void)err;
  ((event_run *)st)->opt = opt;
  return BASE_OK;
}

static base_status bind(event_run *s, world *w, base_error *err) {
  s->w = s->arc.w = w;
  s->arc.rate = s->opt->rate;
  if (s->y != NULL) {
    return BASE_OK;
  }
  s->n_config = world_n_config(w);
  s->n_dof = world_n_dof(w);
  const size_t n = (size_t)s->n_config + (size_t)s->n_dof;
  if (s->n_dof < 1) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "event: nothing moves in this scene");
  }
  s->y = calloc(4 * n, sizeof *s->y);
  s->system = (gsl_odeiv2_system){right_hand_side, NULL, n, s};
  s->driver = gsl_odeiv2_driver_alloc_y_new(&s->system, gsl_odeiv2_step_rk8pd, 1e-5, s->opt->atol,
                                            s->opt->rtol);
  s->trial = gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk8pd, n);
  if (s->y == NULL || s->driver == NULL || s->trial == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "event: no memory for %zu state variables", n);
  }
  s->from = s->y + n;
  s->acc = s->y + 2 * n;
  s->dev = s->y + 3 * n;
  s->substep = 1e-5;
  return BASE_OK;
}

/* Positions far from the origin carry rounding that the gaps inherit: an error control that asks for
 * less would see nothing else and cut every substep. */
static void set_tolerance(event_run *s) {
  double far = 0.0;
  for (int i = 0; i < s->n_config; i++) {
    far = fmax(far, fabs(s->y[i]));
  }
  const double atol = fmax(s->opt->atol, 64.0 * DBL_EPSILON * far);
  (void)gsl_odeiv2_control_init(s->driver->c, atol, s->opt->rtol, 1.0, 0.0);
}

static base_status report(event_run *s, double h, formulation_answer *out, base_error *err) {
  contact_set *c = &s->out;
  BASE_TRY(world_contacts(s->w, h, -1.0, c, err));
  if (c->n_row + c->n_contact >= s->cap_out) {
    s->cap_out = 2 * (c->n_row + c->n_contact) + 8;
    free(s->impulse);
    free(s->bias);
    s->impulse = calloc((size_t)s->cap_out, sizeof *s->impulse);
    s->bias = calloc((size_t)s->cap_out, sizeof *s->bias);
    if (s->impulse == NULL || s->bias == NULL) {
      s->cap_out = 0;
      return BASE_FAIL(err, BASE_ENOMEM, "event: no memory for %d contact rows", c->n_row);
    }
  }
  (void)impulse_log_write(&s->log, c, s->impulse);
  for (int i = 0; i < c->n_contact; i++) {
    s->bias[i] = HUGE_VAL; /* the contact law was met along the step, not at its end alone */
  }
  *out = s->answer;
  out->impulse = s->impulse;
  out->bias = s->bias;
  out->v_next = s->y + s->n_config;
  out->set = c;
  out->solved = s->solved;
  out->n_active = s->arc.n;
  out->work.evaluations = s->arc.evaluations;
  return BASE_OK;
}

static base_status step(void *st, world *w, double h, const formulation_solver *solver,
                        formulation_answer *out, base_error *err) {
  event_run *s = st;
  if (solver == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "event: needs a solver for impacts");
  }
  BASE_TRY(formulation_lacks("event", world_effects(w),
                             EFFECT_ROLLING | EFFECT_TORSION | EFFECT_JOINTS, err));
  BASE_TRY(bind(s, w, err));
  s->solver = solver;
  s->err = err;
  s->solved = true;
  s->answer = (formulation_answer){.stiffness_ratio = HUGE_VAL};
  s->arc.evaluations = 0;
  double t = world_time(w);
  const double end = t + h;
  world_get_state(w, s->y, s->y + s->n_config);
  set_tolerance(s);
  bool event = !s->started;
  s->started = true;
  for (int events = 0; s->solved && t < end;) {
    if (event) {
      if (++events > s->opt->max_events) {
        return BASE_FAIL(err, BASE_EEXTERNAL, "event: more than %d events before t=%g s",
                         s->opt->max_events, t);
      }
      BASE_TRY(event_resolve(s, t, err));
      s->answer.work.mode_changes++;
    }
    if (s->solved) {
      BASE_TRY(substep(s, &t, end, &event, err));
    }
  }
  s->started = s->solved && !event;
  world_set_state(w, t, s->y, s->y + s->n_config);
  BASE_TRY(report(s, h, out, err));
  impulse_log_next_step(&s->log);
  return BASE_OK;
}

static long dimension(int dim, int p, const void *opt) {
  const event_options *o = opt;
  return (long)p * ((dim == 2) ? 4 : o->facets + 2);
}

const formulation form_event = {
    .name = "event",
    .title = "Event-driven",
    .cite = "pfeiffer1996",
    .words = "Stops at every impact and integrates the smooth motion between.",
    .when = "Impacts are few and the times at which they happen must be exact.",
    .model =
        FORM_UNILATERAL | FORM_FRICTION | FORM_CONE_POLYHEDRAL | FORM_ACCELERATION | FORM_NO_LCP,
    .sets = 1u << LCP_ORTHANT,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .options_size = sizeof(event_options),
    .state_size = sizeof(event_run),
    .dimension = dimension,
    .open = open,
    .close = close,
    .step = step,
};
