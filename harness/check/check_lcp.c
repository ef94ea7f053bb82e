#include "harness/check/case_lcp.h"
#include "harness/check/check_run.h"
#include "harness/util/stop.h"

#include <stdlib.h>
#include <string.h>

typedef struct lcp_unit {
  const lcp_case *c;
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

static void judge_word(isolate_channel *out, const lcp_unit *u, case_status word,
                       const solve_record *r, const char *note) {
  const lcp_case *c = u->c;
  char text[300];
  (void)snprintf(text, sizeof text, "claimed %s%s%s", case_lcp_name(word), note[0] ? ": " : "",
                 note);
  const bool unproved = word == CASE_INFEASIBLE && !r->certificate.holds;
  check_verdict verdict = CHECK_FAILED; /* also for a word in none of the case's lists */
  if ((c->false_claim & word) == 0 && !unproved) {
    if (word == CASE_NOT_APPLICABLE) {
      verdict = CHECK_SKIPPED;
    } else if ((c->correct & word) != 0) {
      verdict = CHECK_PASSED;
    } else if ((c->honest_failure & word) != 0) {
      verdict = CHECK_SKIPPED;
      (void)snprintf(text, sizeof text, "honest failure: %s, rho=%.3g", case_lcp_name(word),
                     r->verdict.rho);
    }
  }
  emit(out, u, "status", verdict, unproved ? "claimed infeasible, but no proof holds" : text);
}

/* Data that are no problem must be refused before any solver sees them. */
static bool refused(const lcp_case *c, base_error *why) {
  if (c->shape_error[0] != '\0') {
    (void)BASE_FAIL(why, BASE_EINVAL, "%s", c->shape_error);
    return true;
  }
  return lcp_problem_check(&c->k.p, why) != BASE_OK;
}

/* A forward tolerance asks more of the answer than a small residual does where the case is ill
 * conditioned: an iterative method then has to reach rounding, or to say that it did not. */
static base_status solve_unit(const lcp_unit *u, double *z, solve_record *r, base_error *err) {
  const lcp_solver *s = u->solver->solver;
  if (s->exact || !(u->c->forward_tol > 0.0)) {
    return solve_once(&u->c->k.p, u->solver, z, r, err);
  }
  solver_choice tight = *u->solver;
  tight.opt = malloc(s->options_size);
  if (tight.opt == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the options of %s", s->name);
  }
  memcpy(tight.opt, u->solver->opt, s->options_size);
  base_status done = solver_choice_set(&tight, "tol", "1e-15", err);
  if (done == BASE_OK) {
    done = solve_once(&u->c->k.p, &tight, z, r, err);
  }
  free(tight.opt);
  return done;
}

static void run_unit(void *ctx, isolate_channel *out) {
  const lcp_unit *u = ctx;
  solve_record r = {.status = RUN_ERROR};
  base_error err = {0};
  if (refused(u->c, &err)) {
    judge_word(out, u, CASE_INVALID_INPUT, &r, err.text);
    return;
  }
  double *z = calloc((size_t)u->c->k.p.M.n + 1, sizeof *z);
  if (z == NULL) {
    emit(out, u, "run", CHECK_FAILED, "no memory for the answer");
  } else if (solve_unit(u, z, &r, &err) != BASE_OK) {
    emit(out, u, "run", CHECK_FAILED, err.text);
  } else {
    const case_status word = case_lcp_word(&r);
    judge_word(out, u, word, &r, r.note);
    if (word == CASE_SOLVED) {
      judge_solved(out, u, &r, z);
    }
  }
  free(z);
}

base_status check_lcp_case(const check_plan *plan, const lcp_case *c, base_error *err) {
  base_error why = {0};
  if (!refused(c, &why) && case_lcp_holds(c, &why) != BASE_OK) {
    check_refuse(plan, c->id, why.text);
    return BASE_OK;
  }
  for (int i = 0; i < plan->n_solver && stop_requested() == 0; i++) {
    lcp_unit u = {c, &plan->solver[i], {.check = "run"}};
    u.blank.got = u.blank.expected = u.blank.tolerance = (double)NAN;
    (void)snprintf(u.blank.id, sizeof u.blank.id, "%s", c->id);
    (void)snprintf(u.blank.solver, sizeof u.blank.solver, "%s", plan->solver[i].solver->name);
    BASE_TRY(check_isolated(plan, &u.blank, run_unit, &u, err));
  }
  return BASE_OK;
}
