/* scs.c - SCS: splitting on the homogeneous self-dual form of the quadratic programme,
 *
 *   min 1/2 z'Mz + q'z   subject to   A z + s = b,  s in a cone:
 *
 * A = -I, b = 0 and s = z >= 0 where every row is z_i >= 0; else the cone of boxes
 * { (t, t s): lo <= s <= hi } with a first row, zero in A and one in b, that makes t = 1. tol becomes
 * eps_abs and eps_rel. */
#include "qp.h"

#include <scs.h>

static size_t workspace(int n, size_t entries, int n_block, const double *option) {
  (void)n_block, (void)option;
  return qp_bytes(n, entries, 7 * (size_t)n + 3) + (2 * (size_t)n + 1) * sizeof(int);
}

static int all_nonnegative(const lcp_plugin_problem *p) {
  for (int k = 0; k < p->n_block; k++) {
    if (p->block[k].set != LCP_PLUGIN_ORTHANT) {
      return 0;
    }
  }
  return 1;
}

/* -I below so many rows of zeros; val n, index 2n+1. */
static ScsMatrix rows(int n, int zeros, double *val, int *index) {
  for (int i = 0; i <= n; i++) {
    index[i] = i;
  }
  for (int i = 0; i < n; i++) {
    val[i] = -1.0;
    index[n + 1 + i] = i + zeros;
  }
  return (ScsMatrix){.x = val, .i = index + n + 1, .p = index, .m = n + zeros, .n = n};
}

static int outcome(scs_int status, const ScsInfo *info, const lcp_plugin_call *call) {
  if (status == SCS_SOLVED) {
    return LCP_PLUGIN_SOLVED;
  }
  if (status == SCS_FAILED) {
    return LCP_PLUGIN_NUMERICAL;
  }
  return info->iter >= call->max_iter ? LCP_PLUGIN_MAX_ITER : LCP_PLUGIN_STALLED;
}

static int solve(void *work, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *result) {
  const int n = p->n;
  const int box = all_nonnegative(p) ? 0 : 1;
  const qp_triangle t = qp_take(work, p, QP_UPPER, 7 * (size_t)n + 3);
  double *lo = t.real + n;
  double *hi = lo + n;
  double *b = hi + n;
  double *s = b + n + 1;
  double *y = s + n + 1;
  double *x = y + n + 1;
  ScsMatrix P = {.x = t.val, .i = t.rowind, .p = t.colptr, .m = n, .n = n};
  ScsMatrix A = rows(n, box, t.real, t.colptr + n + 1);
  const ScsData data = {.m = n + box, .n = n, .A = &A, .P = &P, .b = b, .c = (scs_float *)p->q};
  const ScsCone cone = box ? (ScsCone){.bu = hi, .bl = lo, .bsize = n + 1} : (ScsCone){.l = n};
  ScsSettings settings;
  ScsSolution solution = {.x = x, .y = y, .s = s};
  ScsInfo info = {0};
  qp_bounds(p, 1e20, lo, hi); /* beyond 1e15 the library takes a bound for infinite */
  for (int i = 0; i <= n; i++) {
    b[i] = box == 1 && i == 0;
    x[i < n ? i : 0] = s[i] = y[i] = 0.0;
  }
  scs_set_default_settings(&settings);
  settings.verbose = 0;
  settings.eps_abs = settings.eps_rel = call->tol;
  settings.max_iters = call->max_iter;
  settings.time_limit_secs = isfinite(call->max_seconds) ? call->max_seconds : 0.0; /* 0: none */
  const scs_int status = scs(&data, &cone, &settings, &solution, &info);
  for (int i = 0; i < n; i++) {
    z[i] = x[i];
  }
  result->iterations = info.iter;
  result->factorizations = 1 + info.scale_updates;
  return outcome(status, &info, call);
}

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "scs",
    .title = "SCS",
    .words = "Splits the homogeneous self-dual form of the quadratic programme, accelerated.",
    .when = "To compare with a solver of the field on symmetric problems at modest accuracy.",
    .sets = LCP_PLUGIN_ORTHANT | LCP_PLUGIN_BOX | LCP_PLUGIN_FREE,
    .storages = LCP_PLUGIN_CSC,
    .needs = LCP_PLUGIN_SYMMETRIC,
    .max_iter = 200000,
    .workspace = workspace,
    .solve = solve,
};
