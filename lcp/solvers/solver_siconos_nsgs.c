/* solver_siconos_nsgs.c - Siconos' nonsmooth Gauss-Seidel on Coulomb cones (libsiconos-numerics), a peer. */
#include "lcp/solvers/siconos.h"

#include <Friction_cst.h>

static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  (void)trace; /* the library keeps no history */
  return siconos_solve_cone(SICONOS_FRICTION_3D_NSGS, state, p, opt, z, res);
}

const lcp_solver lcp_solver_siconos_nsgs = {
    .name = "siconos_nsgs",
    .title = "Siconos NSGS",
    .cite = "acary2019, SICONOS_FRICTION_3D_NSGS",
    .words = "Siconos' sweeps, one friction cone at a time.",
    .when = "To hold this suite's own cone sweeps against another code.",
    SICONOS_CONE_PEER,
    .solve = solve,
};
