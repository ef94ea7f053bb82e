/* formulations/anderson.h - a fixed point x = x + step(x) by Anderson's mixing (Walker & Ni 2011, SIAM J. Numer. Anal. 49,
 * algorithm AA): the differences of the last few points and steps say what move makes the step smallest, which also
 * ends where the plain iteration turns in circles or moves slowly away. */
#pragma once

#include "lcp/base/status.h"

enum { ANDERSON_DEPTH = 6 };

typedef struct anderson {
  int n;
  int taken, kept;       /* steps since anderson_begin; pairs of differences in memory */
  double *at, *step;     /* n: point and step of the last time */
  double *d_at, *d_step; /* ANDERSON_DEPTH columns of n: their differences, a ring */
  double *mix, *rest;    /* columns again, n: scratch of the least squares */
  int cap;
  void *mem; /* owned */
} anderson;

/* Forgets all earlier steps; room for n unknowns. BASE_ENOMEM. */
base_status anderson_begin(anderson *a, int n, base_error *err);

/* x[n], at which the step is step[n], in; the next point out. Differences count from step `from` on (1: all of them).
 * BASE_EEXTERNAL if LAPACK fails. */
base_status anderson_next(anderson *a, const double *step, int from, double *x, base_error *err);
void anderson_close(anderson *a);
