/* formulations/anderson.h - Anderson's mixing (linear/anderson.h) in memory that grows with the contacts. */
#pragma once

#include "lcp/linear/anderson.h"

typedef struct anderson {
  lin_anderson mixing;
  int cap;
  void *mem; /* owned */
} anderson;

/* Forgets all earlier steps; room for n unknowns. BASE_ENOMEM. */
base_status anderson_begin(anderson *a, int n, base_error *err);

/* As lin_anderson_next. */
base_status anderson_next(anderson *a, const double *step, int from, double *x, base_error *err);
void anderson_close(anderson *a);
