#include "harness/cell/cell_measure.h"

#include "harness/cell/machine.h"

#include <string.h>

void cell_fill_work(const lcp_work *w, const lcp_solver *s, long n_solves, record *r) {
  r->n_iter = w->iterations;
  r->n_pivot = w->pivots;
  r->n_matvec = w->matvecs;
  r->n_factor = w->factorizations;
  r->n_linesearch = w->linesearches;
  if (n_solves > 0 && w->iterations + w->pivots + w->sweeps == 0 && strcmp(r->status, "ok") == 0) {
    record_flag(r, "zero_iterations");
  }
  if (r->n_fallback > 0) {
    record_flag(r, "fallback");
  }
  if (n_solves > 0 && s->allocates) {
    record_flag(r, "allocates");
  }
}

base_status cell_choose_solver(measured *m, record *r, base_error *err) {
  const cell *c = m->job->cell;
  BASE_TRY(solver_choose(c->solver, &m->solver, err));
  if (c->tol[0] != '\0') {
    BASE_TRY(solver_choice_set(&m->solver, "tol", c->tol, err));
  }
  (void)solver_choice_limit(&m->solver, plan_solver_limit(&m->job->campaign->limits));
  r->tol = verdict_asked(m->solver.solver, m->solver.opt);
  (void)snprintf(r->solver_config, sizeof r->solver_config, "%.479s", m->solver.config);
  return BASE_OK;
}

void cell_cool(const measured *m) {
  if (m->sweep != NULL) {
    machine_sweep(m->sweep, m->n_sweep);
  }
}
