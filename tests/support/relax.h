/* tests/support/relax.h - a slow, independent solver for the tests: Gauss-Seidel by blocks with
 * projections, for orthants, boxes, free rows and friction cones. */
#pragma once

#include "lcp/lcp_outcome.h"
#include "lcp/lcp_problem.h"

lcp_outcome relax_solve(const lcp_problem *p, double *z, double tol);
