#include "tests/support/check.h"

#include "harness/measure/effects_plan.h"

#include <stdio.h>
#include <string.h>

static void override_adds_and_removes(void **state) {
  (void)state;
  base_error err = {0};
  unsigned out;
  check_ok(effects_override(EFFECT_CONTACT | EFFECT_FRICTION, "-friction,+rolling", &out, &err),
           &err);
  assert_int_equal(out, EFFECT_CONTACT | EFFECT_ROLLING);
  char text[200];
  effects_print(out, text, sizeof text);
  assert_string_equal(text, "contact rolling");
  assert_int_equal(effects_override(0, "-frictoin", &out, &err), BASE_EINVAL);
}

static void a_plan_is_printed_as_it_is_read(void **state) {
  (void)state;
  const unsigned declared = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  base_error err = {0};
  effects_plan p;
  char text[EFFECTS_TEXT];
  const char *const plans[] = {"declared",
                               "-friction,-rotation",
                               "-friction/12:declared",
                               "-friction,-rotation/1:-rotation/900:declared",
                               "+rolling/3:-contact,+torsion",
                               "+sleep",
                               "-friction,+sleep/12:declared"};
  for (int i = 0; i < BASE_COUNT(plans); i++) {
    check_ok(effects_plan_parse(declared, plans[i], &p, &err), &err);
    effects_plan_print(&p, declared, text);
    assert_string_equal(text, plans[i]);
  }
  assert_true(p.sleep);
  check_ok(effects_plan_parse(declared, plans[3], &p, &err), &err);
  assert_false(p.sleep);
  assert_int_equal(effects_plan_at(&p, 0), EFFECT_CONTACT);
  assert_int_equal(effects_plan_at(&p, 1), EFFECT_CONTACT | EFFECT_FRICTION);
  assert_int_equal(effects_plan_at(&p, 899), EFFECT_CONTACT | EFFECT_FRICTION);
  assert_int_equal(effects_plan_at(&p, 900), declared);
  assert_int_equal(effects_plan_union(&p), declared);
}

static void sleep_may_stand_anywhere_in_the_first_text(void **state) {
  (void)state;
  const unsigned declared = EFFECT_CONTACT | EFFECT_FRICTION;
  base_error err = {0};
  effects_plan p;
  char text[EFFECTS_TEXT];
  const char *const plans[][2] = {{"+sleep,-friction", "-friction,+sleep"},
                                  {"-friction,+sleep,+rolling", "-friction,+rolling,+sleep"},
                                  {"+sleep/5:-friction", "+sleep/5:-friction"}};
  for (int i = 0; i < BASE_COUNT(plans); i++) {
    check_ok(effects_plan_parse(declared, plans[i][0], &p, &err), &err);
    effects_plan_print(&p, declared, text);
    assert_string_equal(text, plans[i][1]);
  }
  const char *const wrong[] = {"+sleepy", "-sleep", "declared/5:+sleep", "+sleep,+sleep"};
  for (int i = 0; i < BASE_COUNT(wrong); i++) {
    assert_int_equal(effects_plan_parse(declared, wrong[i], &p, &err), BASE_EINVAL);
  }
}

/* As many changes as a plan has room for, of all that auto changes, late in a long run. */
static void the_longest_plan_has_room(void **state) {
  (void)state;
  const unsigned all = EFFECT_FRICTION | EFFECT_ROLLING | EFFECT_TORSION | EFFECT_ROTATION |
                       EFFECT_GYROSCOPIC | EFFECT_SPATIAL;
  base_error err = {0};
  effects_plan p = {.n = EFFECTS_SPANS, .sleep = true}, read;
  char text[EFFECTS_TEXT];
  for (int k = 0; k < p.n; k++) {
    p.span[k] = (effects_span){(k > 0) ? 1999999000L + k : 0, (k % 2 == 0) ? 0 : EFFECT_CONTACT};
  }
  effects_plan_print(&p, all, text);
  check_ok(effects_plan_parse(all, text, &read, &err), &err);
  assert_int_equal(read.n, p.n);
  assert_true(read.sleep);
  for (int k = 0; k < p.n; k++) {
    assert_true(read.span[k].from == p.span[k].from);
    assert_int_equal(read.span[k].effects, p.span[k].effects);
  }
}

static void a_wrong_plan_is_refused(void **state) {
  (void)state;
  base_error err = {0};
  effects_plan p;
  char many[EFFECTS_TEXT] = "declared";
  for (int i = 1; i <= EFFECTS_SPANS; i++) {
    const size_t used = strlen(many);
    (void)snprintf(many + used, sizeof many - used, "/%d:all", i);
  }
  const char *const wrong[] = {"declared/",
                               "declared/x:all",
                               "declared/0:all",
                               "declared/2:all/2:all",
                               "declared/2",
                               "-nothing",
                               many};
  for (int i = 0; i < BASE_COUNT(wrong); i++) {
    assert_int_equal(effects_plan_parse(0, wrong[i], &p, &err), BASE_EINVAL);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(sleep_may_stand_anywhere_in_the_first_text),
                                     cmocka_unit_test(a_plan_is_printed_as_it_is_read),
                                     cmocka_unit_test(the_longest_plan_has_room),
                                     cmocka_unit_test(a_wrong_plan_is_refused),
                                     cmocka_unit_test(override_adds_and_removes)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
