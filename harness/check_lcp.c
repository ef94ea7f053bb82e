#include "harness/case_lcp.h"
#include "harness/check_run.h"

#include <stdlib.h>
#include <string.h>

typedef struct lcp_unit {
  const case_lcp *c;
  const solver_choice *solver;
  check_outcome blank;
} lcp_unit;

static void emit(isolate_channel *out, const lcp_unit *u, const char *check, check_verdict verdict,
                 const char *reason) {
  check_outcome o = u->blank;
  o.verdict = verdict;
  (void)snprintf(o.check, sizeof o.check, "%s", check);
  (void)snprintf(o.reason, sizeof o.reason, "%.190s", reason);
  (void)isolate_emit(out, &o);
}

static void emit_number(isolate_channel *out, const lcp_unit *u, const char *check, double got,
                        double tolerance) {
  check_outcome o = u->blank;
  (void)snprintf(o.check, sizeof o.check, "%s", check);
  o.got = got;
  o.expected = 0.0;
  o.tolerance = tolerance;
  o.verdict = (got <= tolerance) ? CHECK_PASSED : CHECK_FAILED;
  (void)isolate_emit(out, &o);
}

/* A claim of success: residual by the judge, then what the case knows of the answer. */
static void judge_solved(isolate_channel *out, const lcp_unit *u, const solve_record *r,
                         const double *z) {
  const lcp_solver *s = u->solver->solver;
  double error;
  double tolerance;
  const char *rule;
  emit_number(out, u, "rho", r->verdict.rho, verdict_tolerance(s));
  if (case_lcp_forward(u->c, s, z, &error, &tolerance, &rule)) {
    emit_number(out, u, rule, error, tolerance);
  }
}

static void judge_word(isolate_channel *out, const lcp_unit *u, const solve_record *r,
                       const double *z) {
  const case_word word = case_lcp_word(u->c, r);
  char text[160];
  (void)snprintf(text, sizeof text, "claimed %s", case_word_name(word));
  if (case_lcp_lists(u->c, "status_false_claim", word)) {
    emit(out, u, "status", CHECK_FAILED, text);
  } else if (word == CASE_INFEASIBLE && !r->certificate_holds) {
    emit(out, u, "status", CHECK_FAILED, "claimed infeasible without a proof that holds");
  } else if (case_lcp_lists(u->c, "status_correct", word)) {
    emit(out, u, "status", CHECK_PASSED, text);
  } else if (word == CASE_NOT_APPLICABLE) {
    emit(out, u, "status", CHECK_SKIPPED, r->note);
  } else if (case_lcp_lists(u->c, "status_honest_failure", word)) {
    (void)snprintf(text, sizeof text, "honest failure: %s, rho=%.3g", case_word_name(word),
                   r->verdict.rho);
    emit(out, u, "status", CHECK_SKIPPED, text);
  } else {
    emit(out, u, "status", CHECK_FAILED, text);
  }
  if (word == CASE_SOLVED) {
    judge_solved(out, u, r, z);
  }
}

static void run_unit(void *ctx, isolate_channel *out) {
  const lcp_unit *u = ctx;
  solve_record r = {.status = RUN_ERROR};
  if (!u->c->valid) {
    judge_word(out, u, &r, NULL);
    return;
  }
  base_error err = {0};
  double *z = calloc((size_t)u->c->p.M.n + 1, sizeof *z);
  if (z == NULL) {
    emit(out, u, "run", CHECK_FAILED, "no memory for the answer");
  } else if (solve_once(&u->c->p, u->solver, z, &r, &err) != BASE_OK) {
    emit(out, u, "run", CHECK_FAILED, err.text);
  } else {
    judge_word(out, u, &r, z);
  }
  free(z);
}

base_status check_lcp_case(const check_plan *plan, const json_t *json, base_error *err) {
  case_lcp c;
  base_error why = {0};
  const base_status read = case_lcp_read(json, &c, &why);
  if (read == BASE_EUNSUPPORTED) {
    const char *id = json_string_value(json_object_get(json, "id"));
    check_skip(plan, id != NULL ? id : "?", why.text);
    return BASE_OK;
  }
  if (read != BASE_OK) {
    *err = why;
    return read;
  }
  base_status done = BASE_OK;
  for (int i = 0; done == BASE_OK && i < plan->n_solver && isolate_stop_requested() == 0; i++) {
    lcp_unit u = {&c, &plan->solver[i], {.check = "run"}};
    u.blank.got = u.blank.expected = u.blank.tolerance = (double)NAN;
    (void)snprintf(u.blank.id, sizeof u.blank.id, "%s", c.id);
    (void)snprintf(u.blank.solver, sizeof u.blank.solver, "%s", plan->solver[i].solver->name);
    done = check_isolated(plan, &u.blank, run_unit, &u, err);
  }
  case_lcp_free(&c);
  return done;
}
