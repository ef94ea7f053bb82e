/* mixing.h - Anderson's mixing (linear/anderson.h) of a fixed point x = x + step(x), with a safeguard: where the step at a mixed
 * point is twice as long as the one before, the plain point is taken instead and the mixing begins anew. */
#pragma once

#include "lcp/lcp_solver.h"
#include "lcp/linear/anderson.h"

typedef struct lcp_mixing {
  lin_anderson anderson;
  double *plain; /* n: the last x + step */
  double length; /* of that step */
} lcp_mixing;

void lcp_mixing_layout(lcp_mixing *s, const lcp_capacity *cap, base_arena *a);

/* Forgets all earlier steps. */
void lcp_mixing_begin(lcp_mixing *s, int n);

/* x[n], at which the step is step[n], in; the next point out. A refused point counts in `fallbacks`.
 * Errors: those of lin_anderson_next. */
base_status lcp_mixing_next(lcp_mixing *s, const double *step, double *x, lcp_work *work);
