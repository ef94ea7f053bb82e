/* harness/cell/cell_run.h - measures one cell in the present process: a warm-up, then repetitions until
 * the median is known well enough. */
#pragma once

#include "harness/cell/isolate.h"
#include "harness/plan/plan.h"

typedef struct cell_job {
  const campaign *campaign;
  const cell *cell;
  int process;
  int mem_node;  /* that memory is bound to; -1: none, or not known (of a process that died) */
  double canary; /* latest canary time [s] */
  const char *solution; /* path for the answers (answers.h); NULL: not stored */
  const char *trace;    /* path for the convergence history (trace.h): the job is the untimed twin;
                           NULL: a timed run */
} cell_job;

/* Emits one record per repetition (of a twin: one without times); failures of the solver, of the
 * input and of memory are records too. One without a status is no row: answers or history could not
 * be stored, and its note says why. */
void cell_run(const cell_job *job, isolate_channel *out);

/* The row that the answers stored at path imply: every verdict anew, no times, no work. */
base_status cell_replay(const cell_job *job, const char *path, record *out, base_error *err);

/* The columns known before the run. */
void cell_identity(const cell_job *job, record *r);
