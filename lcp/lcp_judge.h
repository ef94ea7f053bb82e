/* lcp/lcp_judge.h - how good is a point? The independent judge: it sees the problem data and z,
 * nothing of the solver, and accumulates in long double.
 *
 * Two residuals for every problem:
 *
 * natural [m/s]   max_i |min(d_i z_i, w_i)|, d_i = M_ii (1 where M_ii <= 0), so that impulses and
 *                 velocities are never compared raw; on boxes, free rows and cones
 *                 d z - P_K(d z - w~), w~ with De Saxce's term.
 * rho [1]         the same, invariant under row scaling, column scaling and q -> a q
 *                 (RESIDUALS 1):
 *                   tau0_i = |q_i| + sum_j |M_ij||z_j|
 *                   zref_i = tau0_i / |M_ii|   (M_ii = 0: max over rows j with M_ji != 0 of
 *                                               tau0_j / |M_ji|; zero column: 1)
 *                   tau_i  = |q_i| + sum_j |M_ij| zref_j
 *                   rho = max_i max(-z_i/zref_i, -w_i/tau_i, min(z_i/zref_i, w_i/tau_i), 0)
 *                 free rows: |w_i|/tau_i; boxes: the violated half of the same; cones: block
 *                 residual over the largest tau of the block.
 *
 * rho is relative to the terms of M z, and any z passes that is large enough, as on M = [1 -1; -1 1], q = (-1, -1), which has no
 * solution. So a third one is against the data, RESIDUALS 4: with r_i^2 M_ii = 1 and size = max(r_j |q_j|, distance of a box from zero over r_j)
 *
 * defect [1]      max_i r_i natural_i / size
 * noise [1]       max_i 32 eps r_i tau0_i / size: what rounding of z leaves. Both are 0 where size is: z = 0 is an answer then.
 *
 * `verified` means rho <= tol, and small against the data (lcp_judged_small); natural is what plots show.
 */
#pragma once

#include "lcp/lcp_problem.h"

typedef struct lcp_verdict {
  double rho;           /* [1] */
  double natural;       /* [m/s] */
  int natural_row;      /* of the row that has it; of a cone, of the entry */
  double defect, noise; /* against the data [1] */
  double natural_rel;   /* natural / (1 + max|q|) [1] */
  double min_map;       /* max_i |min(z_i, w_i)|, unscaled, the literature's number */
  double infeasible_z;  /* largest violation of z in K [N s] */
  double infeasible_w;  /* largest violation of w in K* [m/s] */
  double comp;          /* sum |z_i w_i| [J] (cones: |z.w~| per block) */
  bool finite;          /* no NaN or Inf in z */
} lcp_verdict;

/* Tolerances on rho that "verified" means by default. */
#define LCP_VERIFY_EXACT     1e-9 /* solvers that declare `exact` */
#define LCP_VERIFY_ITERATIVE 1e-6 /* the others */

/* Is the violation small against the data at this tolerance, defect <= 10 tol, with room for rounding up to a thousandth? */
bool lcp_judged_small(const lcp_verdict *v, double tol);

/* Judges z[n]. Allocates scratch (it is never inside a timed bracket). A point with NaN or Inf
 * has finite = false and all residuals HUGE_VAL; so does, but for finite, one whose w = M z + q leaves the
 * range of double. */
base_status lcp_judge(const lcp_problem *p, const double *z, lcp_verdict *out, base_error *err);
