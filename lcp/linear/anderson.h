/* linear/anderson.h - a fixed point x = x + step(x) by Anderson's mixing (Walker & Ni 2011, SIAM J. Numer. Anal. 49,
 * algorithm AA): the differences of the last few points and steps say what move makes the step smallest, which also
 * ends where the plain iteration turns in circles or moves slowly away. */
#pragma once

#include "lcp/base/arena.h"
#include "lcp/base/status.h"

enum { LIN_ANDERSON_DEPTH = 6 };

typedef struct lin_anderson {
  int n;
  int taken, kept;       /* steps since lin_anderson_begin; pairs of differences in memory */
  double *at, *step;     /* n: point and step of the last time */
  double *d_at, *d_step; /* LIN_ANDERSON_DEPTH columns of n: their differences, a ring */
  double *mix, *rest;    /* columns again, n: scratch of the least squares */
} lin_anderson;

/* Room for cap unknowns. */
void lin_anderson_layout(lin_anderson *a, int cap, base_arena *m);

/* Forgets all earlier steps; n unknowns, at most as many as there is room for. */
void lin_anderson_begin(lin_anderson *a, int n);

/* x[n], at which the step is step[n], in; the next point out. Differences count from step `from` on (1: all of them).
 * BASE_EEXTERNAL if a step is not a number. Does not allocate. */
base_status lin_anderson_next(lin_anderson *a, const double *step, int from, double *x,
                              base_error *err);
