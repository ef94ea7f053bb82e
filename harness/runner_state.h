/* harness/runner_state.h - what the parts of a run share. Private to runner*.c. */
#pragma once

#include "harness/cell_run.h"
#include "harness/machine.h"
#include "harness/progress.h"
#include "harness/runner.h"

typedef struct runner {
  const plan *plan;
  const runner_options *o;
  runner_summary *sum;
  machine machine;
  int fd;      /* results.csv, append only */
  int lock;    /* .lock */
  int earlier; /* rows of earlier sessions */
  bool *done;
  bool *ended; /* per cell: failed, no further processes */
  progress progress;
  double canary, canary_at; /* [s] */
  record_table unit_rows;   /* of the process being measured */
  bool lost;                /* one of them found no memory */
  cell_job job;
  char twin_hash[24]; /* of the untimed twin just run; "": none */
} runner;

/* runner_rows.c: opens results.csv for appending, after what is there was read and settled. */
base_status runner_open_rows(runner *r, record_table *rows, base_error *err);
base_status runner_append_rows(runner *r, base_error *err); /* unit_rows, in one piece */

/* Closing pass over all rows: flags that need more than one row (canary_drift, same_bits) and the
 * names of the convergence histories. */
base_status runner_close_rows(runner *r, base_error *err);

/* runner_unit.c: one process of one cell, isolated, with its rows appended. */
base_status runner_unit(runner *r, int u, base_error *err);

/* The untimed twin of a cell (by its index in the plan), whose history goes to traces/. */
base_status runner_twin(runner *r, int index, base_error *err);
void runner_solution_path(const runner *r, const char *id, char *buf, size_t cap);
void runner_trace_path(const runner *r, const char *id, char *buf, size_t cap);
