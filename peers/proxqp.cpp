/* proxqp.cpp - ProxQP of ProxSuite: an augmented Lagrangian method on the quadratic programme, the
 * bounds being rows l <= I z <= u. tol becomes eps_abs; the relative tolerance is off. */
#include "qp.h"

#include <new>
#include <proxsuite/proxqp/sparse/sparse.hpp>

namespace prox = proxsuite::proxqp;

static size_t workspace(int n, size_t entries, int, const double *) {
  return qp_bytes(n, entries, 2 * static_cast<size_t>(n));
}

static int outcome(prox::QPSolverOutput status) {
  switch (status) {
  case prox::QPSolverOutput::PROXQP_SOLVED:
    return LCP_PLUGIN_SOLVED;
  case prox::QPSolverOutput::PROXQP_MAX_ITER_REACHED:
    return LCP_PLUGIN_MAX_ITER;
  default: /* "dual infeasible" is no proof that the host could check */
    return LCP_PLUGIN_STALLED;
  }
}

static int run(const lcp_plugin_problem *p, const qp_triangle &t, const lcp_plugin_call *call,
               double *z, lcp_plugin_result *result) {
  using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
  const int n = p->n;
  const Matrix m = Eigen::Map<const Matrix>(n, n, t.colptr[n], t.colptr, t.rowind, t.val)
                       .selfadjointView<Eigen::Upper>();
  Matrix rows(n, n);
  rows.setIdentity();
  const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(p->q, n);
  const Eigen::VectorXd lo = Eigen::Map<const Eigen::VectorXd>(t.real, n);
  const Eigen::VectorXd hi = Eigen::Map<const Eigen::VectorXd>(t.real + n, n);
  prox::sparse::QP<double, int> qp(n, 0, n);
  qp.settings.eps_abs = call->tol;
  qp.settings.eps_rel = 0.0;
  qp.settings.max_iter = call->max_iter;
  qp.init(m, q, proxsuite::nullopt, proxsuite::nullopt, rows, lo, hi);
  qp.solve();
  Eigen::Map<Eigen::VectorXd>(z, n) = qp.results.x;
  result->iterations = static_cast<long>(qp.results.info.iter);
  return outcome(qp.results.info.status);
}

static int solve(void *work, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *result) {
  const qp_triangle t = qp_take(work, p, QP_UPPER, 2 * static_cast<size_t>(p->n));
  qp_bounds(p, 1e20, t.real, t.real + p->n); /* what the library takes for infinite */
  try {
    return run(p, t, call, z, result);
  } catch (const std::bad_alloc &) {
    return LCP_PLUGIN_NO_MEMORY;
  }
}

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "proxqp",
    .title = "ProxQP, of ProxSuite",
    .words = "Semismooth Newton steps inside a proximal augmented Lagrangian.",
    .when = "To compare with a solver of the field on symmetric problems of any rank.",
    .sets = LCP_PLUGIN_ORTHANT | LCP_PLUGIN_BOX | LCP_PLUGIN_FREE,
    .storages = LCP_PLUGIN_CSC,
    .needs = LCP_PLUGIN_SYMMETRIC,
    .max_iter = 10000,
    .workspace = workspace,
    .solve = solve,
};
