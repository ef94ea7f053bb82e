/* How far a run may be off by what it left out, against closed forms. */
#include "tests/support/check.h"

#include "harness/control/deviation.h"

#include <string.h>

static const deviation_scale scale = {
    .size = 0.5, .speed = 2.0, .fall = 4.0, .masses = 3.0, .swing = 2.5};

/* n steps of h in each of which friction changes velocities by `change`. */
static deviation after(int n, double h, double change, world_growth g) {
  deviation d = {0};
  double omitted[EFFECT_COUNT] = {0};
  omitted[EFFECT_FRICTION_BIT] = change;
  for (int k = 0; k < n; k++) {
    assert_true(deviation_add(&d, &scale, omitted, 0.0, &g, h));
  }
  return d;
}

/* A constant change of velocity moves by a t^2 / 2; where places pull at bodies as gravity does on what falls over, by a (cosh(r t) - 1) / r^2. */
static void it_grows_as_what_slides_or_falls_over(void **state) {
  (void)state;
  const double a = 1e-3, h = 1e-5, r = 3.0, t = 1.0;
  const int n = 100000;
  const deviation slides = after(n, h, a * h, (world_growth){0});
  check_close(slides.speed, a * t, 1e-9);
  check_close(slides.place, 0.5 * a * t * t, 2e-5);
  const deviation falls = after(n, h, a * h, (world_growth){.place = h * r * r});
  check_close(falls.speed, a * sinh(r * t) / r, 1e-4);
  check_close(falls.place, a * (cosh(r * t) - 1.0) / (r * r), 1e-4);
  const deviation turns = after(n, h, a * h, (world_growth){.speed = h * r});
  check_close(turns.speed, a * (exp(r * t) - 1.0) / r, 1e-4);
}

/* What is foreseen from half of the way is what comes of the other half. */
static void the_end_is_that_of_going_on(void **state) {
  (void)state;
  const double a = 1e-3, h = 1e-5, r = 3.0;
  for (int k = 0; k < 2; k++) {
    const world_growth g = {.place = (k == 0) ? 0.0 : h * r * r};
    const deviation half = after(50000, h, a * h, g), whole = after(100000, h, a * h, g);
    const double growth = deviation_growth(&scale, &g, h);
    check_close(growth, (k == 0) ? 0.0 : r, 1e-12);
    const double end = deviation_after(&half, &scale, growth, half.rate, 0.5);
    const double there = fmax(whole.speed / scale.speed, whole.place / scale.size);
    check_close(end / there, 1.0, 1e-4);
  }
  /* nothing falls faster than the smallest body: an impact's growth is not that of the steps to come */
  check_close(deviation_growth(&scale, &(world_growth){.place = 10.0}, h), scale.fall, 1e-12);
  const deviation d = after(1, h, 1.0, (world_growth){0});
  assert_true(isfinite(deviation_after(&d, &scale, 1e6, 1.0, 1e6)));
}

/* Once each: by the masses where bodies push each other, by its swing where one turns, what comes later too. */
static void it_passes_to_others_once(void **state) {
  (void)state;
  static const world_growth none = {0}, push = {.shared = true}, turn = {.turned = true};
  const struct {
    world_growth step[4];
    double speed;
  } cases[] = {
      {{none, none, none, none}, 4.0},
      {{none, push, none, push}, 3.0 * 4.0},
      {{none, none, turn, none},
       2.5 * 2.0 + 1.0 + 2.5}, /* in its own step it counts at points already */
      {{turn, push, none, none}, 3.0 * (1.0 + 3.0 * 2.5)},
  };
  for (int k = 0; k < (int)(sizeof cases / sizeof *cases); k++) {
    deviation d = {0};
    double omitted[EFFECT_COUNT] = {0};
    omitted[EFFECT_FRICTION_BIT] = 1.0;
    for (int i = 0; i < 4; i++) {
      deviation_add(&d, &scale, omitted, 0.0, &cases[k].step[i], 1e-9);
    }
    check_close(d.speed, cases[k].speed, 1e-12);
  }
}

static void what_is_less_than_the_least_is_none(void **state) {
  (void)state;
  deviation d = {0};
  double omitted[EFFECT_COUNT] = {0};
  omitted[EFFECT_FRICTION_BIT] = 1e-3;
  omitted[EFFECT_ROTATION_BIT] = 1.0;
  assert_false(deviation_add(&d, &scale, omitted, 2.0, &(world_growth){0}, 0.01));
  assert_true(deviation_add(&d, &scale, omitted, 0.0, &(world_growth){0}, 0.01));
  assert_int_equal(deviation_by(&d, 0.1), EFFECT_ROTATION);
  assert_int_equal(deviation_by(&d, 1e-4), EFFECT_ROTATION | EFFECT_FRICTION);
  memset(omitted, 0, sizeof omitted);
  assert_true(deviation_add(&d, &scale, omitted, 0.0, &(world_growth){0}, 0.01)); /* it stays off */
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(it_grows_as_what_slides_or_falls_over),
      cmocka_unit_test(the_end_is_that_of_going_on),
      cmocka_unit_test(it_passes_to_others_once),
      cmocka_unit_test(what_is_less_than_the_least_is_none),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
