/* bullet_lemke.cpp - the Lemke method of Bullet (btLemkeAlgorithm.h, of the MBSim team), in double
 * precision, without the detour of btLemkeSolver over an inverse of M. */
#include "claim.h"

#include <BulletDynamics/MLCPSolvers/btLemkeAlgorithm.h>

static int solve(void *, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *result) {
  btMatrixXu m(p->n, p->n);
  btVectorXu q(p->n);
  for (int i = 0; i < p->n; i++) {
    q[i] = p->q[i];
    for (int j = 0; j < p->n; j++) {
      m.setElem(i, j, p->dense[static_cast<size_t>(j) * static_cast<size_t>(p->n) + i]);
    }
  }
  btLemkeAlgorithm lemke(m, q);
  const btVectorXu wz = lemke.solve(static_cast<unsigned>(call->max_iter)); /* w, then z */
  result->iterations = result->pivots = lemke.getSteps();
  for (int i = 0; i < p->n; i++) {
    z[i] = wz[p->n + i];
  }
  return peer_claim(call, 0, lemke.getInfo() == 0, z);
}

static const lcp_plugin_option options[] = {PEER_CLAIM_OPTION};

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "bullet_lemke",
    .title = "Lemke's method, of Bullet",
    .words = "Follows Lemke's path on a full tableau, ties broken in lexicographic order.",
    .when = "To compare with a physics engine, on small problems.",
    .sets = LCP_PLUGIN_ORTHANT,
    .storages = LCP_PLUGIN_DENSE,
    .needs = 0,
    .exact = 1,
    .max_iter = 1000,
    .options = options,
    .n_option = 1,
    .solve = solve,
};
