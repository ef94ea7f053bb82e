/* harness/check/case_lcp.h - judges a solver's answer to an LCP case (RESIDUALS 7). */
#pragma once

#include "harness/measure/solve_once.h"
#include "problems/read/case_file.h"

/* What the solver claimed, as a CASE_ bit. */
case_status case_lcp_word(const solve_record *r);

/* "solved", "unsolved_ray", ... of one bit */
const char *case_lcp_name(case_status word);

/* Distance of z to the answers the case knows, relative, by its own rule, and the tolerance. False:
 * the case states nothing beyond the residual. */
bool case_lcp_forward(const lcp_case *c, const lcp_solver *s, const double *z, double *error,
                      double *tolerance, const char **rule);

/* Does what the case states hold: do its answers solve the problem (rho at most LCP_VERIFY_EXACT), does its Farkas vector prove that none
 * does, up to rounding? BASE_EINVAL names what does not. Of a case whose data are a problem. */
base_status case_lcp_holds(const lcp_case *c, base_error *err);
