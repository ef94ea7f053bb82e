/* highs.c - HiGHS: its active set method for convex quadratic programmes. tol becomes the feasibility
 * tolerances of both sides, at least 1e-10, the least that the library takes. What it adds to the
 * diagonal of M (1e-7 by its own default) bounds rho from below in proportion, so it follows tol. */
#include "qp.h"

/* The functions of interfaces/highs_c_api.h that are called: the packages of the library for Python
 * hold the library, not its header. */
void *Highs_create(void);
void Highs_destroy(void *highs);
int Highs_setBoolOptionValue(void *highs, const char *option, int value);
int Highs_setIntOptionValue(void *highs, const char *option, int value);
int Highs_setDoubleOptionValue(void *highs, const char *option, double value);
int Highs_getIntInfoValue(const void *highs, const char *info, int *value);
int Highs_passModel(void *highs, int n_col, int n_row, int a_nnz, int q_nnz, int a_format,
                    int q_format, int sense, double offset, const double *cost, const double *lower,
                    const double *upper, const double *row_lower, const double *row_upper,
                    const int *a_start, const int *a_index, const double *a_value,
                    const int *q_start, const int *q_index, const double *q_value,
                    const int *integrality);
int Highs_run(void *highs);
int Highs_getModelStatus(const void *highs);
int Highs_getSolution(const void *highs, double *col, double *col_dual, double *row, double *dual);

enum { BY_COLUMNS = 1, TRIANGLE = 1, MINIMISE = 1 };
enum { STATUS_SOLVE_ERROR = 4, STATUS_OPTIMAL = 7, STATUS_TIME = 13, STATUS_ITERATIONS = 14 };

static size_t workspace(int n, size_t entries, int n_block, const double *option) {
  (void)n_block, (void)option;
  return qp_bytes(n, entries, 3 * (size_t)n) + ((size_t)n + 1) * sizeof(int);
}

static int outcome(int status) {
  switch (status) {
  case STATUS_OPTIMAL:
    return LCP_PLUGIN_SOLVED;
  case STATUS_TIME:
    return LCP_PLUGIN_TIME_LIMIT;
  case STATUS_ITERATIONS:
    return LCP_PLUGIN_MAX_ITER;
  case STATUS_SOLVE_ERROR:
    return LCP_PLUGIN_NUMERICAL;
  default: /* "unbounded" is no proof that the host could check */
    return LCP_PLUGIN_STALLED;
  }
}

static void set_options(void *highs, const lcp_plugin_call *call) {
  const double tol = fmax(call->tol, 1e-10);
  (void)Highs_setBoolOptionValue(highs, "output_flag", 0);
  (void)Highs_setIntOptionValue(highs, "threads", 1);
  (void)Highs_setIntOptionValue(highs, "qp_iteration_limit", call->max_iter);
  (void)Highs_setDoubleOptionValue(highs, "primal_feasibility_tolerance", tol);
  (void)Highs_setDoubleOptionValue(highs, "dual_feasibility_tolerance", tol);
  (void)Highs_setDoubleOptionValue(highs, "qp_regularization_value", call->option[0] * call->tol);
  (void)Highs_setDoubleOptionValue(highs, "time_limit", call->max_seconds);
}

static int solve(void *work, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
                 lcp_plugin_result *result) {
  const int n = p->n;
  const qp_triangle t = qp_take(work, p, QP_LOWER, 3 * (size_t)n);
  int *empty = t.colptr + n + 1;
  const int none = 0;
  const double nothing = 0.0;
  void *highs = Highs_create();
  if (highs == NULL) {
    return LCP_PLUGIN_NO_MEMORY;
  }
  for (int i = 0; i <= n; i++) {
    empty[i] = 0;
  }
  set_options(highs, call);
  int status = STATUS_SOLVE_ERROR;
  int count = 0;
  if (Highs_passModel(highs, n, 0, 0, t.colptr[n], BY_COLUMNS, TRIANGLE, MINIMISE, 0.0, p->q, p->lo,
                      p->hi, NULL, NULL, empty, &none, &nothing, t.colptr, t.rowind, t.val,
                      NULL) >= 0 &&
      Highs_run(highs) >= 0) {
    status = Highs_getModelStatus(highs);
  }
  (void)Highs_getSolution(highs, z, t.real, t.real + n, t.real + 2 * (size_t)n);
  (void)Highs_getIntInfoValue(highs, "qp_iteration_count", &count);
  result->iterations = count;
  Highs_destroy(highs);
  return outcome(status);
}

static const lcp_plugin_option options[] = {
    {"regularization", "1", "real", 0.01, 0, 1e6, NULL,
     "what the library adds to the diagonal of M, over tol"},
};

const lcp_plugin lcp_plugin_descriptor = {
    .abi = LCP_PLUGIN_ABI,
    .size = sizeof(lcp_plugin),
    .name = "highs",
    .title = "HiGHS",
    .words = "Moves along an active set in its null space.",
    .when = "To compare with a solver of the field on symmetric problems.",
    .sets = LCP_PLUGIN_ORTHANT | LCP_PLUGIN_BOX | LCP_PLUGIN_FREE,
    .storages = LCP_PLUGIN_CSC,
    .needs = LCP_PLUGIN_SYMMETRIC,
    .max_iter = 100000,
    .options = options,
    .n_option = 1,
    .workspace = workspace,
    .solve = solve,
};
