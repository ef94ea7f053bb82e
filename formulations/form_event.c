/* form_event.c - event-driven rigid contact: smooth arcs by GSL under error control, events located
 * on them, impacts by a velocity-level problem with Newton's law, and the contacts that persist
 * chosen by the acceleration-level problem (Pfeiffer & Glocker 1996). The reference for accuracy:
 * between events the error is the integrator's.
 *
 *   arc     event_arc.h: every touching contact sticks or slides
 *   event   an open gap closes; a normal force turns negative; a sticking force leaves the cone; a
 *           sliding speed comes to rest or turns round. Located by bisection of the substep, each
 *           trial one step of the integrator from the substep's start.
 *   after   impact where something closes: 0 <= l_n _|_ u_n+ + e u_n- >= 0 with the circle's cone; e = 0
 *           below `rest_speed` sqrt(a size), a as gravity and loads have it; what would rise by less than tol persists (MATHEMATICS 2.6.6), which ends
 *           Zeno sequences; then forces: slip directions from the motion.
 *
 * Joints are eliminated from arcs and problems, and closed again after every substep (event_space.h).
 * Where the acceleration-level problem has no solution (Painleve), an impact without collision follows (Genot & Brogliato
 * 1999); where Newton's law has none, because friction and joints hold a contact that it would have part, Poisson's does. With
 * paradox=stop the step is unsolved and says so, as it is where the impact has none either.
 */
#include "formulations/event/event_run.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Gaps, u and the curvature term are used of a set that is detected with this step at most, and the curvature is differenced over a
 * thousandth of it. */
static const double longest_probe = 1e-3; /* [s] */

static const base_field fields[] = {
    BASE_FIELD(event_options, facets, BASE_INT, "1", 16, 3, SLIP_FACETS_MAX,
               "directions of friction in impacts and at rest"),
    BASE_FIELD(event_options, max_events, BASE_INT, "1", 2000, 1, 1e9,
               "events in one step, then it fails"),
    BASE_FIELD(event_options, max_evaluations, BASE_INT, "1", 500000, 1, 2e9,
               "evaluations of the forces in one step, then it fails"),
    FORM_DISTRIBUTION_FIELD(event_options),
    BASE_FIELD(event_options, rest_speed, BASE_REAL, "1", 1e-3, 0, 1e3,
               "impacts do not bounce that are slower than this times sqrt(a s), a by gravity and "
               "loads, s the size of the smallest body"),
    BASE_FIELD(event_options, resolve, BASE_REAL, "1", 10, 1, 1e9,
               "speeds below this many errors of the integrator are none"),
    BASE_FIELD_CHOICE(event_options, restitution, "newton|poisson", EVENT_NEWTON, "law of impact"),
    BASE_FIELD_CHOICE(event_options, paradox, "impact|stop", PARADOX_IMPACT,
                      "accelerations without a solution: an impact without collision; Newton's law "
                      "without one: Poisson's; or the end"),
    BASE_FIELD(event_options, rate, BASE_REAL, "1/s", 20, 0, 1e6,
               "Baumgarte stabilisation of contacts"),
    BASE_FIELD(event_options, rtol, BASE_REAL, "1", 1e-9, 1e-13, 1, "relative error per substep"),
    BASE_FIELD(
        event_options, atol, BASE_REAL, "m, m/s", 1e-11, 1e-15, 1,
        "absolute error per substep, never below 64 roundings of the farthest coordinate or of "
        "what loads that cancel do in a step"),
};

/* ---- the step ------------------------------------------------------------------------------ */

static void close(void *st) {
  event_run *s = st;
  arc_close(&s->arc);
  watch_close(&s->watch);
  impulse_log_close(&s->log);
  event_resolve_close(s);
  if (s->driver != NULL) {
    s->gsl.gsl_odeiv2_driver_free(s->driver);
  }
  if (s->trial != NULL) {
    s->gsl.gsl_odeiv2_step_free(s->trial);
  }
  free(s->y);
  free(s->old);
  free(s->impulse);
  free(s->bias);
}

static base_status open(void *st, const void *opt, base_error *err) {
  event_run *s = st;
  s->opt = opt;
  return gsl_integrators(&s->gsl, err);
}

static base_status bind(event_run *s, world *w, base_error *err) {
  s->w = s->arc.w = w;
  s->arc.space = &s->space;
  s->arc.rate = s->opt->rate;
  s->arc.margin = 0.25 * world_size(w);
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
  s->system = (gsl_odeiv2_system){event_rates, NULL, n, s};
  s->driver = s->gsl.gsl_odeiv2_driver_alloc_y_new(&s->system, *s->gsl.gsl_odeiv2_step_rk8pd, 1e-5,
                                                   s->opt->atol, s->opt->rtol);
  s->trial = s->gsl.gsl_odeiv2_step_alloc(*s->gsl.gsl_odeiv2_step_rk8pd, n);
  if (s->y == NULL || s->driver == NULL || s->trial == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "event: no memory for %zu state variables", n);
  }
  s->from = s->y + n;
  s->acc = s->y + 2 * n;
  s->dev = s->y + 3 * n;
  s->substep = 1e-5;
  return BASE_OK;
}

/* An error control that asks for less than rounding would see nothing else and cut every substep. Positions far from the origin
 * carry rounding that the gaps inherit, and velocities what rounding leaves of loads that cancel. */
static void set_tolerance(event_run *s, double h) {
  double far = 0.0;
  for (int i = 0; i < s->n_config; i++) {
    far = fmax(far, fabs(s->y[i]));
  }
  s->atol = fmax(s->opt->atol, 64.0 * DBL_EPSILON * fmax(far, s->arc.load * h));
  (void)s->gsl.gsl_odeiv2_control_init(s->driver->c, s->atol, s->opt->rtol, 1.0, 0.0);
  event_set_slow(s);
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
  joint_log_write(&s->joints, c, s->impulse);
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
  out->work.fallbacks += s->arc.unshared + s->arc.unsettled;
  return BASE_OK;
}

static base_status step(void *st, world *w, double h, const formulation_solver *solver,
                        formulation_answer *out, base_error *err) {
  event_run *s = st;
  if (solver == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "event: needs a solver for impacts");
  }
  BASE_TRY(bind(s, w, err));
  s->solver = solver;
  s->err = err;
  s->solved = true;
  s->answer = (formulation_answer){.stiffness_ratio = HUGE_VAL};
  s->rest = s->opt->rest_speed * sqrt(world_most_acceleration(w) * world_size(w));
  s->arc.probe = fmin(longest_probe, h);
  s->arc.evaluations = 0;
  s->arc.unshared = 0;
  s->arc.unsettled = 0;
  double t = world_time(w);
  const double end = t + h;
  world_get_state(w, s->y, s->y + s->n_config);
  set_tolerance(s, h);
  joint_log_next_step(&s->joints);
  bool event = !s->started;
  if (!s->started) { /* velocities that joints forbid end before anything else is asked of the state */
    BASE_TRY(event_onto_joints(s, t, err));
  }
  s->started = true;
  for (int events = 0; s->solved && t < end;) {
    if (event) {
      if (++events > s->opt->max_events) {
        return BASE_FAIL(err, BASE_EEXTERNAL, "event: more than %d events before t=%g s",
                         s->opt->max_events, t);
      }
      BASE_TRY(event_resolve(s, t, err));
      set_tolerance(s, h);
      s->answer.work.mode_changes++;
    }
    if (s->solved) {
      BASE_TRY(event_substep(s, &t, end, &event, err));
    }
    if (s->arc.evaluations > s->opt->max_evaluations) {
      return BASE_FAIL(err, BASE_EEXTERNAL, "event: more than %d evaluations before t=%g s",
                       s->opt->max_evaluations, t);
    }
    if (t < end) {
      BASE_TRY(formulation_in_time(solver, "event", t, err));
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
    .lacks = EFFECT_ROLLING | EFFECT_TORSION | FORM_COORDINATES,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .options_size = sizeof(event_options),
    .state_size = sizeof(event_run),
    .dimension = dimension,
    .open = open,
    .close = close,
    .step = step,
};
