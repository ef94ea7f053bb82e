/* harness/campaign/runner_state.h - what the parts of a run share. Private to runner*.c. */
#pragma once

#include "harness/campaign/runner.h"
#include "harness/cell/cell_run.h"
#include "harness/cell/isolate.h"
#include "harness/cell/machine.h"
#include "harness/util/progress.h"

/* The untimed twin of a cell. */
typedef struct twin {
  bool dead;     /* it left no history, and would not the next time */
  char hash[24]; /* of its answers; "": not known */
} twin;

/* What other processes of the machine do, at the last reading. */
typedef struct busy_watch {
  double at, busy, own; /* clock, machine_busy, machine_own [s] */
  double load;          /* CPUs busy with other work since the reading before [1] */
} busy_watch;

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
  double begun;             /* the clock, when no other run held the folder any more [s] */
  double canary, canary_at; /* [s] */
  busy_watch other;
  record_table unit_rows; /* of the process being measured */
  bool lost;              /* one of them found no memory */
  cell_job job;
  twin *twin;          /* per cell */
  text_list forgotten; /* cells whose rows were set aside: their answers and histories went too */
} runner;

/* runner_folder.c: DIR/solutions/ID.ans and DIR/traces/ID.csv of a cell. */
void runner_solution_path(const runner *r, const char *id, char *buf, size_t cap);
void runner_trace_path(const runner *r, const char *id, char *buf, size_t cap);

/* runner_process.c: a first reading, without a load. */
busy_watch runner_busy_now(void);
/* A reading, at least so many seconds after the last one. */
void runner_watch_others(busy_watch *w, double least);

/* runner_process.c: leaves the rows of r->job in unit_rows. *whole false: the run was interrupted, and
 * nothing is kept. */
base_status runner_measure(runner *r, int order, isolate_end *end, bool *whole, base_error *err);

/* runner_rows.c: opens results.csv for appending, after what is there was read and settled. */
base_status runner_open_rows(runner *r, record_table *rows, base_error *err);
base_status runner_append_rows(runner *r, base_error *err); /* unit_rows, in one piece */

/* Closing pass over all rows: flags that need more than one row (canary_drift, same_bits) and the
 * names of the convergence histories. */
base_status runner_close_rows(runner *r, base_error *err);

/* runner_unit.c: one process of one cell, isolated, with its rows appended. */
base_status runner_unit(runner *r, int u, base_error *err);

/* runner_twin.c: what earlier sessions know of the twins; without those of forgotten cells. */
base_status runner_twins_open(runner *r, base_error *err);

/* The untimed twin of a cell (by its index in the plan), whose history goes to traces/: run once. */
base_status runner_twin(runner *r, int index, base_error *err);
/* Flags rows in unit_rows whose answers are not those of the cell's twin. */
void runner_twin_check(runner *r, int index);
