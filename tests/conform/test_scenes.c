/* Every registered scene: builds from its table, claims only effects that are there, predicts. */
#include "tests/support/check.h"

#include "problems/scene.h"

#include <stdio.h>
#include <string.h>

static void every_scene_builds(void **state) {
  (void)state;
  int n;
  const scene *const *all = scenes(&n);
  assert_true(n >= 5);
  for (int i = 0; i < n; i++) {
    scene_spec s;
    base_error err = {0};
    assert_ptr_equal(scene_find(all[i]->name), all[i]);
    check_ok(scene_load(all[i]->name, &s, &err), &err);
    assert_true(strlen(all[i]->about) > 80);
    assert_true(strlen(all[i]->title) > 5);
    if ((s.effects & ~s.present) != 0 && s.model == NULL) {
      fail_msg("%s declares effects that are not there", all[i]->name);
    }
    if (s.n_check == 0) {
      fail_msg("%s predicts nothing", all[i]->name);
    }
    for (int c = 0; c < s.n_check; c++) {
      if (!isfinite(s.check[c].value)) {
        fail_msg("%s: check %d is not finite", all[i]->name, c);
      }
    }
    spec_free(&s);
  }
}

/* Each parameter, alone, at the ends of its range: built, or refused in one line. */
static void ranges_hold(void **state) {
  (void)state;
  int n;
  const scene *const *all = scenes(&n);
  for (int i = 0; i < n; i++) {
    for (int f = 0; f < all[i]->n_fields; f++) {
      const base_field *field = &all[i]->fields[f];
      assert_non_null(field->help);
      if (field->kind == BASE_CHOICE || field->max > 1000.0) {
        continue; /* sizes in the thousands belong to the scaling study */
      }
      for (int end = 0; end < 2; end++) {
        char text[160], number[32];
        scene_spec s;
        base_error err = {0};
        base_real_print(end == 0 ? field->min : field->max, number, sizeof number);
        (void)snprintf(text, sizeof text, "%s:%s=%s", all[i]->name, field->name, number);
        if (scene_load(text, &s, &err) == BASE_OK) {
          spec_free(&s);
        } else if (strchr(err.text, '\n') != NULL || err.text[0] == '\0') {
          fail_msg("%s: not one line: '%s'", text, err.text);
        }
      }
    }
  }
}

static void wrong_parameters_are_refused(void **state) {
  (void)state;
  int n;
  const scene *const *all = scenes(&n);
  for (int i = 0; i < n; i++) {
    char text[160];
    scene_spec s;
    base_error err = {0};
    (void)snprintf(text, sizeof text, "%s:no_such_parameter=1", all[i]->name);
    assert_int_equal(scene_load(text, &s, &err), BASE_EINVAL);
    assert_non_null(strstr(err.text, "no_such_parameter"));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_scene_builds),
      cmocka_unit_test(ranges_hold),
      cmocka_unit_test(wrong_parameters_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
