/* solver_siconos_prox.c - Siconos' proximal point method on Coulomb cones (libsiconos-numerics), a peer. */
#include "lcp/solvers/siconos.h"

#include <Friction_cst.h>

static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  (void)trace; /* the library keeps no history */
  return siconos_solve_cone(SICONOS_FRICTION_3D_PROX, state, p, opt, z, res);
}

const lcp_solver lcp_solver_siconos_prox = {
    .name = "siconos_prox",
    .title = "Siconos PROX",
    .cite = "acary2019, SICONOS_FRICTION_3D_PROX",
    .words = "Siconos' proximal steps, each by Newton's method or sweeps.",
    .when = "To hold this suite's own proximal steps on cones against another code.",
    SICONOS_CONE_PEER,
    .solve = solve,
};
