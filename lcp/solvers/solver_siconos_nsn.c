/* solver_siconos_nsn.c - Siconos' nonsmooth Newton method on the Alart-Curnier function on Coulomb cones (libsiconos-numerics), a peer. */
#include "lcp/solvers/siconos.h"

#include <Friction_cst.h>

static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  (void)trace; /* the library keeps no history */
  return siconos_solve_cone(SICONOS_FRICTION_3D_NSN_AC, state, p, opt, z, res);
}

const lcp_solver lcp_solver_siconos_nsn = {
    .name = "siconos_nsn",
    .title = "Siconos NSN_AC",
    .cite = "acary2019, SICONOS_FRICTION_3D_NSN_AC",
    .words = "Siconos' Newton steps on the round friction cone.",
    .when = "To hold this suite's own Newton steps on cones against another code.",
    SICONOS_CONE_PEER,
    .solve = solve,
};
