#include "harness/cli/solve_sequence.h"

#include "harness/measure/solve_once.h"
#include "harness/util/json_out.h"

static void put_problem(json_t *o, const char *problem, const sequence *q) {
  json_out_text(o, "problem", problem);
  json_out_text(o, "scene", q->scene);
  json_out_text(o, "formulation", q->formulation);
  json_out_text(o, "posed_by", q->solver);
  json_out_real(o, "step_s", q->h);
  json_out_int(o, "steps", q->steps);
  json_out_int(o, "n_problems", q->n);
  json_out_int(o, "n_max", sequence_largest(q));
  json_out_real(o, "active_change", sequence_change(q));
}

/* null: not counted. */
static void put_count(json_t *o, const char *key, long n) {
  if (n != SEQUENCE_UNCOUNTED) {
    json_out_int(o, key, n);
  } else {
    json_out_text(o, key, NULL);
  }
}

static json_t *to_json(const char *problem, const sequence_request *q, const sequence_result *r,
                       const sequence_regressions *dearer) {
  json_t *o = json_object();
  const bool solved = r->n > 0;
  char hash[24];
  (void)snprintf(hash, sizeof hash, "%016llx", (unsigned long long)r->hash);
  put_problem(o, problem, q->sequence);
  json_out_text(o, "solver", q->solver->solver->name);
  json_out_text(o, "options", q->solver->config);
  json_out_text(o, "start", sequence_start_name(q->start));
  json_out_text(o, "status", run_status_name(r->status));
  json_out_bool(o, "verified", r->verified && r->status == RUN_OK);
  json_out_text(o, "note", r->note);
  json_out_int(o, "n_solves", r->n);
  json_out_int(o, "n_unsolved", r->n_unsolved);
  json_out_real(o, "rho", solved ? r->worst.rho : HUGE_VAL);
  json_out_int(o, "n_iter", r->work.iterations);
  json_out_int(o, "n_pivot", r->work.pivots);
  json_out_int(o, "n_factor", r->work.factorizations);
  json_out_int(o, "n_matvec", r->work.matvecs);
  json_out_int(o, "n_fallback", r->work.fallbacks);
  if (dearer != NULL) {
    put_count(o, "regressions", dearer->work);
    put_count(o, "regressions_time", dearer->time);
  }
  json_out_real(o, "t_setup_s", r->time.setup);
  json_out_real(o, "t_factor_s", r->time.factor);
  json_out_real(o, "t_solve_s", r->time.solve);
  json_out_text(o, "solution_hash", r->status != RUN_UNSUPPORTED ? hash : NULL);
  return o;
}

base_status solve_sequence(const char *problem, const solver_choice *solver, const char *start,
                           json_t **report, bool *good, base_error *err) {
  sequence all;
  sequence_result r;
  sequence_regressions dearer;
  sequence_request q = {.sequence = &all, .solver = solver};
  *report = NULL;
  BASE_TRY(sequence_start_find(start, &q.start, err));
  base_status done = sequence_open(problem, &all, err);
  if (done == BASE_OK) {
    done = sequence_solve(&q, &r, NULL, err);
  }
  const bool compared = done == BASE_OK && q.start != SEQUENCE_COLD;
  if (compared) {
    done = sequence_compare(&q, HUGE_VAL, &dearer, err);
  }
  if (done == BASE_OK) {
    *report = to_json(problem, &q, &r, compared ? &dearer : NULL);
    *good = r.status == RUN_OK && r.verified;
  }
  sequence_free(&all);
  return done;
}
