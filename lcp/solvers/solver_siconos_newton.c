/* solver_siconos_newton.c - Siconos' semismooth Newton (Fischer-Burmeister, line search) (libsiconos-numerics), a peer. */
#include "lcp/solvers/siconos.h"

#include <lcp_cst.h>

static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  (void)trace; /* the library keeps no history */
  return siconos_solve_lcp(SICONOS_LCP_NEWTON_FB_FBLSA, state, p, opt, z, res);
}

const lcp_solver lcp_solver_siconos_newton = {
    .name = "siconos_newton",
    .title = "Siconos Newton",
    .cite = "acary2019, SICONOS_LCP_NEWTON_FB_FBLSA",
    .words = "Siconos' Newton steps on equations with kinks.",
    .when = "To hold this suite's own Newton steps against another code.",
    .sets = 1u << LCP_ORTHANT,
    .warm = true,
    SICONOS_PEER,
    .solve = solve,
};
