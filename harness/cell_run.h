/* harness/cell_run.h - measures one cell in the present process: a warm-up, then repetitions until
 * the median is known well enough. */
#pragma once

#include "harness/isolate.h"
#include "harness/plan.h"

typedef struct cell_job {
  const campaign *campaign;
  const cell *cell;
  int process;
  double canary;        /* latest canary time [s] */
  const char *solution; /* path for the answer of an LCP cell; NULL: not stored */
} cell_job;

/* Emits one record per repetition; failures of the solver, of the input and of memory are records
 * too. */
void cell_run(const cell_job *job, isolate_channel *out);

/* The columns known before the run. */
void cell_identity(const cell_job *job, record *r);
