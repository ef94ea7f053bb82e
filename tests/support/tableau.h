/* tests/support/tableau.h - a small, slow, independent solver for the tests of the formulations:
 * dense Lemke tableau in long double with the lexicographic rule, free rows eliminated first. */
#pragma once

#include "lcp/lcp_outcome.h"
#include "lcp/lcp_problem.h"

/* Orthant and free blocks, any storage. z[p->M.n]. */
lcp_outcome tableau_solve(const lcp_problem *p, double *z);

/* max_i |min(z_i, w_i)| over the scale 1 + max|q|; free rows |w_i|. */
double tableau_residual(const lcp_problem *p, const double *z);
