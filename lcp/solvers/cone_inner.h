/* cone_inner.h - one proximal problem of cones by a semismooth Newton method: in the variables of cone_scaled.h
 *
 *   F(x, y(x) + weight (x - c)) = 0,   c = x at the start,   F of Alart & Curnier (cone_map.h)
 *
 * Steps of length 1, 1/2, 1/4 by Armijo's rule on |F|, else whole: a step that a kink of F stops is not mended by a short one. */
#pragma once

#include "lcp/solvers/cone_step.h"

typedef struct lcp_cone_inner {
  lcp_cone_scaled eq;
  lcp_cone_step step;
  double *x, *y, *center, *dx, *trial, *w; /* n */
  double *scratch;                         /* of a product */
} lcp_cone_inner;

void lcp_cone_inner_layout(lcp_cone_inner *s, const lcp_capacity *cap, base_arena *a);

/* BASE_EUNSUPPORTED: what lcp_cone_scaled_begin and lcp_cone_step_prepare refuse. */
base_status lcp_cone_inner_prepare(lcp_cone_inner *s, const lcp_problem *p, base_error *err);

/* From z, the centre, until |F| is a tenth of the |F| without the weight, in at most `steps` Newton steps. Returns how many were
 * taken, `steps` + 1 where it got no further: that many did not do, or the system was singular. BASE_ENOMEM through *status. */
int lcp_cone_inner_run(lcp_cone_inner *s, const lcp_problem *p, double weight, int steps, double *z,
                       lcp_work *work, base_status *status);

void lcp_cone_inner_release(lcp_cone_inner *s);
