/* harness/campaign/runner.h - measures the units of a plan, each in its own process, and appends their rows
 * to DIR/results.csv. Rows of a unit are written in one piece; what is there already is not measured
 * again, so that a run may be killed at any moment and started again. */
#pragma once

#include "harness/measure/verdict.h"
#include "harness/plan/cover.h"

typedef enum rerun_what {
  RERUN_NONE,
  RERUN_FAILED,   /* every cell with a row that is not ok */
  RERUN_TIMEOUTS, /* timeout and time_limit */
  RERUN_ALL,
  RERUN_SOLVER /* the cells of one solver */
} rerun_what;

typedef struct runner_options {
  const char *out;           /* directory */
  const plan_filter *filter; /* what the plan was made with, for the manifest */
  rerun_what rerun;
  const char *rerun_solver;
  bool pin, quiet;
  bool solutions, trace; /* answers are stored; histories are recorded by untimed twins */
  double canary_every;   /* [s] */
  double budget;         /* wall time after which no process is begun [s]; 0: all are measured */
  int units;             /* of the plan that are measured; the others are left */
  const cover *order;    /* of the plan's units, where it is a cover's; NULL: the plan's own */
} runner_options;

typedef struct runner_summary {
  int units, measured, resumed; /* processes: in the plan, measured now, found done */
  int rows, stale; /* rows of cells that the plan does not know any more, moved to stale.csv */
  int cells, by_status[RUN_STATUS_COUNT]; /* cells of the plan; those with rows, of any session */
  int left;                               /* processes that are still to be measured */
  bool interrupted;
  double wall, inside; /* [s] of the measuring; of it spent in child processes */
} runner_summary;

base_status runner_run(const plan *p, const runner_options *o, runner_summary *out,
                       base_error *err);

/* Which units have their rows? done[n_unit]. */
base_status runner_done(const plan *p, const record_table *rows, bool *done, base_error *err);

/* Processes of the plan without rows in DIR, whatever machine measured there. */
base_status runner_left(const plan *p, const char *dir, int *left, base_error *err);

/* Does --rerun ask for the cell of this row? */
bool runner_wanted_again(const record *r, const runner_options *o);

/* A cell that failed in one process is not tried in the others. */
bool runner_ends_cell(const record *r);

/* What a cell comes to: the word of the first of its n > 0 rows that is not ok. */
run_status runner_cell_status(const row_ref *row, int n);

/* Counts the plan's cells in DIR by their status, whenever they were measured on this class of
 * machine. */
base_status runner_count_cells(const plan *p, const char *dir, int by_status[RUN_STATUS_COUNT],
                               base_error *err);

/* DIR/results.csv, read and written whole (harness/plan/record.h). Read also: DIR/results.csv.xz, packed, and a file
 * of rows itself in the place of DIR. BASE_EINVAL: both are there. */
base_status runner_read_rows(const char *dir, record_table *out, base_error *err);
base_status runner_write_rows(const char *dir, const record_table *t, base_error *err);
