/* Cells that are scenes: whole simulations, repeated. */
#include "harness/cell/cell_measure.h"
#include "harness/cell/stats.h"
#include "harness/measure/predictions.h"
#include "harness/measure/solve_once.h"
#include "lcp/base/clock.h"
#include "lcp/base/fields.h"

#include <stdlib.h>
#include <string.h>

/* ---- columns ----------------------------------------------------------------------------------*/

static void fill_sizes(const sim_result *q, record *r) {
  r->n_bodies = q->n_body;
  r->n_dof = q->n_dof;
  r->n_contacts = q->n_contact_max;
  r->n_active = q->n_active_max;
  r->lcp_dim = q->lcp_dim_max;
  if (q->n_island > 0) {
    r->n_island = q->n_island;
    r->largest_island = q->largest_island;
  }
  r->n_steps = q->steps;
  r->n_solves = q->n_solves;
  r->n_unsolved = q->n_unsolved;
  r->n_evaluations = q->n_evaluations;
  r->n_modes = q->n_modes;
  r->n_fallback = q->n_fallbacks + q->work.fallbacks;
  r->uniqueness = q->deficit_max;
  r->n_shared = q->n_shared;
  r->n_share_missed = q->n_share_missed;
  if (q->n_solves > 0) {
    r->nnz = q->nnz_max;
    r->density = (double)q->nnz_max / ((double)q->lcp_dim_max * q->lcp_dim_max);
    SET_TEXT(r->storage, storage_name(q->storage));
    r->workspace_B = (double)q->workspace;
  }
}

static void fill_verdict(const sim_result *q, record *r) {
  SET_TEXT(r->status, run_status_name(q->status));
  SET_TEXT(r->status_claimed, run_status_name(q->claimed));
  SET_TEXT(r->note, q->note);
  r->verified = (q->verified && q->status == RUN_OK) ? 1 : 0;
  if (q->n_solves > 0) {
    r->rho = q->rho_max;
    r->res_natural = q->natural_max;
    r->res_natural_rel = q->natural_rel_max;
    r->res_feas_z = q->feas_z_max;
    r->res_feas_w = q->feas_w_max;
    r->res_comp = q->comp_max;
  }
  if (q->n_judged > 0) {
    r->res_ncp = q->ncp_max;
    r->res_ncp_rel = q->ncp_rel_max;
    r->res_cone = q->cone_rel_max;
    r->dissipation_gap_J = q->dissipation_max;
  }
  r->penetration_m = q->penetration_max;
  r->approach_m = q->approach_max;
  r->energy_defect_J = q->energy_defect;
  r->energy_drift_rel = q->energy_drift_rel;
  if (q->stiffness_ratio < HUGE_VAL) { /* something is regularised */
    r->stiffness_ratio = q->stiffness_ratio;
    r->v_slip = q->v_slip;
    r->deflection_m = q->deflection;
  }
  (void)snprintf(r->solution_hash, sizeof r->solution_hash, "%016llx", (unsigned long long)q->hash);
  SET_TEXT(r->solver_variant, q->variant != NULL ? q->variant : "");
  effects_print(q->effects_seen, r->effects_seen, sizeof r->effects_seen);
}

static void fill_predictions(const prediction_summary *p, const scene_spec *spec, record *r) {
  r->n_predictions = p->n;
  r->n_predictions_missed = p->n_missed;
  SET_TEXT(r->missed, p->missed);
  if (p->n > 0) {
    r->err_worst = p->worst;
  }
  if (p->has_ref) {
    r->err_ref = p->error;
    r->err_predicted = p->predicted;
    r->err_tol = p->tolerance;
    SET_TEXT(r->err_quantity, p->quantity);
    (void)snprintf(r->err_source, sizeof r->err_source, "%.159s", p->source);
  }
  if (p->has_end) {
    SET_TEXT(r->end_quantity, spec->observe[0]);
    r->end_value = p->end;
  }
}

/* The deadline's view of one run (results/METHOD.md, rule 16): quantiles of its steps, and the share of steps
 * within a budget. */
static void fill_steps(const series *s, record *r) {
  const int n = s->n_row - 1;
  double *x = s->column[SERIES_STEP] + 1; /* row 0 is the start; nobody reads the column later */
  if (n < 1) {
    return;
  }
  stats_sort(x, n);
  r->t_step_p50_s = stats_quantile(x, n, 0.50);
  r->t_step_p95_s = stats_quantile(x, n, 0.95);
  r->t_step_p99_s = stats_quantile(x, n, 0.99);
  const double budget[] = {1e-3, 4e-3, 16e-3};
  double *const share[] = {&r->share_1ms, &r->share_4ms, &r->share_16ms};
  for (int b = 0; b < BASE_COUNT(budget); b++) {
    int within = 0;
    while (within < n && x[within] <= budget[b]) {
      within++;
    }
    *share[b] = (double)within / n;
  }
}

/* ---- sampling ---------------------------------------------------------------------------------*/

typedef struct sums {
  sim_times time;
  double cpu, longest; /* [s] */
} sums;

static void add_times(sums *s, const sim_result *q, bool first) {
  sim_times_add(&s->time, &q->time);
  s->longest = first ? q->step_longest : fmin(s->longest, q->step_longest);
}

static void fill_times(const sums *s, int n_inner, long steps, record *r) {
  const double n = n_inner;
  const sim_times *t = &s->time;
  r->t_contacts_s = t->contacts / n;
  r->t_assemble_s = t->assemble / n;
  r->t_setup_s = t->setup / n;
  r->t_factor_s = t->factor / n;
  r->t_solve_s = t->solve / n;
  r->t_share_s = t->share / n;
  r->t_advance_s = t->advance / n;
  r->t_watch_s = t->watch / n;
  r->t_total_s = sim_times_sum(t) / n;
  r->t_step_s = (steps > 0) ? r->t_total_s / (double)steps : (double)NAN;
  r->t_step_max_s = s->longest;
  r->t_cpu_s = s->cpu / n;
}

/* One row from n_inner whole simulations: times are means, everything else is the same each time.
 * The series of the last one serves the predictions and the quantiles of the steps. */
static base_status sample_scene(measured *m, record *r, double *seconds, base_error *err) {
  const sim_request *request = &m->sim.request;
  sums sum = {.cpu = 0.0};
  sim_result q = {0};
  for (int i = 0; i < m->n_inner; i++) {
    series kept;
    cell_cool(m);
    const double from = base_cpu_seconds();
    const base_status done = simulation_run(&m->sim, &kept, &q, err);
    sum.cpu += base_cpu_seconds() - from;
    if (done == BASE_OK && i + 1 == m->n_inner) {
      prediction_summary p;
      predictions_summarise(request, &kept, &q, &p);
      fill_predictions(&p, request->spec, r);
      fill_steps(&kept, r);
    }
    series_close(&kept);
    BASE_TRY(done);
    add_times(&sum, &q, i == 0);
  }
  fill_times(&sum, m->n_inner, q.steps, r);
  effects_print(request->effects, r->effects, sizeof r->effects);
  if (m->sim.watch > 0.0) {
    _Static_assert(sizeof r->effects_auto >= EFFECTS_TEXT, "a row has room for what auto did");
    watch_print(&m->sim.watched, m->sim.spec.effects, r->effects_auto);
  }
  m->status = q.status;
  *seconds = r->t_total_s;
  fill_sizes(&q, r);
  fill_verdict(&q, r);
  cell_fill_work(&q.work, m->sim.solver.solver, q.n_solves, r);
  return BASE_OK;
}

/* With what the present evaluation leaves behind or is fed from. */
static base_status sample_with_files(measured *m, record *r, double *seconds, base_error *err) {
  sim_request *q = &m->sim.request;
  q->store = m->store;
  q->replay = m->replay;
  q->trace = m->trace;
  return sample_scene(m, r, seconds, err);
}

/* ---- preparing --------------------------------------------------------------------------------*/

base_status cell_scene_prepare(measured *m, record *r, base_error *err) {
  const cell *c = m->job->cell;
  const simulation_texts t = {.scene = c->problem,
                              .formulation = c->formulation,
                              .solver = c->solver,
                              .tol = c->tol,
                              .step = c->step,
                              .duration = c->duration,
                              .effects = c->effects,
                              .start = c->start,
                              .contact_order = c->contact_order,
                              .islands = c->islands};
  simulation *s = &m->sim;
  m->is_scene = true;
  m->sample = sample_with_files;
  BASE_TRY(simulation_open(&t, s, err));
  (void)solver_choice_limit(&s->solver, plan_solver_limit(&m->job->campaign->limits));
  r->tol = verdict_asked(s->solver.solver, s->solver.opt);
  r->step_s = s->request.h;
  r->duration_s = s->request.duration;
  (void)snprintf(r->solver_config, sizeof r->solver_config, "%.479s", s->solver.config);
  (void)snprintf(r->formulation_config, sizeof r->formulation_config, "%.479s", s->form.config);
  formulation_model_print(s->form.form->model, r->model, sizeof r->model);
  return BASE_OK;
}
