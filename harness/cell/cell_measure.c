#include "harness/cell/cell_measure.h"

#include "harness/measure/machine.h"

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

void cell_cool(const measured *m) {
  if (m->sweep != NULL) {
    machine_sweep(m->sweep, m->n_sweep);
  }
}
