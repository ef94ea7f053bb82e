#include "tests/support/check.h"

#include "problems/spec/effects.h"

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

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(override_adds_and_removes)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
