/* One unit of the plan: its process run, its rows appended, its cell ended where it failed. */
#include "harness/campaign/runner_state.h"

#include <unistd.h>

static void show_progress(runner *r, const cell *c, double wall) {
  const record *last = &r->unit_rows.row[r->unit_rows.n - 1];
  char what[160];
  (void)snprintf(what, sizeof what, "%.70s/%.40s/%.40s", c->problem,
                 c->formulation[0] != '\0' ? c->formulation : "-", c->solver);
  progress_step(&r->progress, what, last->status, last->t_total_s >= 0 ? last->t_total_s : wall);
}

base_status runner_unit(runner *r, int u, base_error *err) {
  const unit *un = &r->plan->unit[u];
  const cell *c = &r->plan->cell[un->cell];
  char solution[1100];
  isolate_end end;
  bool whole;
  if (r->o->trace) {
    BASE_TRY(runner_twin(r, un->cell, err));
  }
  runner_solution_path(r, c->id, solution, sizeof solution);
  const bool store =
      r->o->solutions && access(solution, F_OK) != 0; /* one process of a cell does */
  r->job = (cell_job){.campaign = r->plan->campaign,
                      .cell = c,
                      .process = un->process,
                      .mem_node = -1,
                      .canary = r->canary,
                      .solution = store ? solution : NULL};
  BASE_TRY(runner_measure(r, u, &end, &whole, err));
  if (!whole) {
    return BASE_OK;
  }
  if (r->o->trace) {
    runner_twin_check(r, un->cell);
  }
  BASE_TRY(runner_append_rows(r, err));
  r->done[u] = true;
  r->ended[un->cell] =
      r->ended[un->cell] || runner_ends_cell(&r->unit_rows.row[r->unit_rows.n - 1]);
  r->sum->measured++;
  r->sum->inside += end.wall;
  show_progress(r, c, end.wall);
  return BASE_OK;
}
