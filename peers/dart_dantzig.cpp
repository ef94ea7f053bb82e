/* dart_dantzig.cpp - dSolveLCP of ODE, in the copy of DART (ODE's own is not public). */
#include "box.h"
#include "claim.h"

#include <dart/external/odelcpsolver/lcp.h>

static int solve(void *, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *) {
  peer_box box(p, z, peer_box::padded(p->n));
  const bool said =
      dart::external::ode::dSolveLCP(p->n, box.a.data(), box.x.data(), box.b.data(), box.w.data(),
                                     0, box.lo.data(), box.hi.data(), box.alone.data());
  std::copy(box.x.begin(), box.x.end(), z);
  return peer_claim(call, 0, said, z);
}

static const lcp_plugin_option options[] = {PEER_CLAIM_OPTION};

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "dart_dantzig",
    .title = "Dantzig's method, of ODE and DART",
    .words = "Brings in one row at a time and keeps those before it right.",
    .when = "To compare with physics engines on symmetric problems without redundant contacts.",
    .sets = LCP_PLUGIN_ORTHANT | LCP_PLUGIN_BOX,
    .storages = LCP_PLUGIN_DENSE,
    .needs = LCP_PLUGIN_SYMMETRIC,
    .exact = 1,
    .options = options,
    .n_option = 1,
    .solve = solve,
};
