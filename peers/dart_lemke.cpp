/* dart_lemke.cpp - dart::lcpsolver::Lemke of DART: a dense solve for each pivot, at most 1000. */
#include "claim.h"

#include <dart/lcpsolver/Lemke.hpp>

static int solve(void *, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *) {
  const Eigen::MatrixXd m = Eigen::Map<const Eigen::MatrixXd>(p->dense, p->n, p->n);
  const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(p->q, p->n);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(p->n);
  const int said = dart::lcpsolver::Lemke(m, q, &x);
  if (x.size() == p->n) { /* it is left empty where the method gives up */
    Eigen::Map<Eigen::VectorXd>(z, p->n) = x;
  }
  return peer_claim(call, 0, said == 0, z);
}

static const lcp_plugin_option options[] = {PEER_CLAIM_OPTION};

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "dart_lemke",
    .title = "Lemke's method, of DART",
    .words = "Follows Lemke's path with a dense solve for each pivot.",
    .when = "To compare with a physics engine, on small problems, redundant contacts as well.",
    .sets = LCP_PLUGIN_ORTHANT,
    .storages = LCP_PLUGIN_DENSE,
    .needs = 0,
    .exact = 1,
    .options = options,
    .n_option = 1,
    .solve = solve,
};
