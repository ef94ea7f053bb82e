/* bullet_dantzig.cpp - the Dantzig method of Bullet (btDantzigLCP.h, from ODE), in double precision. */
#include "box.h"
#include "claim.h"

#include <BulletDynamics/MLCPSolvers/btDantzigLCP.h>

static int solve(void *, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *) {
  peer_box box(p, z, static_cast<size_t>(p->n));
  btDantzigScratchMemory scratch;
  for (double &lo : box.lo) {
    lo = std::max(lo, static_cast<double>(-BT_INFINITY)); /* what the code knows as unbounded */
  }
  for (double &hi : box.hi) {
    hi = std::min(hi, static_cast<double>(BT_INFINITY));
  }
  const bool said = btSolveDantzigLCP(p->n, box.a.data(), box.x.data(), box.b.data(), box.w.data(),
                                      0, box.lo.data(), box.hi.data(), box.alone.data(), scratch);
  std::copy(box.x.begin(), box.x.end(), z);
  return peer_claim(call, 0, said, z);
}

static const lcp_plugin_option options[] = {PEER_CLAIM_OPTION};

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "bullet_dantzig",
    .title = "Dantzig's method, of Bullet",
    .words = "Brings in one row at a time and keeps those before it right, as ODE does.",
    .when = "To compare with a physics engine on symmetric problems without redundant contacts.",
    .sets = LCP_PLUGIN_ORTHANT | LCP_PLUGIN_BOX,
    .storages = LCP_PLUGIN_DENSE,
    .needs = LCP_PLUGIN_SYMMETRIC,
    .exact = 1,
    .options = options,
    .n_option = 1,
    .solve = solve,
};
