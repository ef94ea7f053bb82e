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

static outcome controlled_with(const char *solver, const char *scene, double duration,
                               step_rule rule) {
  simulation *k = opened(scene, "coulomb", solver, false);
  series record;
  sim_result out;
  step_list kept = {0};
  run_places places = {0};
  outcome o;
  base_error err = {0};
  prediction_summary p;
  k->request.duration = (duration > 0.0) ? duration : k->request.duration;
  const double end = k->request.duration;
  rule.first *= end;
  rule.most *= end;
  rule.least = 1e-9 * end;
  rule.stop = &end;
  rule.n_stop = 1;
  rule.limit = 1000000;
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

static outcome controlled_by(const char *scene, double duration, step_rule rule) {
  return controlled_with("nsgs", scene, duration, rule);
}

/* Plain steps of this tolerance [m]. */
static outcome controlled(const char *scene, double tolerance) {
  return controlled_by(scene, 0.0, (step_rule){.tolerance = tolerance, .first = 0.1, .most = 1.0});
}

/* Extrapolated steps of at most this share of the run, whatever they are off by. */
static outcome extrapolated(const char *scene, double share) {
  return controlled_by(
      scene, 0.0,
      (step_rule){.tolerance = 1e3, .first = share, .most = share, .extrapolate = true});
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
    const double lever =
        10.0; /* the way behind an impact over the size of the ball, which counts */
    const outcome o = controlled("bounce", tolerance);
    assert_int_equal(o.account.forced, 0);
    assert_true(o.account.rejected > 0 && o.account.most > 20.0 * o.account.least);
    assert_true(o.account.least < tolerance); /* dv is some m/s */
    assert_true(o.account.located > 0.0 && o.account.located <= lever * tolerance / 16.0);
    assert_true(o.error < tolerance && o.error < before);
    before = o.error;
  }
}

/* A constant acceleration is what one step and two halves agree on; other smooth motion is of second order. */
static void extrapolated_steps_are_of_second_order(void **state) {
  (void)state;
  const outcome slope = extrapolated("incline:theta_deg=40", 0.5);
  assert_true(slope.error < 1e-12 && slope.account.solved == 6 && slope.account.off < 1e-11);
  static const char *const smooth[] = {"oscillator:mu=1e-6", "top"}; /* a spring; a turning body */
  for (int k = 0; k < BASE_COUNT(smooth); k++) {
    outcome last = {0};
    for (int i = 0; i < 4; i++) {
      const outcome o = extrapolated(smooth[k], 1.0 / (64 << i));
      const double ratio = last.error / o.error;
      assert_true(i == 0 || (ratio > 3.0 && ratio < 5.5));
      assert_true(i == 0 || last.account.off > 3.0 * o.account.off);
      last = o;
    }
  }
}

/* What stops in the first half of a step does so on both of its ways: only the acceleration before tells. */
static void what_ends_inside_a_half_is_seen(void **state) {
  (void)state;
  const outcome o =
      controlled_by("slide:speed=1", 4.0,
                    (step_rule){.tolerance = 1e-3, .first = 0.5, .most = 0.5, .extrapolate = true});
  assert_true(o.account.rejected > 0 && o.error < 2e-3);
}

/* A coin that rolls on its edge: the direction of what its contact holds turns. The steps are of second order all the same: a
 * sixteenth of the tolerance takes about four times as many, not sixteen times. */
static void what_holds_is_of_second_order(void **state) {
  (void)state;
  long before = 0;
  for (int i = 0; i < 3; i++) {
    const outcome o = controlled_by("euler_disc", 0.0,
                                    (step_rule){.tolerance = 1e-3 * pow(1.0 / 16.0, i),
                                                .first = 0.01,
                                                .most = 0.5,
                                                .extrapolate = true});
    assert_int_equal(o.account.forced, 0);
    assert_true(i == 0 || o.account.solved < 6 * before);
    before = o.account.solved;
  }
}

/* Behind an impact the steps are as long as before. */
static void impacts_cost_their_location(void **state) {
  (void)state;
  const outcome o = controlled_by(
      "bounce", 0.0,
      (step_rule){.tolerance = 1e-3, .first = 0.05, .most = 0.05, .extrapolate = true});
  const outcome plain = controlled("bounce", 1e-3);
  assert_int_equal(o.account.forced, 0);
  assert_true(o.account.located <= 1e-3 / 16.0 && o.account.located > 0.0);
  assert_true(o.account.solved < plain.account.solved / 10 &&
              o.account.most > 1e2 * o.account.least);
}

/* A fall is met where it ends: one trial sees that, the next step ends just behind, another goes over it. So the work does not
 * grow with the accuracy, as it would by halving. */
static void an_impact_is_foreseen(void **state) {
  (void)state;
  for (double tolerance = 1e-2; tolerance > 1e-8; tolerance *= 0.1) {
    const outcome o = controlled_by(
        "drop", 0.0,
        (step_rule){.tolerance = tolerance, .first = 0.5, .most = 0.5, .extrapolate = true});
    assert_int_equal(o.account.forced, 0);
    assert_true(o.account.located > 0.0 && o.account.located <= tolerance / 16.0);
    assert_true(o.error < tolerance);
    if (o.account.solved > 40) {
      fail_msg("tolerance %g: %ld steps for one impact", tolerance, o.account.solved);
    }
  }
}

/* A belt takes its load along until friction holds it: one trial tells when, and the next step ends there. */
static void stops(const char *solver, double tolerance, long most) {
  const outcome o = controlled_with(
      solver, "conveyor", 0.0,
      (step_rule){.tolerance = tolerance, .first = 0.4, .most = 0.4, .extrapolate = true});
  assert_int_equal(o.account.forced, 0);
  assert_true(o.error < tolerance);
  if (o.account.solved > most) {
    fail_msg("%s, tolerance %g: %ld steps for one stop", solver, tolerance, o.account.solved);
  }
}

/* As for an impact the work does not grow with the accuracy; but steps for sweeps end just before that, which is not the end of the slip yet. */
static void where_friction_stops_is_foreseen(void **state) {
  (void)state;
  for (double tolerance = 1e-2; tolerance > 1e-7; tolerance *= 0.1) {
    stops("cone_newton", tolerance, 60);
    stops("nsgs", tolerance, 150);
  }
}

/* A step of which only the finer way sees the impact is not extrapolated, however short it is: twice the speed behind it less the
 * one before is no speed at all. */
static void what_one_way_meets_is_not_extrapolated(void **state) {
  (void)state;
  for (int i = 0; i < 2; i++) {
    const double share = 1.0 / (20000.0 + 700.0 * i);
    const outcome o = controlled_by(
        "drop", 0.0,
        (step_rule){.tolerance = 1.0, .first = share, .most = share, .extrapolate = true});
    if (!(o.error < 1e-3)) {
      fail_msg("steps of %g: off by %g", share, o.error);
    }
  }
}

/* k->found: what a run to E comes to. */
static const error_result *to_error(simulation *k, double E) {
  const error_asked asked = {.E = E, .limit = ERROR_LIMIT};
  series record;
  sim_result out;
  step_list steps;
  base_error err = {0};
  error_result_close(&k->found);
  check_ok(error_run(&k->request, &asked, &record, &out, &steps, &k->found, &err), &err);
  assert_true(k->found.promised);
  series_close(&record);
  step_list_close(&steps);
  return &k->found;
}

/* A rod that falls on its tip: turning lifts the tip in every step, by less than it would fall in the next. It stays in
 * contact, or every other step would begin with an impact. */
static void what_turning_lifts_stays_in_contact(void **state) {
  (void)state;
  static const double E[] = {1e-2, 1e-3};
  static const long most[] = {60, 200}; /* the second in three runs */
  for (int i = 0; i < BASE_COUNT(E); i++) {
    simulation *k = opened("falling_rod", "coulomb", "nsgs", false);
    const error_result *r = to_error(k, E[i]);
    const long changed = r->level[r->n_level - 1].account.changed;
    if (r->solved > most[i] || changed > 0) {
      fail_msg("an error of %g: %ld steps, contacts changed in %ld of the last run", E[i],
               r->solved, changed);
    }
    closed(k);
  }
}

/* What a window looks at between states is known where nothing leaves its chord by more than the error; a throw does. */
static void a_window_is_seen_between_states(void **state) {
  (void)state;
  simulation *k = opened("stack:n=3", "velocity", "lemke", false);
  assert_int_equal(to_error(k, 1e-6)->n_level, 1);
  closed(k);
  k = opened("projectile:duration=1.1,speed_up=5", "velocity", "lemke", false);
  spec_check *c;
  base_error err = {0};
  check_ok(spec_add_check(&k->spec, CHECK_WINDOW_MAX, "ball.y", &c, &err), &err);
  c->t1 = 1.1;
  const double apex = 5.0 * 5.0 / (2.0 * 9.81);
  for (double E = 0.1; E > 1e-5; E *= 0.1) {
    const error_result *r = to_error(k, E);
    int windows = 0;
    for (int i = 0; i < r->n_quantity; i++) {
      const error_quantity *q = &r->quantity[i];
      const bool window = strstr(q->name, "window") != NULL;
      windows += window;
      if (window && !(fabs(q->value - apex) <= E * q->scale)) {
        fail_msg("E = %g: the highest is %g m, need %g m", E, q->value, apex);
      }
    }
    assert_true(windows == 1);
    assert_true(r->n_level > 1 || E > 0.01);
  }
  closed(k);
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
      cmocka_unit_test(extrapolated_steps_are_of_second_order),
      cmocka_unit_test(what_ends_inside_a_half_is_seen),
      cmocka_unit_test(what_holds_is_of_second_order),
      cmocka_unit_test(impacts_cost_their_location),
      cmocka_unit_test(an_impact_is_foreseen),
      cmocka_unit_test(where_friction_stops_is_foreseen),
      cmocka_unit_test(what_turning_lifts_stays_in_contact),
      cmocka_unit_test(what_one_way_meets_is_not_extrapolated),
      cmocka_unit_test(a_window_is_seen_between_states),
      cmocka_unit_test(what_is_asked_has_a_unit_or_a_scale),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
