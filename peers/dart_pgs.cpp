/* dart_pgs.cpp - dart::constraint::PgsBoxedLcpSolver of DART. Its own test is of the change
 * of x in a sweep, absolute and relative: both get tol. */
#include "box.h"
#include "claim.h"

#include <dart/constraint/PgsBoxedLcpSolver.hpp>

static int solve(void *, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *) {
  peer_box box(p, z, peer_box::padded(p->n));
  dart::constraint::PgsBoxedLcpSolver pgs;
  pgs.setOption(dart::constraint::PgsBoxedLcpSolver::Option(call->max_iter, call->tol, call->tol));
  const bool said = pgs.solve(p->n, box.a.data(), box.x.data(), box.b.data(), 0, box.lo.data(),
                              box.hi.data(), box.alone.data(), false);
  std::copy(box.x.begin(), box.x.end(), z);
  return peer_claim(call, 0, said, z);
}

static const lcp_plugin_option options[] = {PEER_CLAIM_OPTION};

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "dart_pgs",
    .title = "Projected Gauss-Seidel, of DART",
    .words = "Sweeps row by row until a sweep changes little.",
    .when = "To compare with a physics engine: what its own test of convergence is worth.",
    .sets = LCP_PLUGIN_ORTHANT | LCP_PLUGIN_BOX,
    .storages = LCP_PLUGIN_DENSE,
    .needs = LCP_PLUGIN_SYMMETRIC,
    .exact = 0,
    .warm = 1,
    .max_iter = 1000000,
    .options = options,
    .n_option = 1,
    .solve = solve,
};
