#include "harness/cli/calibrate.h"

#include "harness/measure/predictions.h"
#include "lcp/base/nlopt_library.h"

#include <math.h>
#include <string.h>

enum { FINAL_RUNS = 15 };
static const double hopeless = 20.0; /* log of seconds, above that of any run */

typedef struct search {
  calibrate_task *task;
  calibrate_result *out;
  base_error *err;
  base_status status;
} search;

base_status calibrate_set(calibrate_task *task, const double x[2], base_error *err) {
  for (int i = 0; i < 2; i++) {
    char text[40];
    (void)snprintf(text, sizeof text, "%.6g", x[i]);
    BASE_TRY(formulation_choice_set(task->form, task->name[i], text, err));
  }
  return BASE_OK;
}

/* One run at step h: its error (HUGE_VAL where a solve failed or nothing is predicted) and time. */
static base_status one_run(search *s, double h, double *error, double *seconds, base_error *err) {
  series record;
  sim_result r;
  sim_request q = s->task->request;
  q.h = h;
  base_status done = simulate(&q, &record, &r, err);
  if (done == BASE_OK && r.status == RUN_UNSUPPORTED) { /* no other parameter will change that */
    done = BASE_FAIL(err, BASE_EUNSUPPORTED, "calibrate: %.300s", r.note);
  }
  if (done == BASE_OK) {
    prediction_summary p;
    predictions_summarise(&q, &record, &r, &p);
    const bool physical = s->task->yardstick == CALIBRATE_PHYSICAL;
    const bool known = r.status == RUN_OK && (physical || p.has_ref);
    *error = !known ? HUGE_VAL : physical ? r.ncp_rel_max : p.error;
    *seconds = sim_total_seconds(&r);
    s->out->simulations++;
  }
  series_close(&record);
  return done;
}

/* Least of several runs at p->h; the parameters are set. */
static base_status time_point(search *s, calibrate_point *p, int runs, base_error *err) {
  p->seconds = HUGE_VAL;
  for (int k = 0; k < runs; k++) {
    double error;
    double seconds;
    BASE_TRY(one_run(s, p->h, &error, &seconds, err));
    p->seconds = fmin(p->seconds, seconds);
  }
  return BASE_OK;
}

static base_status evaluate(search *s, calibrate_point *p, base_error *err) {
  BASE_TRY(calibrate_set(s->task, p->x, err));
  p->reaches = false;
  p->error = HUGE_VAL;
  for (int k = 0; k < CALIBRATE_LADDER && !p->reaches; k++) {
    const double h = s->task->first * pow(2.0, -0.5 * k);
    double error;
    double seconds;
    BASE_TRY(one_run(s, h, &error, &seconds, err));
    p->error = fmin(p->error, error);
    if (error <= s->task->level) {
      p->reaches = true;
      p->error = error;
      p->h = h;
    }
  }
  return p->reaches ? time_point(s, p, CALIBRATE_RUNS, err) : BASE_OK;
}

static double cost_of(const search *s, const calibrate_point *p) {
  if (p->reaches) {
    return log(p->seconds);
  }
  return hopeless + (isfinite(p->error) ? log10(p->error / s->task->level) : hopeless);
}

// NOLINTNEXTLINE(readability-non-const-parameter): the signature of nlopt_func
static double objective(unsigned n, const double *y, double *gradient, void *ctx) {
  search *s = ctx;
  (void)n, (void)gradient;
  calibrate_point p = {.x = {pow(10.0, y[0]), pow(10.0, y[1])}};
  if (s->status == BASE_OK) {
    s->status = evaluate(s, &p, s->err);
  }
  s->out->evaluations++;
  if (s->status == BASE_OK && cost_of(s, &p) < cost_of(s, &s->out->best)) {
    s->out->best = p;
  }
  return (s->status == BASE_OK) ? cost_of(s, &p) : hopeless;
}

/* Within three decades of the rule of thumb, first steps of half a decade. */
static base_status minimise(search *s, const double x[2], base_error *err) {
  nlopt_library nlopt;
  BASE_TRY(nlopt_open(&nlopt, err));
  nlopt_opt opt = nlopt.nlopt_create(NLOPT_LN_SBPLX, 2);
  if (opt == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "calibrate: NLopt gave no optimiser");
  }
  double y[2] = {log10(x[0]), log10(x[1])};
  const double lo[2] = {y[0] - 3.0, y[1] - 2.0};
  const double hi[2] = {y[0] + 3.0, y[1] + 2.0};
  const double step[2] = {0.5, 0.5};
  (void)nlopt.nlopt_set_lower_bounds(opt, lo);
  (void)nlopt.nlopt_set_upper_bounds(opt, hi);
  (void)nlopt.nlopt_set_initial_step(opt, step);
  (void)nlopt.nlopt_set_maxeval(opt, s->task->evaluations);
  (void)nlopt.nlopt_set_xtol_rel(opt, 1e-2);
  (void)nlopt.nlopt_set_min_objective(opt, objective, s);
  double least;
  const nlopt_result word = nlopt.nlopt_optimize(opt, y, &least);
  nlopt.nlopt_destroy(opt);
  if (s->status != BASE_OK) {
    return s->status;
  }
  /* rounding in a noisy minimum ends the search, it does not spoil what was found */
  return (word > 0 || word == NLOPT_ROUNDOFF_LIMITED)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EEXTERNAL, "calibrate: NLopt ended with %d", (int)word);
}

/* The rule and the best in turns, so that a busy machine slows both. */
static base_status compare(search *s, base_error *err) {
  calibrate_result *r = s->out;
  calibrate_point a = r->rule;
  calibrate_point b = r->best;
  r->gain = (double)NAN;
  if (!r->rule.reaches || !r->best.reaches) {
    return BASE_OK;
  }
  r->rule.seconds = HUGE_VAL; /* the search kept its luckiest time of the best */
  r->best.seconds = HUGE_VAL;
  for (int k = 0; k < FINAL_RUNS; k++) {
    BASE_TRY(calibrate_set(s->task, a.x, err));
    BASE_TRY(time_point(s, &a, 1, err));
    r->rule.seconds = fmin(r->rule.seconds, a.seconds);
    BASE_TRY(calibrate_set(s->task, b.x, err));
    BASE_TRY(time_point(s, &b, 1, err));
    r->best.seconds = fmin(r->best.seconds, b.seconds);
  }
  r->gain = r->rule.seconds / r->best.seconds;
  return BASE_OK;
}

base_status calibrate(calibrate_task *task, const double x[2], calibrate_result *out,
                      base_error *err) {
  *out = (calibrate_result){.rule = {.x = {x[0], x[1]}}};
  search s = {.task = task, .out = out, .err = err, .status = BASE_OK};
  BASE_TRY(evaluate(&s, &out->rule, err));
  out->best = out->rule;
  BASE_TRY(minimise(&s, x, err));
  return compare(&s, err);
}
