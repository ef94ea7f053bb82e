/* bullet_pgs.cpp - the projected Gauss-Seidel method of Bullet (btSolveProjectedGaussSeidel.h), in
 * double precision. It runs as many sweeps as it is told, so it is called in turns with the host's
 * test, some sweeps to a call. */
#include <BulletDynamics/MLCPSolvers/btSolveProjectedGaussSeidel.h>
#include <cstdio>
#include <lcpbench/lcp_plugin.h>

static int prepare(void *, const lcp_plugin_problem *p, const double *, char *message) {
  for (int i = 0; i < p->n; i++) {
    const double d = p->dense[static_cast<size_t>(i) * static_cast<size_t>(p->n + 1)];
    if (!(d > 0)) {
      snprintf(message, LCP_PLUGIN_MESSAGE, "diagonal entry %d is %g: need > 0", i, d);
      return LCP_PLUGIN_UNSUPPORTED;
    }
  }
  return LCP_PLUGIN_READY;
}

static int solve(void *, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *result) {
  const int n = p->n;
  const auto sweeps = static_cast<int>(call->option[0]);
  btMatrixXu a(n, n);
  btVectorXu b(n), x(n), lo(n), hi(n);
  btAlignedObjectArray<int> alone; /* no row bounds another */
  for (int i = 0; i < n; i++) {
    alone.push_back(-1);
    b[i] = -p->q[i];
    x[i] = z[i];
    lo[i] = p->lo[i];
    hi[i] = p->hi[i];
    for (int j = 0; j < n; j++) {
      a.setElem(i, j, p->dense[static_cast<size_t>(j) * static_cast<size_t>(n) + i]);
    }
  }
  btSolveProjectedGaussSeidel pgs;
  while (!call->stop(call->host, result->iterations, z)) {
    pgs.solveMLCP(a, b, x, lo, hi, alone, sweeps, true);
    for (int i = 0; i < n; i++) {
      z[i] = x[i];
    }
    result->iterations += sweeps;
  }
  return LCP_PLUGIN_AS_STOPPED;
}

static const lcp_plugin_option options[] = {
    {"sweeps", "1", "int", 10, 1, 1000, NULL, "sweeps of the library between two tests"},
};

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "bullet_pgs",
    .title = "Projected Gauss-Seidel, of Bullet",
    .words = "Sweeps row by row, each made right with the others held.",
    .when = "To compare with a physics engine: what its sweeps cost to a given accuracy.",
    .sets = LCP_PLUGIN_ORTHANT | LCP_PLUGIN_BOX,
    .storages = LCP_PLUGIN_DENSE,
    .needs = LCP_PLUGIN_SYMMETRIC,
    .warm = 1,
    .max_iter = 1000000,
    .options = options,
    .n_option = 1,
    .prepare = prepare,
    .solve = solve,
};
