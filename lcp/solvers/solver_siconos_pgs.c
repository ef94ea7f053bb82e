/* solver_siconos_pgs.c - Siconos' projected Gauss-Seidel (libsiconos-numerics), a peer. */
#include "lcp/solvers/siconos.h"

#include <lcp_cst.h>

static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  (void)trace; /* the library keeps no history */
  return siconos_solve_lcp(SICONOS_LCP_PGS, state, p, opt, z, res);
}

const lcp_solver lcp_solver_siconos_pgs = {
    .name = "siconos_pgs",
    .title = "Siconos PGS",
    .cite = "acary2019, SICONOS_LCP_PGS",
    .words = "Siconos' sweeps, one unknown at a time.",
    .when = "To hold this suite's own sweeps against another code.",
    .sets = 1u << LCP_ORTHANT,
    .warm = true,
    SICONOS_PEER,
    .solve = solve,
};
