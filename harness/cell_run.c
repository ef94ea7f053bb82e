#include "harness/cell_run.h"

#include "harness/effects_auto.h"
#include "harness/predictions.h"
#include "harness/problem_source.h"
#include "harness/solve_once.h"
#include "harness/stats.h"
#include "lcp/base/clock.h"
#include "problems/scene.h"

#include <stdlib.h>
#include <string.h>

enum { CELL_SAMPLES = 1024 };

#define SET_TEXT(field, text) ((void)snprintf((field), sizeof(field), "%s", (text)))

static const char *after_colon(const char *text) {
  const char *colon = strchr(text, ':');
  return (colon != NULL) ? colon + 1 : "";
}

void cell_identity(const cell_job *job, record *r) {
  const cell *c = job->cell;
  record_clear(r);
  r->schema = RECORD_SCHEMA;
  r->metric_version = RECORD_METRIC;
  r->process = job->process;
  r->seed = (int64_t)job->campaign->seed;
  r->threads = 1;
  r->quick = job->campaign->quick ? 1 : 0;
  r->t_limit_s = job->campaign->limits.time;
  r->canary_s = job->canary;
  SET_TEXT(r->campaign, job->campaign->name);
  SET_TEXT(r->part, c->part);
  SET_TEXT(r->cell_id, c->id);
  SET_TEXT(r->problem, c->problem);
  SET_TEXT(r->problem_sha256, c->problem_sha256);
  SET_TEXT(r->solver_version, c->solver_version);
  const char *slash = strrchr(c->problem, '/');
  const char *name = (slash != NULL) ? slash + 1 : c->problem;
  (void)snprintf(r->problem_family, sizeof r->problem_family, "%.*s", (int)strcspn(name, ":."),
                 name);
  (void)snprintf(r->formulation, sizeof r->formulation, "%.*s", (int)strcspn(c->formulation, ":"),
                 c->formulation);
  (void)snprintf(r->solver, sizeof r->solver, "%.*s", (int)strcspn(c->solver, ":"), c->solver);
  SET_TEXT(r->formulation_options, after_colon(c->formulation));
  SET_TEXT(r->solver_options, after_colon(c->solver));
  cell_command(c, r->command, sizeof r->command);
}

/* ---- repetitions ------------------------------------------------------------------------------*/

/* What a cell is measured with; `sample` fills the row and gives the seconds of one evaluation. */
typedef struct measured {
  base_status (*sample)(struct measured *m, record *r, double *seconds, base_error *err);
  const cell_job *job;
  int n_inner;
  run_status status;
  sim_request request; /* scenes */
  scene_spec spec;
  formulation_choice form;
  solver_choice solver;
  problem_source source; /* complementarity problems */
  double *z;             /* n_inner copies of the start point */
} measured;

static void emit_error(const cell_job *job, record *r, const base_error *err,
                       isolate_channel *out) {
  r->rep = 0;
  SET_TEXT(r->status, run_status_name(err->code == BASE_ENOMEM         ? RUN_OOM
                                      : err->code == BASE_EUNSUPPORTED ? RUN_UNSUPPORTED
                                                                       : RUN_ERROR));
  (void)snprintf(r->note, sizeof r->note, "%.230s", err->text);
  (void)job;
  (void)isolate_emit(out, r);
}

/* Times stand only where the method came to an end worth timing. */
static bool timed_status(run_status s) {
  return s == RUN_OK || s == RUN_NEAR || s == RUN_STALLED || s == RUN_MAX_ITER ||
         s == RUN_TIME_LIMIT;
}

static void clear_times(record *r) {
  r->t_contacts_s = r->t_assemble_s = r->t_setup_s = r->t_factor_s = (double)NAN;
  r->t_solve_s = r->t_advance_s = r->t_total_s = r->t_step_s = (double)NAN;
  r->t_step_max_s = r->t_cpu_s = (double)NAN;
}

static void emit_sample(const measured *m, record *r, int rep, isolate_channel *out) {
  r->rep = rep;
  r->n_inner = m->n_inner;
  if (!timed_status(m->status)) {
    clear_times(r);
  }
  (void)isolate_emit(out, r);
}

static base_status repeat(measured *m, record *base, isolate_channel *out, base_error *err) {
  const campaign_sampling *s = &m->job->campaign->sampling;
  double seconds[CELL_SAMPLES];
  double sorted[CELL_SAMPLES];
  record warm = *base;
  m->n_inner = 1;
  double once;
  BASE_TRY(m->sample(m, &warm, &once, err)); /* first touch; calibrates the inner loop */
  if (once > 0.0 && once < s->inner) {
    m->n_inner = (int)fmin(ceil(s->inner / once), 1e6);
  }
  int least = (once > 10.0) ? 3 : s->samples;
  int most = (s->max_samples < CELL_SAMPLES) ? s->max_samples : CELL_SAMPLES;
  if (m->status != RUN_OK || once > s->budget) {
    least = most = 1;
  }
  if (most == 1 && m->n_inner == 1 && m->job->campaign->sampling.max_samples == 1) {
    emit_sample(m, &warm, 0, out); /* a campaign of verdicts: the first run is the row */
    return BASE_OK;
  }
  const double from = base_seconds();
  for (int k = 0; k < most; k++) {
    record r = *base;
    BASE_TRY(m->sample(m, &r, &seconds[k], err));
    emit_sample(m, &r, k, out);
    memcpy(sorted, seconds, (size_t)(k + 1) * sizeof *sorted);
    const bool known = k + 1 >= least && stats_half_width(sorted, k + 1) <= s->half_width;
    if (known || (k + 1 >= least && base_seconds() - from > s->budget)) {
      break;
    }
  }
  return BASE_OK;
}

/* ---- scenes -----------------------------------------------------------------------------------*/

static void fill_sizes(const sim_result *q, record *r) {
  r->n_bodies = q->n_body;
  r->n_dof = q->n_dof;
  r->n_contacts = q->n_contact_max;
  r->n_active = q->n_active_max;
  r->lcp_dim = q->lcp_dim_max;
  r->n_steps = q->steps;
  r->n_solves = q->n_solves;
  r->n_unsolved = q->n_unsolved;
  r->n_modes = q->n_modes;
  r->n_fallback = q->n_fallbacks + q->work.fallbacks;
  if (q->n_solves > 0) {
    r->nnz = q->nnz_max;
    r->density = (double)q->nnz_max / ((double)q->lcp_dim_max * q->lcp_dim_max);
    SET_TEXT(r->storage, storage_name(q->storage));
    r->workspace_B = (double)q->workspace;
  }
}

static void fill_work(const lcp_work *w, record *r) {
  r->n_iter = w->iterations;
  r->n_pivot = w->pivots;
  r->n_matvec = w->matvecs;
  r->n_factor = w->factorizations;
  r->n_linesearch = w->linesearches;
}

static void fill_verdict(const sim_result *q, record *r) {
  SET_TEXT(r->status, run_status_name(q->status));
  SET_TEXT(r->status_claimed, run_status_name(q->claimed));
  SET_TEXT(r->note, q->note);
  r->verified = (q->verified && q->status == RUN_OK) ? 1 : 0;
  r->rho = q->rho_max;
  r->res_natural = q->natural_max;
  r->res_natural_rel = q->natural_rel_max;
  r->res_feas_z = q->feas_z_max;
  r->res_feas_w = q->feas_w_max;
  r->res_comp = q->comp_max;
  r->res_ncp = q->ncp_max;
  r->res_ncp_rel = q->ncp_rel_max;
  r->res_cone = q->cone_rel_max;
  r->dissipation_gap_J = q->dissipation_max;
  r->penetration_m = q->penetration_max;
  r->energy_defect_J = q->energy_defect;
  r->energy_drift_rel = q->energy_drift_rel;
  (void)snprintf(r->solution_hash, sizeof r->solution_hash, "%016llx", (unsigned long long)q->hash);
  SET_TEXT(r->solver_variant, q->variant != NULL ? q->variant : "");
  effects_print(q->effects_seen, r->effects_seen, sizeof r->effects_seen);
  if (q->n_solves > 0 && q->work.iterations + q->work.pivots + q->work.sweeps == 0 &&
      q->status == RUN_OK) {
    SET_TEXT(r->flags, "zero_iterations");
  } else if (r->n_fallback > 0) {
    SET_TEXT(r->flags, "fallback");
  }
}

static void fill_predictions(const prediction_summary *p, record *r) {
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
}

/* One row from n_inner whole simulations: times are means, everything else is the same each time.
 * The series is needed once, for the predictions. */
static base_status sample_scene(measured *m, record *r, double *seconds, base_error *err) {
  sim_times sum = {0};
  double cpu = 0.0;
  double longest = 0.0;
  sim_result q = {0};
  for (int i = 0; i < m->n_inner; i++) {
    series record_;
    const double from = base_cpu_seconds();
    const base_status done = simulate(&m->request, &record_, &q, err);
    cpu += base_cpu_seconds() - from;
    if (done == BASE_OK && i + 1 == m->n_inner) {
      prediction_summary p;
      predictions_summarise(&m->request, &record_, &q, &p);
      fill_predictions(&p, r);
    }
    series_close(&record_);
    BASE_TRY(done);
    sum.contacts += q.time.contacts;
    sum.assemble += q.time.assemble;
    sum.setup += q.time.setup;
    sum.factor += q.time.factor;
    sum.solve += q.time.solve;
    sum.advance += q.time.advance;
    longest = (i == 0) ? q.step_longest : fmin(longest, q.step_longest);
  }
  const double n = m->n_inner;
  r->t_contacts_s = sum.contacts / n;
  r->t_assemble_s = sum.assemble / n;
  r->t_setup_s = sum.setup / n;
  r->t_factor_s = sum.factor / n;
  r->t_solve_s = sum.solve / n;
  r->t_advance_s = sum.advance / n;
  r->t_total_s =
      (sum.contacts + sum.assemble + sum.setup + sum.factor + sum.solve + sum.advance) / n;
  r->t_step_s = (q.steps > 0) ? r->t_total_s / (double)q.steps : (double)NAN;
  r->t_step_max_s = longest;
  r->t_cpu_s = cpu / n;
  m->status = q.status;
  *seconds = r->t_total_s;
  fill_sizes(&q, r);
  fill_work(&q.work, r);
  fill_verdict(&q, r);
  return BASE_OK;
}

static base_status number_or(const char *text, double dflt, const char *what, double *out,
                             base_error *err) {
  *out = dflt;
  if (text[0] != '\0' && (!base_parse_real(text, out) || !(*out > 0.0))) {
    return BASE_FAIL(err, BASE_EINVAL, "%s %s: need a number above 0", what, text);
  }
  return BASE_OK;
}

static void model_words(unsigned model, char *buf, size_t cap) {
  static const char *const words[] = {
      "unilateral",    "friction", "cone_exact", "cone_polyhedral", "regularised",
      "bounds_lagged", "penalty",  "position",   "acceleration",    "no_lcp"};
  size_t used = 0;
  buf[0] = '\0';
  for (int i = 0; i < BASE_COUNT(words); i++) {
    if ((model & 1u << i) != 0 && used < cap) {
      used += (size_t)snprintf(buf + used, cap - used, "%s%s", used > 0 ? " " : "", words[i]);
    }
  }
}

static base_status prepare_scene(measured *m, record *r, base_error *err) {
  const cell *c = m->job->cell;
  BASE_TRY(scene_load(c->problem, &m->spec, err));
  BASE_TRY(formulation_choose(c->formulation, &m->form, err));
  sim_request *q = &m->request;
  *q = (sim_request){.spec = &m->spec, .form = &m->form, .solver = &m->solver};
  BASE_TRY(number_or(c->step, m->spec.n_h > 0 ? m->spec.h[0] : 0.01, "step", &q->h, err));
  BASE_TRY(number_or(c->duration, m->spec.duration, "duration", &q->duration, err));
  if (strcmp(c->start, "cold") != 0 && strcmp(c->start, "previous") != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "start %s: need cold or previous", c->start);
  }
  q->start = (strcmp(c->start, "previous") == 0) ? FORM_PREVIOUS : FORM_COLD;
  effects_choice choice;
  BASE_TRY(effects_choose(q, c->effects, &choice, err));
  SET_TEXT(r->effects_auto, choice.text);
  r->step_s = q->h;
  r->duration_s = q->duration;
  SET_TEXT(r->start, c->start);
  effects_print(q->effects, r->effects, sizeof r->effects);
  (void)snprintf(r->formulation_config, sizeof r->formulation_config, "%.479s", m->form.config);
  model_words(m->form.form->model, r->model, sizeof r->model);
  m->sample = sample_scene;
  return BASE_OK;
}

/* ---- complementarity problems -----------------------------------------------------------------*/

/* n_inner solves inside one bracket, each from its own copy of the start point. Set-up and
 * factorisation are repeated until they too have filled a bracket, at most as often. */
static base_status time_loop(measured *m, lcp_instance *k, record *r, base_error *err) {
  const lcp_problem *p = m->source.p;
  const size_t n = (size_t)p->M.n;
  lcp_times sum = {0};
  const int loops = m->n_inner;
  int prepared = 0;
  const double inner = m->job->campaign->sampling.inner;
  while (prepared < loops && (prepared == 0 || sum.setup + sum.factor < inner)) {
    BASE_TRY(lcp_instance_prepare(k, p, err));
    const lcp_times t = lcp_instance_times(k);
    sum.setup += t.setup;
    sum.factor += t.factor;
    prepared++;
  }
  const double cpu = base_cpu_seconds();
  const double from = base_seconds();
  for (int i = 0; i < loops; i++) {
    lcp_result res;
    BASE_TRY(lcp_instance_solve(k, NULL, m->z + (size_t)i * n, &res, err));
  }
  r->t_solve_s = (base_seconds() - from) / loops;
  r->t_cpu_s = (base_cpu_seconds() - cpu) / loops;
  r->t_setup_s = sum.setup / prepared;
  r->t_factor_s = sum.factor / prepared;
  r->t_total_s = r->t_setup_s + r->t_factor_s + r->t_solve_s;
  return BASE_OK;
}

static void fill_solve(const solve_record *q, record *r) {
  const lcp_verdict *v = &q->verdict;
  SET_TEXT(r->status, run_status_name(q->status));
  SET_TEXT(r->status_claimed, q->has_claim ? lcp_outcome_name(q->claim.outcome) : "");
  SET_TEXT(r->note, q->note);
  r->verified = (q->verified && q->status == RUN_OK) ? 1 : 0;
  if (!q->has_claim) {
    return;
  }
  r->rho = v->rho;
  r->res_natural = v->natural;
  r->res_natural_rel = v->natural_rel;
  r->res_feas_z = v->infeasible_z;
  r->res_feas_w = v->infeasible_w;
  r->res_comp = v->comp;
  r->n_solves = 1;
  r->n_unsolved = (q->status == RUN_OK) ? 0 : 1;
  r->n_fallback = q->claim.work.fallbacks;
  r->workspace_B = (double)q->bytes;
  fill_work(&q->claim.work, r);
  SET_TEXT(r->solver_variant, q->claim.variant != NULL ? q->claim.variant : "");
  (void)snprintf(r->solution_hash, sizeof r->solution_hash, "%016llx", (unsigned long long)q->hash);
}

static base_status sample_lcp(measured *m, record *r, double *seconds, base_error *err) {
  const lcp_problem *p = m->source.p;
  const size_t n = (size_t)p->M.n;
  free(m->z);
  m->z = calloc(n * (size_t)m->n_inner + 1, sizeof *m->z);
  if (m->z == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d start points", m->n_inner);
  }
  solve_record once;
  BASE_TRY(solve_once(p, &m->solver, m->z, &once, err)); /* the verdict, untimed */
  if (m->job->solution != NULL && once.has_claim && m->n_inner == 1) {
    BASE_TRY(lcp_write_mtx_vector(m->job->solution, p->M.n, m->z, err));
  }
  memset(m->z, 0, n * sizeof *m->z);
  fill_solve(&once, r);
  r->lcp_dim = p->M.n;
  r->nnz = lcp_matrix_entries(&p->M);
  r->density = (n > 0) ? (double)r->nnz / ((double)n * (double)n) : (double)NAN;
  SET_TEXT(r->storage, storage_name(p->M.storage));
  m->status = once.status;
  *seconds = 0.0;
  if (!once.has_claim) {
    return BASE_OK;
  }
  lcp_instance *k;
  const lcp_capacity cap = lcp_problem_capacity(p);
  BASE_TRY(lcp_instance_open(&k, m->solver.solver, &cap, m->solver.opt, err));
  const base_status done = time_loop(m, k, r, err);
  lcp_instance_close(k);
  *seconds = r->t_solve_s; /* what the inner loop repeats */
  return done;
}

static base_status prepare_lcp(measured *m, base_error *err) {
  m->sample = sample_lcp;
  return problem_source_open(m->job->cell->problem, NULL, 0, &m->source, err);
}

/* ---- the cell ---------------------------------------------------------------------------------*/

static base_status prepare(measured *m, record *r, base_error *err) {
  const cell *c = m->job->cell;
  BASE_TRY(solver_choose(c->solver, &m->solver, err));
  if (c->tol[0] != '\0') {
    BASE_TRY(solver_choice_set(&m->solver, "tol", c->tol, err));
  }
  r->tol = verdict_asked(m->solver.solver, m->solver.opt);
  (void)snprintf(r->solver_config, sizeof r->solver_config, "%.479s", m->solver.config);
  return (c->formulation[0] != '\0') ? prepare_scene(m, r, err) : prepare_lcp(m, err);
}

void cell_run(const cell_job *job, isolate_channel *out) {
  record base;
  base_error err = {0};
  measured m = {.job = job, .status = RUN_OK};
  spec_init(&m.spec);
  cell_identity(job, &base);
  base_status done = prepare(&m, &base, &err);
  if (done == BASE_OK) {
    done = repeat(&m, &base, out, &err);
  }
  if (done != BASE_OK) {
    emit_error(job, &base, &err, out);
  }
  free(m.z);
  spec_free(&m.spec);
  problem_source_close(&m.source);
  formulation_choice_free(&m.form);
  solver_choice_free(&m.solver);
}
