/* osqp.c - OSQP: ADMM on the quadratic programme, the bounds being rows l <= I z <= u. tol becomes
 * eps_abs and eps_rel. */
#include "qp.h"

#include <osqp.h>

static const lcp_plugin_option options[] = {
    {"polish", "1", "int", 0, 0, 1, NULL, "1: solves once more with the rows found at a bound"},
};

static size_t workspace(int n, size_t entries, int n_block, const double *option) {
  (void)n_block, (void)option;
  return qp_bytes(n, entries, 3 * (size_t)n) + (2 * (size_t)n + 1) * sizeof(int);
}

/* The identity, its ones in val, its indices behind the triangle. */
static csc identity(int n, double *val, int *index) {
  for (int i = 0; i <= n; i++) {
    index[i] = i;
  }
  for (int i = 0; i < n; i++) {
    val[i] = 1.0;
    index[n + 1 + i] = i;
  }
  return (csc){.nzmax = n, .m = n, .n = n, .p = index, .i = index + n + 1, .x = val, .nz = -1};
}

static int outcome(c_int status) {
  switch (status) {
  case OSQP_SOLVED:
    return LCP_PLUGIN_SOLVED;
  case OSQP_MAX_ITER_REACHED:
  case OSQP_SOLVED_INACCURATE:
    return LCP_PLUGIN_MAX_ITER;
  default: /* "dual infeasible" is no proof that the host could check */
    return LCP_PLUGIN_STALLED;
  }
}

static int solve(void *work, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *result) {
  const int n = p->n;
  qp_triangle t = qp_take(work, p, QP_UPPER, 3 * (size_t)n);
  csc P = {
      .nzmax = t.colptr[n], .m = n, .n = n, .p = t.colptr, .i = t.rowind, .x = t.val, .nz = -1};
  csc A = identity(n, t.real, t.colptr + n + 1);
  OSQPData data = {.n = n, .m = n, .P = &P, .A = &A, .l = t.real + n, .u = t.real + 2 * n};
  OSQPSettings settings;
  OSQPWorkspace *osqp = NULL;
  data.q = (c_float *)p->q; /* copied, not written to */
  qp_bounds(p, OSQP_INFTY, data.l, data.u);
  osqp_set_default_settings(&settings);
  settings.verbose = 0;
  settings.eps_abs = settings.eps_rel = call->tol;
  settings.max_iter = call->max_iter;
  settings.polish = (c_int)call->option[0];
  if (osqp_setup(&osqp, &data, &settings) != 0) {
    osqp_cleanup(osqp);
    return LCP_PLUGIN_NUMERICAL; /* also: not convex */
  }
  (void)osqp_warm_start_x(osqp, z);
  (void)osqp_solve(osqp);
  for (int i = 0; i < n; i++) {
    z[i] = osqp->solution->x[i];
  }
  result->iterations = osqp->info->iter;
  result->factorizations = 1 + osqp->info->rho_updates;
  const int code = outcome(osqp->info->status_val);
  osqp_cleanup(osqp);
  return code;
}

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "osqp",
    .title = "OSQP",
    .words = "Splits the quadratic programme (ADMM) with one factorisation for many iterations.",
    .when = "To compare with a solver of the field on symmetric problems at modest accuracy.",
    .sets = LCP_PLUGIN_ORTHANT | LCP_PLUGIN_BOX | LCP_PLUGIN_FREE,
    .storages = LCP_PLUGIN_CSC,
    .needs = LCP_PLUGIN_SYMMETRIC,
    .warm = 1,
    .max_iter = 200000,
    .options = options,
    .n_option = 1,
    .workspace = workspace,
    .solve = solve,
};
