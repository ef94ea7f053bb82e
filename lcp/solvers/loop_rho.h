/* loop_rho.h - the residual of lcp_judge.h for the loop of an iterative method. */
#pragma once

#include "lcp/lcp_solver.h"

/* out_i = |q_i| + sum_j |M_ij||x_j|; for the factored form with S alone in the place of M. */
void lcp_loop_magnitudes(const lcp_problem *p, const double *x, double *out);

/* rho at z, after lcp_stop_test has been there (w, d, tau); costs two products with |M|. tau0[n] is
 * scratch. HUGE_VAL where p has cones: lcp_stop_test is exact on those. */
double lcp_loop_rho(lcp_stop_state *s, const lcp_problem *p, const double *z, double *tau0);
