/* tests/support/solve.h - one problem by one solver. */
#pragma once

#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"

/* What a solver with these options ("": none; else as "tol=1e-9,max_iter=5") says to the problem when it is prepared, in `err` as well; where that
 * is BASE_OK, its answer from z in z. It must not take memory in the solve, unless it is declared to. The certificate is gone with the
 * instance. */
base_status try_solve(const char *solver, const char *options, const lcp_problem *p, double *z,
                      lcp_result *res, base_error *err);

/* The same where the solver must take the problem. */
lcp_result solve_by(const char *solver, const char *options, const lcp_problem *p, double *z);

/* The verdict on z. */
lcp_verdict verdict_on(const lcp_problem *p, const double *z);
