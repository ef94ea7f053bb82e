/* harness/measure/dump.h - the complementarity problems of chosen steps of a run, as files: one problem to
 * look at, or a sequence for warm-start studies.
 *
 * DIR/step_SSSSSS_KK.M.mtx .q.mtx .z.mtx (Matrix Market: problem and the run's own answer) or, for
 * cones and joints, DIR/step_SSSSSS_KK.dat (Siconos text), for boxes .npz (numpy), with its .z.mtx; SSSSSS: step from 1,
 * KK: solve within the step from 1. DIR/index.csv lists them in order:
 * step,solve,n,nnz,status,problem,answer */
#pragma once

#include "lcp/base/output.h"
#include "lcp/lcp_problem.h"

typedef struct dump {
  const char *folder; /* borrowed; made if it does not exist */
  long first, last;   /* steps, from 1 */
  long step;
  int solve;    /* within the step */
  int n_dumped; /* so far */
  base_out index;
} dump;

/* "N" or "A:B", 1 <= A <= B. */
base_status dump_range(const char *text, long *first, long *last, base_error *err);

base_status dump_open(dump *d, const char *folder, long first, long last, base_error *err);
enum { DUMP_NAME = 64 };

/* Problem and answer as the files of step and solve; `file` and `answer` get their names. BASE_EINVAL: no format holds it. */
base_status dump_files(const char *folder, long step, int solve, const lcp_problem *p,
                       const double *z, char file[DUMP_NAME], char answer[DUMP_NAME],
                       base_error *err);
/* A solved problem of step `step`; nothing is written outside the range. */
base_status dump_problem(dump *d, long step, const lcp_problem *p, const double *z,
                         const char *status, base_error *err);
/* Checks that everything was written, and (`complete`: the run came to its end) that something was:
 * a range without a problem is the caller's mistake. */
base_status dump_close(dump *d, bool complete, base_error *err);
