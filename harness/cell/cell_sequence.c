/* Cells that are sequences of complementarity problems: whole passes, looped until they fill a bracket. */
#include "harness/cell/cell_measure.h"
#include "harness/measure/solve_once.h"
#include "harness/sequence/sequence_source.h"
#include "lcp/base/clock.h"

static void fill_sizes(const sequence *q, record *r) {
  r->n_steps = q->steps;
  r->step_s = q->h;
  r->lcp_dim = sequence_largest(q);
  r->nnz = r->n_active = 0;
  for (int i = 0; i < q->n; i++) {
    const sequence_item *k = &q->item[i];
    const long nnz = lcp_matrix_entries(&k->p.M);
    r->nnz = (nnz > r->nnz) ? nnz : r->nnz;
    r->n_active = (k->n_owner > r->n_active) ? k->n_owner : r->n_active;
  }
  r->density = (double)r->nnz / ((double)r->lcp_dim * (double)r->lcp_dim);
  r->active_change = sequence_change(q);
}

static void fill_result(const sequence_result *s, const lcp_solver *solver, record *r) {
  SET_TEXT(r->status, run_status_name(s->status));
  SET_TEXT(r->status_claimed, s->n > 0 ? run_status_name(s->claimed) : "");
  SET_TEXT(r->note, s->note);
  r->verified = (s->verified && s->status == RUN_OK) ? 1 : 0;
  if (s->status == RUN_UNSUPPORTED) {
    return;
  }
  r->rho = s->worst.rho;
  r->res_natural = s->worst.natural;
  r->res_natural_rel = s->worst.natural_rel;
  r->res_feas_z = s->worst.infeasible_z;
  r->res_feas_w = s->worst.infeasible_w;
  r->res_comp = s->worst.comp;
  r->n_solves = s->n;
  r->n_unsolved = s->n_unsolved;
  r->n_fallback = s->work.fallbacks;
  r->workspace_B = (double)s->bytes;
  cell_fill_work(&s->work, solver, s->n, r);
  SET_TEXT(r->storage, storage_name(s->storage));
  SET_TEXT(r->solver_variant, s->variant);
  (void)snprintf(r->solution_hash, sizeof r->solution_hash, "%016llx", (unsigned long long)s->hash);
}

/* n_inner passes; times are means, everything else is the same each time. */
static base_status run_passes(measured *m, record *r, sequence_result *s, base_error *err) {
  sequence_request q = m->passes;
  lcp_times sum = {0};
  const double cpu = base_cpu_seconds();
  q.store = m->store;
  q.replay = m->replay;
  q.trace = m->trace;
  for (int i = 0; i < m->n_inner; i++) {
    cell_cool(m);
    BASE_TRY(sequence_solve(&q, s, NULL, err));
    sum.setup += s->time.setup;
    sum.factor += s->time.factor;
    sum.solve += s->time.solve;
  }
  r->t_setup_s = sum.setup / m->n_inner;
  r->t_factor_s = sum.factor / m->n_inner;
  r->t_solve_s = sum.solve / m->n_inner;
  r->t_total_s = r->t_setup_s + r->t_factor_s + r->t_solve_s;
  r->t_cpu_s = (base_cpu_seconds() - cpu) / m->n_inner;
  return BASE_OK;
}

static base_status sample_sequence(measured *m, record *r, double *seconds, base_error *err) {
  sequence_result s;
  BASE_TRY(run_passes(m, r, &s, err));
  m->status = s.status;
  fill_sizes(&m->sequence, r);
  fill_result(&s, m->solver.solver, r);
  *seconds = r->t_total_s;
  return BASE_OK;
}

/* Once a process, outside of every sample and for at most half of its time. */
static base_status count_regressions(const measured *m, record *r, base_error *err) {
  sequence_regressions dearer;
  const bool timed = m->replay == NULL && m->job->trace == NULL;
  if (!timed || m->passes.start == SEQUENCE_COLD) {
    return BASE_OK;
  }
  BASE_TRY(sequence_compare(&m->passes, 0.5 * m->job->campaign->limits.time, &dearer, err));
  r->regressions = (dearer.work != SEQUENCE_UNCOUNTED) ? dearer.work : INT64_MIN;
  r->regressions_time = (dearer.time != SEQUENCE_UNCOUNTED) ? dearer.time : INT64_MIN;
  return BASE_OK;
}

base_status cell_sequence_prepare(measured *m, record *r, base_error *err) {
  m->sample = sample_sequence;
  BASE_TRY(cell_choose_solver(m, r, err));
  BASE_TRY(sequence_start_find(m->job->cell->start, &m->passes.start, err));
  BASE_TRY(sequence_open(m->job->cell->problem, &m->sequence, err));
  m->passes.sequence = &m->sequence;
  m->passes.solver = &m->solver;
  return count_regressions(m, r, err);
}
