/* lcp/lcp_cone.h - geometry of the contact cone K = { (r_n, r_1, ...): |r_k| <= mu_k r_n }. */
#pragma once

#include "lcp/lcp_problem.h"

/* out = argmin over K of |out - x|^2; size b->size; out may alias x. Exact: the normal part solves
 * r_n (1 + sum_A mu_k^2) = x_n + sum_A mu_k |x_k| over the parts A that end on their bound. */
void lcp_cone_project(const lcp_block *b, const double *x, double *out);

/* sum_k mu_k |w_k|: De Saxce's shift of the normal velocity [m/s]. */
double lcp_cone_shift(const lcp_block *b, const double *w);

/* max(0, -r_n, max_k (|r_k| - mu_k r_n)). */
double lcp_cone_violation(const lcp_block *b, const double *r);
