/* daqp.c - DAQP: the dual active set method on the quadratic programme; where M is not symmetric,
 * its solver of affine variational inequalities. tol becomes primal_tol; what a singular M needs
 * (proximal steps) is left to the library's own choice. */
#include <api.h>
#include <lcpbench/lcp_plugin.h>
#include <math.h>
#include <string.h>

static size_t workspace(int n, size_t entries, int n_block, const double *option) {
  (void)entries, (void)n_block, (void)option;
  const size_t rows = (size_t)n;
  return (rows * rows + 5 * rows) * sizeof(double) + rows * sizeof(int);
}

static int outcome(int flag) {
  switch (flag) {
  case DAQP_EXIT_OPTIMAL:
    return LCP_PLUGIN_SOLVED;
  case DAQP_EXIT_ITERLIMIT:
    return LCP_PLUGIN_MAX_ITER;
  case DAQP_EXIT_TIMELIMIT:
    return LCP_PLUGIN_TIME_LIMIT;
  case DAQP_EXIT_NONCONVEX:
  case DAQP_EXIT_UNSUPPORTED:
    return LCP_PLUGIN_NUMERICAL;
  default: /* cycling, inexact; "unbounded" is no proof that the host could check */
    return LCP_PLUGIN_STALLED;
  }
}

/* Reads M by rows; the host stores it by columns. */
static void transpose(const lcp_plugin_problem *p, double *to) {
  const size_t n = (size_t)p->n;
  for (size_t j = 0; j < n; j++) {
    for (size_t i = 0; i < n; i++) {
      to[i * n + j] = p->dense[j * n + i];
    }
  }
}

static int solve(void *work, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *result) {
  const size_t n = (size_t)p->n;
  double *H = work;
  double *f = H + n * n;
  double *lo = f + n;
  double *hi = lo + n;
  double *lam = hi + n;
  double *x = lam + n;
  int *sense = (int *)(void *)(x + n);
  const int symmetric = (p->traits & LCP_PLUGIN_SYMMETRIC) != 0;
  DAQPProblem problem = {.n = p->n,
                         .m = p->n,
                         .ms = p->n,
                         .H = H,
                         .f = f,
                         .bupper = hi,
                         .blower = lo,
                         .sense = sense,
                         .problem_type = symmetric ? 0 : 1};
  DAQPResult found = {.x = x, .lam = lam};
  DAQPSettings settings;
  transpose(p, H);
  memcpy(f, p->q, n * sizeof *f);
  memset(sense, 0, n * sizeof *sense);
  memset(x, 0, n * sizeof *x);
  for (size_t i = 0; i < n; i++) {
    lo[i] = fmax(p->lo[i], -DAQP_INF);
    hi[i] = fmin(p->hi[i], DAQP_INF);
  }
  daqp_default_settings(&settings);
  settings.primal_tol = call->tol;
  settings.iter_limit = call->max_iter;
  settings.time_limit = isfinite(call->max_seconds) ? call->max_seconds : 0.0; /* 0: none */
  daqp_quadprog(&found, &problem, &settings);
  if (found.exitflag > 0) { /* else x is no iterate, and may hold what was never set */
    memcpy(z, x, n * sizeof *z);
  }
  result->iterations = found.iter;
  return outcome(found.exitflag);
}

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "daqp",
    .title = "DAQP",
    .words = "Adds and drops rows of a dual active set, from a Cholesky factor of M.",
    .when = "To compare with a solver of the field on small dense convex problems.",
    .sets = LCP_PLUGIN_ORTHANT | LCP_PLUGIN_BOX | LCP_PLUGIN_FREE,
    .storages = LCP_PLUGIN_DENSE,
    .needs = 0,
    .max_iter = 100000,
    .workspace = workspace,
    .solve = solve,
};
