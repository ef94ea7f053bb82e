/* solver_siconos_lemke.c - Siconos' lexicographic Lemke (libsiconos-numerics), a peer. */
#include "lcp/solvers/siconos.h"

#include <lcp_cst.h>

static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  (void)trace; /* the library keeps no history */
  return siconos_solve_lcp(SICONOS_LCP_LEMKE, state, p, opt, z, res);
}

const lcp_solver lcp_solver_siconos_lemke = {
    .name = "siconos_lemke",
    .title = "Siconos Lemke",
    .cite = "acary2019, SICONOS_LCP_LEMKE",
    .words = "Siconos' Lemke: exact, by pivoting along a path.",
    .when = "To hold this suite's own pivoting against another code.",
    .sets = 1u << LCP_ORTHANT,
    .exact = true,
    SICONOS_PEER,
    .solve = solve,
};
