/* harness/measure/trace.h - convergence histories as CSV: `solve,iteration,residual`, one line per residual
 * test of a solver, solves numbered from 1 in the order they were made. The residual is the solver's
 * own estimate of rho (lcp_judge.h). A traced run is never timed: it is the untimed twin of a cell. */
#pragma once

#include "lcp/base/output.h"
#include "lcp/lcp_solver.h"

typedef struct trace_file {
  base_out file;
  lcp_trace buffer; /* of the solve being traced */
  long solves, points;
  bool full; /* a solve had more tests than the buffer holds: its later ones are missing */
} trace_file;

/* The file gets its name when it is closed whole. */
base_status trace_open(trace_file *t, const char *path, base_error *err);

/* The buffer to hand to a solver, emptied. */
lcp_trace *trace_begin(trace_file *t);
base_status trace_end(trace_file *t, base_error *err); /* writes what the solver left in it */

/* The end of what is traced: `done` if that failed (the file is discarded), except by a file that could not
 * be written, of which the file itself tells why; else how the file came to its name. */
base_status trace_finish(trace_file *t, base_status done, base_error *err);
