#include "harness/measure/verdict.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#define NAME_(id, text) text,
static const char *const names[] = {RUN_STATUS_LIST(NAME_)};

const char *run_status_name(run_status s) {
  return ((unsigned)s < RUN_STATUS_COUNT) ? names[s] : "unknown";
}

bool run_status_find(const char *name, run_status *out) {
  for (int i = 0; i < RUN_STATUS_COUNT; i++) {
    if (strcmp(names[i], name) == 0) {
      *out = (run_status)i;
      return true;
    }
  }
  return false;
}

run_status run_status_worse(run_status a, run_status b) {
  return a > b ? a : b;
}

double verdict_tolerance(const lcp_solver *s) {
  return s->exact ? LCP_VERIFY_EXACT : LCP_VERIFY_ITERATIVE;
}

/* (M'y)_j <= 0 for every column, up to rounding. */
static bool columns_nonpositive(const lcp_csc *m, const double *y) {
  for (int j = 0; j < m->n_col; j++) {
    long double sum = 0;
    long double scale = 0;
    for (int k = m->colptr[j]; k < m->colptr[j + 1]; k++) {
      const long double term = (long double)m->val[k] * y[m->rowind[k]];
      sum += term;
      scale += (term < 0) ? -term : term;
    }
    if (sum > 64 * (long double)DBL_EPSILON * scale) {
      return false;
    }
  }
  return true;
}

bool verdict_farkas_holds(const lcp_problem *p, const double *y) {
  const int n = p->M.n;
  long double sum = 0;
  long double scale = 0;
  for (int i = 0; i < n; i++) {
    if (!(y[i] >= 0.0) || !isfinite(y[i])) {
      return false;
    }
    const long double term = (long double)p->q[i] * y[i];
    sum += term;
    scale += (term < 0) ? -term : term;
  }
  if (lcp_problem_sets(p) != 1u << LCP_ORTHANT || !(sum < -64 * (long double)DBL_EPSILON * scale)) {
    return false;
  }
  lcp_csc m;
  if (lcp_matrix_to_csc(&p->M, &m, NULL) != BASE_OK) {
    return false; /* no memory: not verified */
  }
  const bool holds = columns_nonpositive(&m, y);
  lcp_csc_free(&m);
  return holds;
}

static run_status word_of_claim(lcp_outcome o) {
  switch (o) {
  case LCP_SOLVED:
    return RUN_OK;
  case LCP_MAX_ITER:
    return RUN_MAX_ITER;
  case LCP_TIME_LIMIT:
    return RUN_TIME_LIMIT;
  case LCP_STALLED:
    return RUN_STALLED;
  case LCP_RAY:
    return RUN_RAY;
  case LCP_INFEASIBLE:
    return RUN_INFEASIBLE;
  case LCP_NUMERICAL:
  case LCP_OUTCOME_COUNT:
    break;
  }
  return RUN_NUMERICAL;
}

double verdict_asked(const lcp_solver *s, const void *opt) {
  for (int i = 0; i < s->n_fields; i++) {
    const base_field *f = &s->fields[i];
    if (strcmp(f->name, "tol") == 0 && f->kind == BASE_REAL) {
      double tol;
      memcpy(&tol, (const unsigned char *)opt + f->offset, sizeof tol);
      return tol;
    }
  }
  return 0.0;
}

run_status verdict_of(const lcp_solver *s, const void *opt, const lcp_problem *p,
                      const lcp_result *claim, const lcp_verdict *v, bool *verified) {
  const double tol = fmax(verdict_tolerance(s), verdict_asked(s, opt));
  *verified = v->finite && v->rho <= verdict_tolerance(s);
  const run_status word = word_of_claim(claim->outcome);
  if (word == RUN_INFEASIBLE) {
    const lcp_certificate *c = &claim->certificate;
    const bool proved = c->kind == LCP_CERT_FARKAS && verdict_farkas_holds(p, c->vector);
    return proved ? RUN_INFEASIBLE : RUN_UNVERIFIED;
  }
  if (word == RUN_RAY || word == RUN_NUMERICAL) {
    return word;
  }
  if (!v->finite) {
    return RUN_NUMERICAL;
  }
  if (word == RUN_OK && v->rho <= tol) {
    return RUN_OK;
  }
  if (v->rho > tol && v->rho < 10 * tol) {
    return RUN_NEAR;
  }
  return (word == RUN_OK) ? RUN_UNVERIFIED : word;
}
