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
#include "formulations/event_arc.h"
#include "formulations/slip_problem.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct options {
  int facets, max_events;
  double rest_speed, touch_speed, stick_speed, rate, rtol, atol;
} options;

static const base_field fields[] = {
    BASE_FIELD(options, facets, BASE_INT, "1", 16, 3, SLIP_FACETS_MAX,
               "directions of friction in impacts and at rest"),
    BASE_FIELD(options, max_events, BASE_INT, "1", 2000, 1, 1e9,
               "events in one step, then it fails"),
    BASE_FIELD(options, rest_speed, BASE_REAL, "m/s", 1e-3, 0, 1e3, "slower impacts do not bounce"),
    BASE_FIELD(options, touch_speed, BASE_REAL, "m/s", 1e-7, 1e-15, 1, "slower closing is contact"),
    BASE_FIELD(options, stick_speed, BASE_REAL, "m/s", 1e-6, 1e-15, 1, "slower sliding is rest"),
    BASE_FIELD(options, rate, BASE_REAL, "1/s", 20, 0, 1e6, "Baumgarte stabilisation of contacts"),
    BASE_FIELD(options, rtol, BASE_REAL, "1", 1e-9, 1e-13, 1, "relative error per substep"),
    BASE_FIELD(options, atol, BASE_REAL, "m, m/s", 1e-11, 1e-15, 1, "absolute error per substep"),
};

typedef struct state {
  const options *opt;
  const formulation_solver *solver; /* borrowed, during step only */
  base_error *err;
  world *w;
  arc arc;
  impulse_log log;
  contact_set view; /* what the assembly works on */
  form_assembly a;
  contact_memory memory;
  slip_problem p;
  bool started, solved;
  int n_config, n_dof;
  gsl_odeiv2_system system;
  gsl_odeiv2_driver *driver;
  gsl_odeiv2_step *trial;       /* single steps of the bisection */
  double *y, *from, *acc, *dev; /* n_config + n_dof each */
  double substep;
  double *row, *gap, *z; /* scratch of a problem: rows, contacts, unknowns */
  int cap_row, cap_contact, cap_z;
  double *impulse, *bias; /* of the answer */
  int cap_out;
  contact_set out;
  formulation_answer answer;
} state;

static int right_hand_side(double t, const double y[], double dy[], void *params) {
  state *s = params;
  world_set_state(s->w, t, y, y + s->n_config);
  world_config_rate(s->w, y, y + s->n_config, dy);
  return (arc_forces(&s->arc, dy + s->n_config, s->err) == BASE_OK) ? GSL_SUCCESS : GSL_EBADFUNC;
}

/* ---- problems at events -------------------------------------------------------------------- */

static base_status grow_scratch(state *s, const contact_set *c, base_error *err) {
  if (c->n_row >= s->cap_row || c->n_contact >= s->cap_contact) {
    s->cap_row = 2 * c->n_row + 8;
    s->cap_contact = 2 * c->n_contact + 8;
    s->cap_z = s->cap_contact * (s->opt->facets + 2);
    free(s->row);
    free(s->gap);
    free(s->z);
    s->row = calloc((size_t)s->cap_row * 3, sizeof *s->row);
    s->gap = calloc((size_t)s->cap_contact, sizeof *s->gap);
    s->z = calloc((size_t)s->cap_z, sizeof *s->z);
    if (s->row == NULL || s->gap == NULL || s->z == NULL) {
      s->cap_row = s->cap_contact = 0;
      return BASE_FAIL(err, BASE_ENOMEM, "event: no memory for %d contacts", c->n_contact);
    }
  }
  return BASE_OK;
}

/* Touching: within a hundred closed-gap tolerances, more than the drift of an arc. */
static bool touches(const contact_set *c, int g) {
  return c->gap[g] <= 100.0 * c->tol;
}

/* The contact space of the set with v_free and u_drift replaced and only the contacts marked by
 * gap 0 closed. */
static base_status assemble(state *s, const contact_set *c, const double *v_free,
                            const double *drift, base_error *err) {
  static const form_rule rule = {.level = FORM_LEVEL_VELOCITY, .activation = FORM_CLOSED};
  s->view = *c;
  s->view.gap = s->gap;
  s->view.v_free = v_free;
  s->view.u_drift = drift;
  BASE_TRY(contact_memory_begin(&s->memory, 1, &s->view, err));
  BASE_TRY(form_assembly_begin(&s->a, &s->view, FORM_ROWS_TANGENT, &rule, &s->memory, err));
  BASE_TRY(form_assembly_eliminate(&s->a, err));
  contact_memory_forget(&s->memory);
  return slip_begin(&s->p, &s->a, s->opt->facets, err);
}

/* Poses, solves, and leaves lambda (n_row of the assembly) in a.lambda; s->solved says how. */
static base_status solve(state *s, const double *u0, double *lambda, base_error *err) {
  lcp_problem p;
  lcp_outcome claimed = LCP_NUMERICAL;
  slip_pose(&s->p, &s->a, u0, &p);
  memset(s->z, 0, (size_t)p.M.n * sizeof *s->z);
  BASE_TRY(s->solver->solve(s->solver->ctx, &p, s->z, &claimed, err));
  s->answer.work.solves++;
  s->answer.lcp_dim = (p.M.n > s->answer.lcp_dim) ? p.M.n : s->answer.lcp_dim;
  s->answer.work.rays += (claimed == LCP_RAY || claimed == LCP_INFEASIBLE);
  s->solved = claimed == LCP_SOLVED;
  slip_impulses(&s->p, &s->a, s->z, lambda);
  return BASE_OK;
}

/* Marks the touching contacts and says whether one of them closes. */
static bool mark_closing(state *s, const contact_set *c) {
  bool closing = false;
  for (int g = 0; g < c->n_contact; g++) {
    s->gap[g] = touches(c, g) ? 0.0 : 1.0;
    closing = closing || (touches(c, g) && c->u_before[c->row_start[g]] < -s->opt->touch_speed);
  }
  return closing;
}

static base_status impact(state *s, const contact_set *c, base_error *err) {
  double *drift = s->row, *u0 = s->row + s->cap_row;
  contact_relative_velocity(c, c->v, NULL, drift);
  for (int r = 0; r < c->n_row; r++) {
    drift[r] = c->u_before[r] - drift[r];
  }
  BASE_TRY(assemble(s, c, c->v, drift, err));
  for (int i = 0; i < s->a.n_contact; i++) {
    const int g = s->a.group[i], first = s->a.row[i];
    const double u = c->u_before[c->row_start[g]];
    memcpy(u0 + first, s->a.r + first, (size_t)form_rows_of(&s->a, i) * sizeof *u0);
    if (c->restitution != NULL && u < -s->opt->rest_speed) {
      u0[first] += c->restitution[g] * u;
    }
  }
  double *lambda = s->row + 2 * (ptrdiff_t)s->cap_row;
  BASE_TRY(solve(s, u0, lambda, err));
  for (int i = 0; s->solved && i < s->a.n_contact; i++) {
    impulse_entry *e;
    BASE_TRY(impulse_log_at(&s->log, c->id[s->a.group[i]], 0.0, &e, err));
    for (int r = 0; r < form_rows_of(&s->a, i); r++) {
      e->impulse[r] += lambda[s->a.row[i] + r];
    }
  }
  form_assembly_answer(&s->a, lambda);
  memcpy(s->y + s->n_config, s->a.v_next, (size_t)s->n_dof * sizeof *s->y);
  return BASE_OK;
}

/* Sliding contacts keep their direction; the others get the cone. */
static void set_directions(state *s, const contact_set *c) {
  for (int i = 0; i < s->a.n_contact; i++) {
    const int g = s->a.group[i], nt = c->rows[g].tangent;
    const double *u = c->u_before + c->row_start[g] + 1;
    const double slip = (nt == 2) ? hypot(u[0], u[1]) : (nt == 1 ? fabs(u[0]) : 0.0);
    for (int t = 0; t < nt && slip > s->opt->stick_speed; t++) {
      s->p.direction[2 * i + t] = u[t] / slip;
      s->p.mu[i] = c->mu_kinetic[g];
    }
  }
}

/* Tangential acceleration of contact i: u0 + C lambda over its tangent rows. */
static double departure(const state *s, int i, const double *u0, const double *lambda,
                        double along[2]) {
  const form_assembly *a = &s->a;
  along[0] = along[1] = 0.0;
  for (int t = 0; t < form_rows_of(a, i) - 1; t++) {
    const int r = a->row[i] + 1 + t;
    along[t] = u0[r];
    for (int j = 0; j < a->n_row; j++) {
      along[t] += s->p.C[(size_t)j * (size_t)a->n_row + (size_t)r] * lambda[j];
    }
  }
  return hypot(along[0], along[1]);
}

/* The facets of contact i use up all of mu lambda_n. */
static bool saturated(const state *s, int i) {
  const int first = s->p.first[i], last = s->p.first[i + 1] - 1;
  double sum = 0.0;
  for (int k = first + 1; k < last; k++) {
    sum += s->z[k];
  }
  return sum > 0.0 && sum >= s->p.mu[i] * s->z[first] * (1.0 - 1e-9);
}

/* A contact at rest sticks if the forces leave it at rest inside its cone. It starts to slide along
 * its acceleration; one that redundant neighbours hold at rest on the edge of its cone keeps that
 * force, as if it slid against it: least-norm sharing among sticking contacts could not. */
static base_status keep_contact(state *s, const contact_set *c, int i, const double *u0,
                                const double *lambda, base_error *err) {
  const double *d = s->p.direction + 2 * i;
  double scale = 0.0, along[2];
  BASE_TRY(arc_reserve(&s->arc, s->arc.n + 1, err));
  arc_contact *k = &s->arc.contact[s->arc.n++];
  *k = (arc_contact){.id = c->id[s->a.group[i]], .direction = {d[0], d[1]}};
  k->stick = d[0] == 0.0 && d[1] == 0.0 && form_rows_of(&s->a, i) > 1;
  for (int r = 0; r < s->a.n_row; r++) {
    scale = fmax(scale, fabs(u0[r]));
  }
  const double size = departure(s, i, u0, lambda, along);
  const double *f = lambda + s->a.row[i];
  const int rows = form_rows_of(&s->a, i);
  const double tangent[2] = {rows > 1 ? f[1] : 0.0, rows > 2 ? f[2] : 0.0};
  const double friction = k->stick ? hypot(tangent[0], tangent[1]) : 0.0;
  if (k->stick && size > 1e-9 * scale) {
    k->stick = false;
    k->direction[0] = along[0] / size;
    k->direction[1] = along[1] / size;
  } else if (k->stick && saturated(s, i)) {
    k->stick = false;
    k->direction[0] = -tangent[0] / friction;
    k->direction[1] = -tangent[1] / friction;
  }
  return BASE_OK;
}

/* Which touching contacts persist, and how: the acceleration-level problem. */
static base_status choose_modes(state *s, const contact_set *c, base_error *err) {
  double *drift = s->row, *u0 = s->row + s->cap_row;
  BASE_TRY(world_acceleration(s->w, s->acc, err));
  contact_relative_velocity(c, c->v, NULL, drift);
  for (int r = 0; r < c->n_row; r++) {
    drift[r] = (c->u_curve[r] + c->u_drift[r] + drift[r] - c->u_before[r]) / c->h;
  }
  for (int g = 0; g < c->n_contact; g++) {
    const bool parts = c->u_before[c->row_start[g]] > s->opt->touch_speed;
    s->gap[g] = (touches(c, g) && !parts) ? 0.0 : 1.0;
  }
  BASE_TRY(assemble(s, c, s->acc, drift, err));
  set_directions(s, c);
  memcpy(u0, s->a.r, (size_t)s->a.n_row * sizeof *u0);
  double *lambda = s->row + 2 * (ptrdiff_t)s->cap_row;
  BASE_TRY(solve(s, u0, lambda, err));
  s->arc.n = 0;
  for (int i = 0; s->solved && i < s->a.n_contact; i++) {
    if (lambda[s->a.row[i]] > 0.0) {
      BASE_TRY(keep_contact(s, c, i, u0, lambda, err));
    }
  }
  return BASE_OK;
}

/* Forces after a jump start the next trapezoid. */
static base_status restart_forces(state *s, base_error *err) {
  BASE_TRY(arc_forces(&s->arc, s->acc, err));
  impulse_log_begin(&s->log);
  for (int i = 0; i < s->arc.n; i++) {
    impulse_entry *e;
    BASE_TRY(impulse_log_at(&s->log, s->arc.contact[i].id, 0.0, &e, err));
    memcpy(e->force, s->arc.contact[i].force, sizeof e->force);
    e->seen = true;
  }
  for (int i = 0; i < s->log.n; i++) {
    if (!s->log.entry[i].seen) {
      memset(s->log.entry[i].force, 0, sizeof s->log.entry[i].force);
    }
  }
  return BASE_OK;
}

/* Everything that happens at one instant. */
static base_status at_event(state *s, double t, base_error *err) {
  contact_set c;
  world_set_state(s->w, t, s->y, s->y + s->n_config);
  BASE_TRY(world_contacts_curved(s->w, 1e-3, -1.0, &c, err));
  BASE_TRY(grow_scratch(s, &c, err));
  if (mark_closing(s, &c)) {
    BASE_TRY(impact(s, &c, err));
    world_set_state(s->w, t, s->y, s->y + s->n_config);
    if (!s->solved) {
      return BASE_OK;
    }
    BASE_TRY(world_contacts_curved(s->w, 1e-3, -1.0, &c, err));
    BASE_TRY(grow_scratch(s, &c, err));
  }
  BASE_TRY(choose_modes(s, &c, err));
  return s->solved ? restart_forces(s, err) : BASE_OK;
}

/* ---- arcs ---------------------------------------------------------------------------------- */

/* Does the state just evaluated break a mode of the arc? Directions are those at its start. */
static bool broken(const state *s, const double *old) {
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
static base_status try_step(state *s, double t, double dt, const double *old, bool *breaks,
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
static base_status locate(state *s, double t, double *dt, const double *old, base_error *err) {
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

static base_status log_substep(state *s, double dt, base_error *err) {
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
static base_status substep(state *s, double *t, double end, bool *event, base_error *err) {
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
  state *s = st;
  arc_close(&s->arc);
  impulse_log_close(&s->log);
  form_assembly_close(&s->a);
  contact_memory_close(&s->memory);
  slip_close(&s->p);
  if (s->driver != NULL) {
    gsl_odeiv2_driver_free(s->driver);
  }
  if (s->trial != NULL) {
    gsl_odeiv2_step_free(s->trial);
  }
  free(s->y);
  free(s->row);
  free(s->gap);
  free(s->z);
  free(s->impulse);
  free(s->bias);
}

static base_status open(void *st, const void *opt, base_error *err) {
  (void)err;
  ((state *)st)->opt = opt;
  return BASE_OK;
}

static void forget(void *st) {
  state *s = st;
  s->started = false;
  s->log.n = s->arc.n = 0;
}

static base_status bind(state *s, world *w, base_error *err) {
  s->w = s->arc.w = w;
  s->arc.rate = s->opt->rate;
  if (s->y != NULL) {
    return BASE_OK;
  }
  s->n_config = world_n_config(w);
  s->n_dof = world_n_dof(w);
  const size_t n = (size_t)s->n_config + (size_t)s->n_dof;
  if (n == 0) {
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

static base_status report(state *s, double h, formulation_answer *out, base_error *err) {
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
  out->residual = s->solved ? 0.0 : 1.0;
  out->n_active = s->arc.n;
  out->work.evaluations = s->arc.evaluations;
  return BASE_OK;
}

static base_status step(void *st, world *w, double h, const formulation_solver *solver,
                        formulation_answer *out, base_error *err) {
  state *s = st;
  if (solver == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "event: needs a solver for impacts");
  }
  BASE_TRY(bind(s, w, err));
  s->solver = solver;
  s->err = err;
  s->solved = true;
  s->answer = (formulation_answer){.stiffness_ratio = HUGE_VAL};
  s->arc.evaluations = 0;
  double t = world_time(w);
  const double end = t + h;
  world_get_state(w, s->y, s->y + s->n_config);
  bool event = !s->started;
  s->started = true;
  for (int events = 0; s->solved && t < end;) {
    if (event) {
      if (++events > s->opt->max_events) {
        return BASE_FAIL(err, BASE_EEXTERNAL, "event: more than %d events before t=%g s",
                         s->opt->max_events, t);
      }
      BASE_TRY(at_event(s, t, err));
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
  const options *o = opt;
  return (long)p * ((dim == 2) ? 4 : o->facets + 2);
}

const formulation form_event = {
    .name = "event",
    .title = "Event-driven",
    .cite = "Pfeiffer & Glocker 1996",
    .model =
        FORM_UNILATERAL | FORM_FRICTION | FORM_CONE_POLYHEDRAL | FORM_ACCELERATION | FORM_NO_LCP,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .options_size = sizeof(options),
    .state_size = sizeof(state),
    .dimension = dimension,
    .open = open,
    .close = close,
    .forget = forget,
    .step = step,
};
