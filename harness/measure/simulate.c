#include "harness/measure/sim_watch.h"
#include "harness/measure/simulate_state.h"
#include "harness/measure/solve_once.h"
#include "harness/measure/trajectory.h"
#include "lcp/base/clock.h"

#include <stdlib.h>
#include <string.h>

double sim_times_sum(const sim_times *t) {
  return t->contacts + t->assemble + t->setup + t->factor + t->solve + t->share + t->advance +
         t->watch;
}

void sim_times_add(sim_times *sum, const sim_times *t) {
  sum->contacts += t->contacts;
  sum->assemble += t->assemble;
  sum->setup += t->setup;
  sum->factor += t->factor;
  sum->solve += t->solve;
  sum->share += t->share;
  sum->advance += t->advance;
  sum->watch += t->watch;
}

double sim_total_seconds(const sim_result *r) {
  return sim_times_sum(&r->time);
}

/* ---- one step ---------------------------------------------------------------------------------*/

/* Ends a phase and begins the next with one reading of the clock. */
static void lap(double *phase, double *from) {
  const double now = base_seconds();
  *phase += now - *from;
  *from = now;
}

/* A direct method that starts from a basis has one in its own last answer, not in what was chosen among its like. */
static base_status start_from_own(sim *s, base_error *err) {
  formulation_rows rows;
  if (sim_keeps_own(s)) {
    BASE_TRY(formulation_rows_of(s->form, &rows, err));
    own_answers_start(&s->own, &rows, s->z);
  }
  return BASE_OK;
}

/* assemble -> solve -> recover until the formulation has enough; *from: when assembly began, on return
 * when the part of it began that is still to be counted. */
static base_status solve_step(sim *s, double *from, base_error *err) {
  for (;;) {
    lcp_problem p;
    const double *z0 = NULL;
    bool pending = false;
    lcp_outcome claimed;
    BASE_TRY(formulation_assemble(s->form, &p, &z0, &pending, err));
    if (!pending) {
      return BASE_OK;
    }
    lap(&s->out->time.assemble, from);
    BASE_TRY(sim_start_point(s, &p, z0, err));
    BASE_TRY(start_from_own(s, err));
    BASE_TRY(sim_solve(s, &p, &claimed, err));
    *from = base_seconds();
    BASE_TRY(formulation_recover(s->form, s->z, claimed, err));
  }
}

static void note_answer(sim *s, const contact_set *set, const formulation_answer *a) {
  sim_result *r = s->out;
  r->n_modes += a->work.mode_changes;
  r->n_fallbacks += a->work.fallbacks;
  r->n_evaluations += a->work.evaluations;
  r->stiffness_ratio = fmin(r->stiffness_ratio, a->stiffness_ratio);
  r->v_slip = fmax(r->v_slip, a->v_slip);
  r->deflection = fmax(r->deflection, a->deflection);
  r->own_residual_max = fmax(r->own_residual_max, a->residual);
  s->active = a->n_active;
  r->n_active_max = (a->n_active > r->n_active_max) ? a->n_active : r->n_active_max;
  r->lcp_dim_max = (a->lcp_dim > r->lcp_dim_max) ? a->lcp_dim : r->lcp_dim_max;
  if (set != NULL && set->n_contact > r->n_contact_max) {
    r->n_contact_max = set->n_contact;
  }
  if (!a->solved) {
    char text[96];
    if (a->circle > 0) {
      (void)snprintf(text, sizeof text,
                     "the formulation's own loop goes in circles of %d solves, at residual %.3g",
                     a->circle, a->residual);
    } else {
      (void)snprintf(text, sizeof text, "the formulation's own loop ended at residual %.3g",
                     a->residual);
    }
    sim_trouble(s, RUN_STALLED, text);
  }
}

/* A step that was solved is none where its joint rows move by more of the largest speed than rounding explains, with what
 * that grows by where masses differ, or than the tolerance that was asked for. */
static void refuse_parted(sim *s, double joint_rel) {
  const double asked = verdict_asked(s->q->solver->solver, s->q->solver->opt);
  if (s->out->status == RUN_OK && joint_rel > fmax(1e-6, 10.0 * asked)) {
    char text[96];
    (void)snprintf(text, sizeof text,
                   "the joints are not kept: a row moves by %.2g of the largest speed", joint_rel);
    sim_trouble(s, RUN_NUMERICAL, text);
  }
}

static base_status merit_of(sim *s, const contact_set *set, const formulation_answer *a,
                            base_error *err) {
  contact_merit m;
  BASE_TRY(contact_merit_at(set, a->impulse, a->v_next, a->bias, &m, err));
  sim_result *r = s->out;
  r->n_judged++;
  r->ncp_max = fmax(r->ncp_max, m.ncp);
  r->ncp_rel_max = fmax(r->ncp_rel_max, m.ncp_rel);
  r->cone_rel_max = fmax(r->cone_rel_max, m.cone_rel);
  r->dissipation_max = fmax(r->dissipation_max, m.dissipation);
  refuse_parted(s, m.joint_rel);
  return BASE_OK;
}

/* What the effects that are left out would have done in the step, and what it makes of the deviation before it. carried: the
 * contacts' hash of the step before. */
static void note_omitted(sim *s, const formulation_answer *a, uint64_t carried) {
  world_omitted(s->w, s->watched | s->effects, s->off != NULL || s->would_deviate, s->least,
                a->v_next, a->impulse, s->omitted, s->grown);
  if (s->would_deviate) {
    world_acted(s->w, a->impulse, s->grown);
  }
  const bool same =
      s->off == NULL || (s->carrying.ids == carried &&
                         !world_may_meet(s->w, a->v_next, a->impulse, s->off, s->grown));
  s->alike = same || world_contacts_alike(s->w, a->v_next, a->impulse, s->off, s->grown);
}

/* Steps that a formulation with complementarity problems takes. */
static base_status step_lcp(sim *s, series *record, base_error *err) {
  contact_set set;
  const contact_set *posed;
  formulation_answer a = {0};
  sim_times *t = &s->out->time;
  double from = base_seconds();
  s->slept = false;
  const bool curved = (s->q->form->form->model & FORM_CURVED) != 0;
  base_status (*const find)(world *, double, double, contact_set *, base_error *) =
      curved      ? world_contacts_curved
      : s->turned ? world_contacts_turned
                  : world_contacts;
  BASE_TRY(find(s->w, s->h, -1.0, &set, err));
  while (s->sleeps && world_is_reached(s->w)) {
    BASE_TRY(sim_wake(s, false, err));
    BASE_TRY(find(s->w, s->h, -1.0, &set, err));
  }
  lap(&t->contacts, &from);
  BASE_TRY(contact_order_apply(&s->order, &set, &posed, err));
  from = (posed != &set) ? base_seconds() : from; /* another order is no part of the step */
  BASE_TRY(formulation_begin(s->form, posed, s->q->start, err));
  own_answers_step(&s->own);
  BASE_TRY(solve_step(s, &from, err));
  formulation_answer_of(s->form, &a);
  lap(&t->assemble, &from);
  contact_order_restore(&s->order, &set, &a);
  sim_settle_held(s);
  const uint64_t carried = s->goes_on.ids; /* in the step before */
  BASE_TRY(sim_note_contacts(s, &set, &a, err));
  series_penetration(record, &set);
  s->out->approach_max = fmax(s->out->approach_max, contact_approach(&set));
  note_answer(s, &set, &a);
  BASE_TRY(merit_of(s, &set, &a, err));
  s->out->effects_seen |= sim_effects_seen(s->q->spec, &set, &a);
  s->out->hash = sim_hash(s->out->hash, a.v_next, set.n_dof);

  from = base_seconds();
  if (s->watched != 0 || s->would_deviate) {
    note_omitted(s, &a, carried);
    lap(&t->watch, &from);
  }
  BASE_TRY(world_advance(s->w, a.v_next, a.impulse, err));
  if (a.shift != NULL) {
    world_shift(s->w, a.shift);
  }
  t->advance += base_seconds() - from;
  BASE_TRY(trajectory_contacts(s->q->trajectory, s->w, &set, a.mode, err));
  BASE_TRY(series_record(record, s->w, &set, a.impulse, &s->asleep.resting,
                         a.spring_energy + s->asleep.energy, err));
  from = base_seconds();
  BASE_TRY(sim_fall_asleep(s, &set, &a, err));
  lap(&t->advance, &from);
  return BASE_OK;
}

static bool cut_by_time(void *ctx) {
  sim *s = ctx;
  s->cut = sim_due(s);
  return s->cut;
}

/* Steps of penalty and event-driven formulations, which advance the world themselves. */
static base_status step_own(sim *s, series *record, base_error *err) {
  formulation_answer a = {0};
  const formulation_solver solver = {
      .solve = sim_solve_for_formulation, .ctx = s, .due = cut_by_time};
  if (s->order.seed != 0) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED,
                     "%s finds its contacts itself: in no order but the given",
                     s->q->form->form->name);
  }
  const double from = base_seconds();
  s->called = 0;
  s->cut = false;
  const base_status done = formulation_step(s->form, s->w, s->h, &solver, &a, err);
  s->out->time.assemble += base_seconds() - from - s->called;
  BASE_TRY(done);
  sim_settle_held(s);
  note_answer(s, a.set, &a);
  if (a.set != NULL) {
    s->out->effects_seen |= sim_effects_seen(s->q->spec, a.set, &a);
  }
  if (a.v_next != NULL) {
    s->out->hash = sim_hash(s->out->hash, a.v_next, world_n_dof(s->w));
  }
  BASE_TRY(series_record(record, s->w, a.set, a.impulse, NULL, a.spring_energy, err));
  if (a.set != NULL) {
    series_penetration(record, a.set);
    world_note_impulses(s->w, a.impulse); /* a.set is the world's last one */
    BASE_TRY(trajectory_contacts(s->q->trajectory, s->w, a.set, a.mode, err));
  }
  return BASE_OK;
}

/* After these nothing further is physics. */
bool sim_hopeless(const sim *s) {
  return sim_without_solution(s->out->status) || s->out->status == RUN_UNSUPPORTED;
}

/* Squares of what is larger may overflow before it does. */
static const double run_away = 1e100;

base_status sim_step(sim *s, series *record, double h, bool *taken, base_error *err) {
  sim_result *r = s->out;
  const double from = sim_total_seconds(r);
  base_error why = {0};
  s->h = h;
  const base_status done = s->iterates ? step_lcp(s, record, &why) : step_own(s, record, &why);
  *taken = done == BASE_OK;
  if (done == BASE_EEXTERNAL && s->cut) {
    return BASE_OK;
  }
  if (done == BASE_EUNSUPPORTED || done == BASE_EEXTERNAL) { /* EEXTERNAL: an integrator */
    sim_refuse(s, (done == BASE_EUNSUPPORTED) ? RUN_UNSUPPORTED : RUN_NUMERICAL, why.text);
    return BASE_OK;
  }
  if (done != BASE_OK) {
    *err = why;
    return done;
  }
  r->steps++;
  const double spent = sim_total_seconds(r) - from;
  r->step_longest = fmax(r->step_longest, spent);
  record->column[SERIES_STEP][record->n_row - 1] = spent;
  if (!world_below(s->w, run_away)) {
    r->finite = world_finite(s->w);
    sim_trouble(s, RUN_NUMERICAL, r->finite ? "the state has run away" : "the state is not finite");
  }
  return s->part ? BASE_OK : trajectory_row(s->q->trajectory, s->w, err);
}

static base_status run_steps(sim *s, series *record, base_error *err) {
  const sim_request *q = s->q;
  const sim_result *r = s->out;
  bool due = false;
  for (bool taken = true; taken && !due && r->steps < r->steps_planned && !sim_hopeless(s);) {
    BASE_TRY(sim_follow_plans(s, err));
    BASE_TRY(sim_step(s, record, q->step != NULL ? q->step[r->steps] : q->h, &taken, err));
    due = r->steps < r->steps_planned && sim_due(s);
  }
  if (due) {
    sim_trouble(s, RUN_TIME_LIMIT, "the run was stopped there");
  }
  return BASE_OK;
}

long sim_steps_planned(const sim_request *q) {
  return (q->step != NULL) ? q->n_step : lround(ceil(q->duration / q->h - SIM_LAST_STEP));
}

base_status sim_check_times(double h, double duration, base_error *err) {
  if (!(h > 0.0) || !(duration > 0.0) || !isfinite(h) || !isfinite(duration)) {
    return BASE_FAIL(err, BASE_EINVAL, "step %g s over %g s: need step and duration above 0", h,
                     duration);
  }
  if (h > duration * (1.0 + SIM_LAST_STEP)) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "step %g s: is longer than the run of %g s", h,
                     duration);
  }
  return (duration / h <= 2e9)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL, "step %g s over %g s: need at most 2e9 steps", h,
                         duration);
}

/* ---- the whole --------------------------------------------------------------------------------*/

static void summarise(sim *s, const series *record) {
  sim_result *r = s->out;
  const double *energy = record->column[SERIES_ENERGY];
  const int last = record->n_row - 1;
  for (int k = 1; k < record->n_row; k++) {
    r->energy_defect = fmax(r->energy_defect, energy[k] - energy[k - 1]);
  }
  for (int k = 0; k < record->n_row; k++) {
    r->penetration_max = fmax(r->penetration_max, record->column[SERIES_PENETRATION][k]);
  }
  r->energy_drift_rel = (energy[0] != 0.0) ? (energy[last] - energy[0]) / fabs(energy[0]) : 0.0;
}

/* What was not computed is no number: a formulation that steps by itself is not held against the exact cone, and one
 * that posed no problem has no residual of one. */
static void forget_unmeasured(sim *s) {
  sim_result *r = s->out;
  if ((s->q->form->form->model & FORM_NO_LCP) == 0 || r->n_judged > 0) {
    return;
  }
  r->approach_max = (double)NAN;
  r->ncp_max = r->ncp_rel_max = r->cone_rel_max = r->dissipation_max = (double)NAN;
  if (r->n_solves == 0) {
    r->rho_max = r->natural_max = r->natural_rel_max = (double)NAN;
    r->feas_z_max = r->feas_w_max = r->comp_max = (double)NAN;
  }
}

base_status sim_open(sim *s, const sim_request *q, series *record, sim_result *out,
                     base_error *err) {
  *record = (series){0};
  *out = (sim_result){.status = RUN_OK,
                      .claimed = RUN_OK,
                      .verified = true,
                      .finite = true,
                      .stiffness_ratio = HUGE_VAL,
                      .n_part = 1,
                      .part = {{.status = RUN_OK, .verified = true}},
                      .hash = SIM_HASH_START};
  *s = (sim){.q = q,
             .out = out,
             .order.seed = q->contact_order,
             .iterates = (q->form->form->model & FORM_NO_LCP) == 0};
  BASE_TRY(sim_check_times(q->h, q->duration, err));
  s->effects = (q->plan != NULL) ? effects_plan_at(q->plan, 0) : q->effects;
  BASE_TRY(world_open_over(&s->w, q->spec, s->effects, err));
  BASE_TRY(sim_open_formulation(s, err));
  out->steps_planned = sim_steps_planned(q);
  BASE_TRY(series_open(record, q->spec, (int)out->steps_planned, err));
  BASE_TRY(series_record(record, s->w, NULL, NULL, NULL, 0, err));
  BASE_TRY(trajectory_header(q->trajectory, q->spec, err));
  BASE_TRY(trajectory_row(q->trajectory, s->w, err));
  out->n_dof = world_n_dof(s->w);
  out->n_body = world_n_body(s->w);
  sim_ask_admission(s);
  s->sleeps = sim_may_sleep(s);
  return BASE_OK;
}

void sim_finish(sim *s, series *record) {
  forget_unmeasured(s);
  double *deepest = &record->column[SERIES_PENETRATION][record->n_row - 1];
  *deepest = fmax(*deepest, -world_min_gap(s->w));
  summarise(s, record);
  if (s->q->end != NULL) {
    world_restart(s->w, s->q->end);
  }
}

void sim_close(sim *s) {
  lcp_instance_close(s->instance);
  contact_memory_drop(&s->past);
  sim_asleep_close(&s->asleep);
  contact_memory_drop(&s->awake);
  lcp_islands_close(s->islands);
  lcp_share_close(s->share);
  lcp_share_parts_close(s->share_parts);
  formulation_close(s->form);
  contact_order_close(&s->order);
  own_answers_close(&s->own);
  world_close(s->w);
  free(s->z);
  free(s->u);
  free(s->loads.pair);
}

base_status simulate(const sim_request *q, series *record, sim_result *out, base_error *err) {
  sim s;
  base_status done = sim_open(&s, q, record, out, err);
  if (done == BASE_OK) {
    done = run_steps(&s, record, err);
  }
  if (done == BASE_OK) {
    sim_finish(&s, record);
  }
  sim_close(&s);
  return done;
}
