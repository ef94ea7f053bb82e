/* Cells that are complementarity problems: one solve, looped until it fills a bracket. */
#include "harness/cell/cell_measure.h"
#include "harness/measure/solve_once.h"
#include "lcp/base/clock.h"

#include <stdlib.h>
#include <string.h>

static void fill_solve(const solve_record *q, const lcp_solver *s, record *r) {
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
  cell_fill_work(&q->claim.work, s, 1, r);
  SET_TEXT(r->solver_variant, q->claim.variant != NULL ? q->claim.variant : "");
  (void)snprintf(r->solution_hash, sizeof r->solution_hash, "%016llx", (unsigned long long)q->hash);
}

/* Zeros: every solve starts from its own copy, restored outside the bracket. */
static base_status start_points(measured *m, base_error *err) {
  const size_t n = (size_t)m->source.p->M.n * (size_t)m->n_inner + 1;
  if (n > m->z_cap) {
    free(m->z);
    m->z = malloc(n * sizeof *m->z);
    m->z_cap = (m->z != NULL) ? n : 0;
    if (m->z == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d start points", m->n_inner);
    }
  }
  memset(m->z, 0, n * sizeof *m->z);
  return BASE_OK;
}

/* Set-up and factorisation, repeated until they too have filled a bracket, at most n_inner times. */
static base_status time_prepare(const measured *m, lcp_instance *k, record *r, base_error *err) {
  const double inner = m->job->campaign->sampling.inner;
  lcp_times sum = {0};
  int prepared = 0;
  while (prepared < m->n_inner && (prepared == 0 || sum.setup + sum.factor < inner)) {
    BASE_TRY(lcp_instance_prepare(k, m->source.p, err));
    const lcp_times t = lcp_instance_times(k);
    sum.setup += t.setup;
    sum.factor += t.factor;
    prepared++;
  }
  r->t_setup_s = sum.setup / prepared;
  r->t_factor_s = sum.factor / prepared;
  return BASE_OK;
}

/* n_inner solves inside one bracket; the last answer's claim. */
static base_status time_solves(const measured *m, lcp_instance *k, record *r, lcp_result *claim,
                               base_error *err) {
  const size_t n = (size_t)m->source.p->M.n;
  lcp_trace *trace = (m->trace != NULL) ? trace_begin(m->trace) : NULL;
  const double cpu = base_cpu_seconds();
  const double from = base_seconds();
  for (int i = 0; i < m->n_inner; i++) {
    BASE_TRY(lcp_instance_solve(k, trace, m->z + (size_t)i * n, claim, err));
  }
  r->t_solve_s = (base_seconds() - from) / m->n_inner;
  r->t_cpu_s = (base_cpu_seconds() - cpu) / m->n_inner;
  r->t_total_s = r->t_setup_s + r->t_factor_s + r->t_solve_s;
  return (m->trace != NULL) ? trace_end(m->trace, err) : BASE_OK;
}

static base_status measure(measured *m, lcp_instance *k, record *r, solve_record *out,
                           base_error *err) {
  const lcp_problem *p = m->source.p;
  base_error why = {0};
  cell_cool(m);
  const base_status ready = time_prepare(m, k, r, &why);
  if (ready == BASE_EUNSUPPORTED) {
    solve_unsupported(&why, out);
    return BASE_OK;
  }
  if (ready != BASE_OK) {
    *err = why;
    return ready;
  }
  BASE_TRY(time_solves(m, k, r, &out->claim, err));
  const double *z = m->z + (size_t)p->M.n * (size_t)(m->n_inner - 1);
  BASE_TRY(solve_judge(p, &m->solver, k, z, out, err)); /* the timed answer, outside the bracket */
  return (m->store != NULL) ? answers_put(m->store, p->M.n, z, &out->claim, err) : BASE_OK;
}

static base_status solve_measured(measured *m, record *r, solve_record *out, base_error *err) {
  const lcp_problem *p = m->source.p;
  base_error why = {0};
  if (lcp_solver_admits(m->solver.solver, p, &why) != BASE_OK) {
    solve_unsupported(&why, out);
    return BASE_OK;
  }
  lcp_instance *k;
  const lcp_capacity cap = lcp_problem_capacity(p);
  BASE_TRY(lcp_instance_open(&k, m->solver.solver, &cap, m->solver.opt, err));
  const base_status done = measure(m, k, r, out, err);
  lcp_instance_close(k);
  return done;
}

static base_status replay(measured *m, solve_record *out, base_error *err) {
  const lcp_problem *p = m->source.p;
  BASE_TRY(answers_take(m->replay, p->M.n, m->z, &out->claim, err));
  return solve_judge(p, &m->solver, NULL, m->z, out, err);
}

static base_status sample_lcp(measured *m, record *r, double *seconds, base_error *err) {
  const lcp_problem *p = m->source.p;
  const double n = p->M.n;
  solve_record once = {.status = RUN_ERROR, .verdict.rho = HUGE_VAL};
  BASE_TRY(start_points(m, err));
  BASE_TRY(m->replay != NULL ? replay(m, &once, err) : solve_measured(m, r, &once, err));
  fill_solve(&once, m->solver.solver, r);
  if (once.has_claim && problem_source_has_cone(&m->source)) {
    lcp_verdict v;
    const double *z = m->z + (size_t)p->M.n * (size_t)(m->replay != NULL ? 0 : m->n_inner - 1);
    BASE_TRY(problem_source_judge_cone(&m->source, z, &v, err));
    r->res_ncp = v.natural;
    r->res_ncp_rel = v.natural_rel;
  }
  r->lcp_dim = p->M.n;
  r->nnz = lcp_matrix_entries(&p->M);
  r->density = (n > 0) ? (double)r->nnz / (n * n) : (double)NAN;
  SET_TEXT(r->storage, storage_name(p->M.storage));
  m->status = once.status;
  *seconds = once.has_claim ? r->t_solve_s : 0.0; /* what the inner loop repeats */
  return BASE_OK;
}

base_status cell_lcp_prepare(measured *m, record *r, base_error *err) {
  m->sample = sample_lcp;
  BASE_TRY(cell_choose_solver(m, r, err));
  return problem_source_open(m->job->cell->problem, NULL, 0, &m->source, err);
}
