#include "harness/measure/verdict.h"

#include "lcp/lcp_certificate.h"

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

static run_status word_of_claim(lcp_outcome o) {
  switch (o) {
  case LCP_SOLVED:
    return RUN_OK;
  case LCP_MAX_ITER:
    return RUN_MAX_ITER;
  case LCP_BUDGET:
    return RUN_BUDGET;
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

/* No memory for the check: not proved. */
static bool proved_infeasible(const lcp_problem *p, const lcp_certificate *c) {
  lcp_certificate_verdict v;
  return c->kind == LCP_CERT_FARKAS && lcp_certificate_verify(p, c, NULL, &v, NULL) == BASE_OK &&
         v.holds;
}

run_status verdict_of(const lcp_solver *s, const void *opt, const lcp_problem *p,
                      const lcp_result *claim, const lcp_verdict *v, bool *verified) {
  const double tol = fmax(verdict_tolerance(s), verdict_asked(s, opt));
  const bool small = lcp_judged_small(v, tol);
  *verified =
      v->finite && v->rho <= verdict_tolerance(s) && lcp_judged_small(v, verdict_tolerance(s));
  const run_status word = word_of_claim(claim->outcome);
  if (word == RUN_INFEASIBLE) {
    return proved_infeasible(p, &claim->certificate) ? RUN_INFEASIBLE : RUN_UNVERIFIED;
  }
  if (word == RUN_RAY || word == RUN_NUMERICAL) {
    return word;
  }
  if (!v->finite) {
    return RUN_NUMERICAL;
  }
  if (word == RUN_OK && v->rho <= tol && small) {
    return RUN_OK;
  }
  if (v->rho > tol && v->rho < 10 * tol) {
    return RUN_NEAR;
  }
  return (word == RUN_OK) ? RUN_UNVERIFIED : word;
}
