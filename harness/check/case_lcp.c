#include "harness/check/case_lcp.h"

#include "lcp/lcp_certificate.h"
#include "lcp/lcp_judge.h"

#include <stdio.h>

case_status case_lcp_word(const solve_record *r) {
  if (r->status == RUN_UNSUPPORTED || !r->has_claim) {
    return CASE_NOT_APPLICABLE;
  }
  switch (r->claim.outcome) {
  case LCP_SOLVED:
    return CASE_SOLVED;
  case LCP_INFEASIBLE:
    return CASE_INFEASIBLE;
  case LCP_RAY:
    return CASE_UNSOLVED_RAY;
  case LCP_BUDGET:
  case LCP_MAX_ITER:
  case LCP_TIME_LIMIT:
  case LCP_STALLED:
    return CASE_NOT_CONVERGED;
  default:
    return CASE_NUMERICAL_FAILURE;
  }
}

const char *case_lcp_name(case_status word) {
  for (int bit = 0; bit < CASE_STATUS_COUNT; bit++) {
    if ((unsigned)word == 1u << bit) {
      return case_status_name(bit);
    }
  }
  return "unknown";
}

/* max |z - z*| / max |z*| */
static double distance(const double *want, const double *z, int n) {
  double error = 0.0;
  double size = 0.0;
  for (int i = 0; i < n; i++) {
    error = fmax(error, fabs(z[i] - want[i]));
    size = fmax(size, fabs(want[i]));
  }
  return (size > 0.0) ? error / size : error;
}

/* max over rows of |C z - c| / (|c| + max|C| max|z|): an impulse of 1e-12 beside others of one is zero */
static double invariant_error(const case_invariants *set, const double *z, int n) {
  double worst = 0.0;
  double size = 0.0;
  for (int i = 0; i < n; i++) {
    size = fmax(size, fabs(z[i]));
  }
  for (int r = 0; r < set->n_row; r++) {
    double sum = -set->c[r];
    double top = 0.0;
    for (int i = 0; i < n; i++) {
      const double entry = set->C[(size_t)r * (size_t)n + (size_t)i];
      sum += entry * z[i];
      top = fmax(top, fabs(entry));
    }
    const double scale = fabs(set->c[r]) + top * size;
    worst = fmax(worst, scale > 0.0 ? fabs(sum) / scale : 0.0);
  }
  return worst;
}

bool case_lcp_forward(const lcp_case *c, const lcp_solver *s, const double *z, double *error,
                      double *tolerance, const char **rule) {
  const int n = c->k.p.M.n;
  *error = HUGE_VAL;
  if (c->forward_tol > 0.0) {
    *rule = "forward_tol";
    *tolerance = c->forward_tol;
    for (int i = 0; i < c->n_solution; i++) {
      *error = fmin(*error, distance(c->solution + (size_t)i * (size_t)n, z, n));
    }
    return true;
  }
  /* No more than is asked of the residual: sums and moments, unlike single impulses, are determined by
   * w, and in these cases their coefficients and those of M are of one size. */
  *tolerance = verdict_tolerance(s);
  if (c->invariants.n_row > 0) {
    *rule = "invariants";
    *error = invariant_error(&c->invariants, z, n);
    return true;
  }
  *rule = "solution_sets";
  for (int i = 0; i < c->n_set; i++) {
    *error = fmin(*error, invariant_error(&c->set[i], z, n));
  }
  return c->n_set > 0;
}

static base_status check_answer(const lcp_case *c, const char *what, const double *z,
                                base_error *err) {
  lcp_verdict v;
  BASE_TRY(lcp_judge(&c->k.p, z, &v, err));
  return (v.rho <= LCP_VERIFY_EXACT && lcp_judged_small(&v, LCP_VERIFY_EXACT))
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL, "%s does not solve the problem: rho=%.3g", what, v.rho);
}

base_status case_lcp_holds(const lcp_case *c, base_error *err) {
  const size_t n = (size_t)c->n;
  for (int i = 0; i < c->n_solution; i++) {
    char what[32];
    (void)snprintf(what, sizeof what, "solution %d", i + 1);
    BASE_TRY(check_answer(c, what, c->solution + (size_t)i * n, err));
  }
  if (c->example != NULL) {
    BASE_TRY(check_answer(c, "example_solution", c->example, err));
  }
  if (c->k.farkas == NULL) {
    return BASE_OK;
  }
  const lcp_certificate proof = {.kind = LCP_CERT_FARKAS, .vector = c->k.farkas};
  lcp_certificate_verdict v;
  BASE_TRY(lcp_certificate_verify(&c->k.p, &proof, NULL, &v, err));
  return v.holds ? BASE_OK : BASE_FAIL(err, BASE_EINVAL, "farkas_y proves nothing");
}
