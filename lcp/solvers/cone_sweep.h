/* cone_sweep.h - one nonsmooth Gauss-Seidel sweep over contacts with second-order cones.
 *
 *   r_b <- r_b + omega (x - r_b),   x solves the contact  (A_b, w_b + s_b (r_b - c_b) - A_b r_b)
 *   A_b = M_bb + s_b I,  s_b = weight trace(M_bb) / size
 *
 * weight = 0 is plain NSGS (Jean 1999); weight > 0 the sweep of the proximal problem around c. Rows
 * of orthants, boxes and free blocks are swept one by one in the same way. */
#pragma once

#include "lcp/lcp_solver.h"
#include "lcp/solvers/sweep.h"

typedef struct lcp_cone_sweep {
  lcp_sweep sweep;
  double *lo, *hi; /* n, for interval rows */
  double *A;       /* diagonal blocks, size^2 each at LCP_CONE_MAX * start */
} lcp_cone_sweep;

void lcp_cone_sweep_layout(lcp_cone_sweep *s, const lcp_capacity *cap, base_arena *a);

/* BASE_EUNSUPPORTED: a diagonal that is not positive, or a cone block of more than LCP_CONE_MAX
 * rows. */
base_status lcp_cone_sweep_prepare(lcp_cone_sweep *s, const lcp_problem *p, base_error *err);

/* weight 0: `center` is not read. Returns max_b |change of r_b| / (|r_b| + |change|) [1]. */
double lcp_cone_sweep_run(lcp_cone_sweep *s, const lcp_problem *p, double omega, double weight,
                          const double *center, double *z);
