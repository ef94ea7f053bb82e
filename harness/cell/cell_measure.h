/* harness/cell/cell_measure.h - what the kinds of cells (scenes, complementarity problems, sequences of them) share while
 * they are measured. Private to cell_*.c. */
#pragma once

#include "harness/cell/cell_run.h"
#include "harness/control/simulation.h"
#include "harness/measure/problem_source.h"
#include "harness/sequence/sequence_solve.h"

typedef struct measured {
  /* One evaluation, or n_inner of them: fills the row and gives the seconds of one. */
  base_status (*sample)(struct measured *m, record *r, double *seconds, base_error *err);
  const cell_job *job;
  int n_inner;
  run_status status; /* of the last evaluation */
  answers *store, *replay;
  trace_file *trace; /* these three only in an evaluation that is not timed */
  bool is_scene;
  simulation sim;        /* scenes */
  problem_source source; /* complementarity problems */
  solver_choice solver;
  sequence sequence; /* sequences, and how they are solved */
  sequence_request passes;
  double *z; /* n_inner copies of the start point */
  size_t z_cap;
  double *sweep; /* what is streamed to empty the caches; NULL: caches stay warm */
  size_t n_sweep;
} measured;

base_status cell_scene_prepare(measured *m, record *r, base_error *err);
base_status cell_lcp_prepare(measured *m, record *r, base_error *err);
base_status cell_sequence_prepare(measured *m, record *r, base_error *err);

/* The solver of a cell without a scene, with its tolerance and limit. */
base_status cell_choose_solver(measured *m, record *r, base_error *err);

/* Columns and flags that follow from the work of all solves together. */
void cell_fill_work(const lcp_work *w, const lcp_solver *s, long n_solves, record *r);

/* Caches as a caller finds them who did something else meanwhile, if the campaign asks for it. */
void cell_cool(const measured *m);

#define SET_TEXT(field, text) ((void)snprintf((field), sizeof(field), "%s", (text)))
