/* piqp.cpp - PIQP: a proximal interior point method on the quadratic programme, sparse or dense. tol
 * becomes eps_abs of its residuals and of its gap; the relative tolerances are off. */
#include "qp.h"

#include <new>
#include <piqp/piqp.hpp>

using Vector = Eigen::Map<const Eigen::VectorXd>;

static const lcp_plugin_option options[] = {
    {"backend", "1", "choice", 0, 0, 0, "sparse|dense", "the factorisation of its systems"},
};

static size_t workspace(int n, size_t entries, int, const double *) {
  return qp_bytes(n, entries, 2 * static_cast<size_t>(n));
}

static int outcome(piqp::Status status) {
  switch (status) {
  case piqp::PIQP_SOLVED:
    return LCP_PLUGIN_SOLVED;
  case piqp::PIQP_MAX_ITER_REACHED:
    return LCP_PLUGIN_MAX_ITER;
  case piqp::PIQP_NUMERICS:
    return LCP_PLUGIN_NUMERICAL;
  default: /* "dual infeasible" is no proof that the host could check */
    return LCP_PLUGIN_STALLED;
  }
}

template <class Solver, class Matrix>
static int run(const Matrix &m, const Vector &q, const Vector &lo, const Vector &hi,
               const lcp_plugin_call *call, double *z, lcp_plugin_result *result) {
  Solver piqp;
  auto &settings = piqp.settings();
  settings.eps_abs = settings.eps_duality_gap_abs = call->tol;
  settings.eps_rel = settings.eps_duality_gap_rel = 0.0;
  settings.max_iter = call->max_iter;
  piqp.setup(m, q, piqp::nullopt, piqp::nullopt, piqp::nullopt, piqp::nullopt, piqp::nullopt, lo,
             hi);
  const piqp::Status status = piqp.solve();
  Eigen::Map<Eigen::VectorXd>(z, q.size()) = piqp.result().x;
  result->iterations = result->factorizations = static_cast<long>(piqp.result().info.iter);
  return outcome(status);
}

static int solve(void *work, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *result) {
  const int n = p->n;
  const qp_triangle t = qp_take(work, p, QP_UPPER, 2 * static_cast<size_t>(n));
  qp_bounds(p, PIQP_INF, t.real, t.real + n);
  const Vector q(p->q, n);
  const Vector lo(t.real, n);
  const Vector hi(t.real + n, n);
  const Eigen::Map<const Eigen::SparseMatrix<double>> m(n, n, t.colptr[n], t.colptr, t.rowind,
                                                        t.val);
  try {
    if (call->option[0] > 0) {
      const Eigen::MatrixXd full = Eigen::MatrixXd(m).selfadjointView<Eigen::Upper>();
      return run<piqp::DenseSolver<double>>(full, q, lo, hi, call, z, result);
    }
    return run<piqp::SparseSolver<double>>(m, q, lo, hi, call, z, result);
  } catch (const std::bad_alloc &) {
    return LCP_PLUGIN_NO_MEMORY;
  }
}

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "piqp",
    .title = "PIQP",
    .words = "Follows the central path of the quadratic programme with proximal terms.",
    .when = "To compare with a solver of the field on symmetric problems of any rank.",
    .sets = LCP_PLUGIN_ORTHANT | LCP_PLUGIN_BOX | LCP_PLUGIN_FREE,
    .storages = LCP_PLUGIN_CSC,
    .needs = LCP_PLUGIN_SYMMETRIC,
    .max_iter = 250,
    .options = options,
    .n_option = 1,
    .workspace = workspace,
    .solve = solve,
};
