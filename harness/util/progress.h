/* harness/util/progress.h - one line on stderr: done/total, percent, time left, cell, last verdict.
 * Rewritten in place on a terminal, plain lines elsewhere (at most one in two seconds). */
#pragma once

#include <stdbool.h>

typedef struct progress {
  bool terminal, colour, quiet;
  int total, done, skipped; /* units; skipped ones cost nothing and do not enter the estimate */
  double started, last;     /* [s] */
} progress;

void progress_begin(progress *p, int total, int skipped, bool quiet);
void progress_step(progress *p, const char *what, const char *status, double seconds);
void progress_end(progress *p);
