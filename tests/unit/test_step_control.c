/* Checkpoints bring back every bit; the control of the step is of first order; impacts are located. */
#include "tests/support/check.h"

#include "harness/control/checkpoint.h"
#include "harness/control/error_run.h"
#include "harness/control/simulation.h"
#include "harness/measure/predictions.h"

#include <string.h>

static simulation *opened(const char *scene, const char *form, const char *solver, bool warm) {
  simulation *s = calloc(1, sizeof *s);
  base_error err = {0};
  const simulation_texts t = {
      .scene = scene, .formulation = form, .solver = solver, .start = warm ? "previous" : "cold"};
  check_ok(simulation_open(&t, s, &err), &err);
  return s;
}

static void closed(simulation *s) {
  simulation_close(s);
  free(s);
}

/* ---- checkpoints ------------------------------------------------------------------------------*/

static void steps(sim *s, series *record, int n, double h) {
  base_error err = {0};
  for (int i = 0; i < n; i++) {
    bool taken;
    check_ok(sim_step(s, record, h, &taken, &err), &err);
    assert_true(taken);
  }
}

/* The same steps before and after a detour have the same bits. */
static void comes_back(const char *scene, const char *form, const char *solver, bool warm) {
  simulation *k = opened(scene, form, solver, warm);
  sim s;
  series record;
  sim_result out;
  checkpoint c;
  base_error err = {0};
  const double h = k->request.h;
  check_ok(sim_open(&s, &k->request, &record, &out, &err), &err);
  check_ok(checkpoint_open(&c, &s, &err), &err);
  const size_t n = world_saved_size(s.w);
  double *there = calloc(2 * n, sizeof *there), *again = there + n;
  steps(&s, &record, 12, h);
  check_ok(checkpoint_take(&c, &s, &record, &err), &err);
  const uint64_t before = out.hash;
  steps(&s, &record, 5, h);
  world_save(s.w, there);
  const uint64_t hash = out.hash;
  assert_true(hash != before);
  check_ok(checkpoint_return(&c, &s, &record, &err), &err);
  assert_int_equal(record.n_row, 13);
  steps(&s, &record, 3, 2.7 * h);
  check_ok(checkpoint_return(&c, &s, &record, &err), &err);
  steps(&s, &record, 5, h);
  world_save(s.w, again);
  if (hash != out.hash || memcmp(there, again, n * sizeof *there) != 0) {
    fail_msg("%s, %s, %s: another motion from the same state", scene, form, warm ? "warm" : "cold");
  }
  assert_int_equal(record.n_row, 18);
  assert_int_equal(out.steps, 17);
  free(there);
  checkpoint_close(&c);
  series_close(&record);
  sim_close(&s);
  closed(k);
}

static void checkpoints_bring_back_every_bit(void **state) {
  (void)state;
  static const struct {
    const char *form, *solver;
  } all[] = {{"velocity", "lemke"},
             {"velocity:restitution=poisson", "lemke"},
             {"position", "lemke"},
             {"boxed", "pgs"},
             {"coulomb", "nsgs"},
             {"acceleration", "lemke"},
             {"regularized", "lemke"},
             {"regularized:model=viscous", "lemke"},
             {"regularized:form=mass", "lemke"}};
  static const char *const scenes[] = {"slide", "stack:n=3", "tip", "roll"};
  for (int f = 0; f < BASE_COUNT(all); f++) {
    for (int i = 0; i < BASE_COUNT(scenes); i++) {
      comes_back(scenes[i], all[f].form, all[f].solver, false);
      comes_back(scenes[i], all[f].form, all[f].solver, true);
    }
  }
}

static void who_remembers_more_cannot_come_back(void **state) {
  (void)state;
  static const char *const all[] = {"event", "penalty"};
  for (int i = 0; i < BASE_COUNT(all); i++) {
    simulation *k = opened("slide", all[i], "lemke", false);
    sim s;
    series record;
    sim_result out;
    checkpoint c;
    base_error err = {0};
    check_ok(sim_open(&s, &k->request, &record, &out, &err), &err);
    check_ok(checkpoint_open(&c, &s, &err), &err);
    assert_int_equal(checkpoint_take(&c, &s, &record, &err), BASE_EUNSUPPORTED);
    checkpoint_close(&c);
    series_close(&record);
    sim_close(&s);
    closed(k);
  }
}

/* ---- control ----------------------------------------------------------------------------------*/

typedef struct outcome {
  double error; /* of the reference quantity */
  step_account account;
} outcome;

static outcome controlled(const char *scene, double tolerance) {
  simulation *k = opened(scene, "coulomb", "nsgs", false);
  series record;
  sim_result out;
  step_list kept = {0};
  run_places places = {0};
  outcome o;
  base_error err = {0};
  prediction_summary p;
  const double end = k->request.duration;
  const step_rule rule = {.tolerance = tolerance,
                          .first = 0.1 * end,
                          .least = 1e-9 * end,
                          .most = end,
                          .stop = &end,
                          .n_stop = 1,
                          .limit = 1000000};
  check_ok(simulate_controlled(&k->request, &rule, &record, &out, &kept, &places, &o.account, &err),
           &err);
  assert_true(o.account.ended && out.status == RUN_OK && out.steps == kept.n);
  double sum = 0.0;
  for (long i = 0; i < kept.n; i++) {
    sum += kept.h[i];
  }
  assert_true(fabs(sum - end) <= 1e-9 * end);
  predictions_summarise(&k->request, &record, &out, &p);
  assert_true(p.has_ref);
  o.error = p.error;
  step_list_close(&kept);
  run_places_close(&places);
  series_close(&record);
  closed(k);
  return o;
}

/* x = v t + a t^2 / 2 down a slope: a quarter of the tolerance gives a quarter of the error in four times the steps. */
static void smooth_motion_is_of_first_order(void **state) {
  (void)state;
  outcome last = {0};
  for (int i = 0; i < 4; i++) {
    const double tolerance = 1e-2 * pow(0.25, i);
    const outcome o = controlled("slide", tolerance);
    assert_true(o.error <= tolerance && o.error > 0.05 * tolerance);
    assert_int_equal(o.account.forced, 0);
    if (i > 0) {
      const double ratio = last.error / o.error;
      assert_true(ratio > 3.0 && ratio < 5.5);
      const double longer = (double)o.account.solved / (double)last.account.solved;
      assert_true(longer > 2.5 && longer < 5.0);
    }
    last = o;
  }
}

/* A ball that bounces: short steps at the impacts, long ones between. */
static void impacts_are_located(void **state) {
  (void)state;
  double before = HUGE_VAL;
  for (int i = 0; i < 3; i++) {
    const double tolerance = 3e-2 * pow(0.1, i);
    const outcome o = controlled("bounce", tolerance);
    assert_int_equal(o.account.forced, 0);
    assert_true(o.account.rejected > 0 && o.account.most > 20.0 * o.account.least);
    assert_true(o.account.least < tolerance); /* dv is some m/s */
    assert_true(o.account.located > 0.0 && o.account.located <= tolerance / 16.0);
    assert_true(o.error < tolerance && o.error < before);
    before = o.error;
  }
}

/* ---- what is asked ----------------------------------------------------------------------------*/

static void what_is_asked_has_a_unit_or_a_scale(void **state) {
  (void)state;
  static const struct {
    const char *text, *unit;
    double E;
  } good[] = {{"1%", "", 0.01},      {"2.5 %", "", 0.025},  {"0.01", "", 0.01},
              {"1e-3m", "m", 1e-3},  {"1e-3 m", "m", 1e-3}, {"0.2rad", "rad", 0.2},
              {"5.m/s", "m/s", 5.0}, {"1e2J", "J", 100.0},  {"3rad/s", "rad/s", 3.0}};
  static const char *const bad[] = {"",    "m",    "%",   "0",   "-1",    "0%",
                                    "1km", "1 %%", "nan", "inf", "1e999", "1,5"};
  error_asked a;
  base_error err = {0};
  for (int i = 0; i < BASE_COUNT(good); i++) {
    check_ok(error_parse(good[i].text, &a, &err), &err);
    assert_true(fabs(a.E - good[i].E) <= 1e-15 * good[i].E);
    assert_string_equal(a.unit, good[i].unit);
  }
  for (int i = 0; i < BASE_COUNT(bad); i++) {
    if (error_parse(bad[i], &a, &err) != BASE_EINVAL) {
      fail_msg("'%s' was taken", bad[i]);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(checkpoints_bring_back_every_bit),
      cmocka_unit_test(who_remembers_more_cannot_come_back),
      cmocka_unit_test(smooth_motion_is_of_first_order),
      cmocka_unit_test(impacts_are_located),
      cmocka_unit_test(what_is_asked_has_a_unit_or_a_scale),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
