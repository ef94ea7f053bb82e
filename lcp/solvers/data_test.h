/* data_test.h - is the violation at z small against the data, not only against z?
 *
 * rho of lcp_judge.h is relative to the terms of M z. Where M is singular but for rounding, or z ran away on a problem
 * that has no solution, those terms are so large that rho is met by any z at all. What is asked besides:
 *
 *   r_i v_i <= 10 tol size  and  eps r_i tau0_i <= size / 10^6,   r_i = 1 / sqrt(M_ii)
 *
 * with size = max_j r_j |q_j| (or, of a box that does not hold zero, its distance from zero over r_j), v the natural map
 * d z - P(d z - w), d = 1/r^2, and tau0_i = |q_i| + sum |M_ij||z_j|: the violation as it is seen, without an allowance for
 * rounding, and what rounding of w may hide of it. Of M = [1 -1; -1 1], infeasible by 2^-20, w is zero to the last bit at
 * some z of 1e11. A cone is one row with the mean of its M_ii, the largest v_i and the largest tau0_i. */
#pragma once

#include "lcp/lcp_solver.h"

/* The size above; r of lcp_set_scaling. */
double lcp_data_size(const lcp_problem *p, const double *r);

/* w = M z + q; tau0 as above, NULL for zero: before the magnitudes are known. */
bool lcp_data_allows(const lcp_problem *p, double tol, double size, const double *r,
                     const double *z, const double *w, const double *tau0);

/* What z may miss by, tol and size as above; and by how much the worst row of a block does, for w of its rows. */
double lcp_data_limit(double tol, double size);
double lcp_data_miss(const lcp_problem *p, const lcp_block *b, const double *r, const double *z,
                     const double *w);

/* The same for a direct method on a stored M, after lcp_stop_met at z (w and the diagonal are in s). r[n] and tau0[n]
 * are scratch; counts its product with |M|. */
bool lcp_data_met(const lcp_problem *p, double tol, const lcp_stop_state *s, const double *z,
                  double *r, double *tau0, lcp_work *work);
