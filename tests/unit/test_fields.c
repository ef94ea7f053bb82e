#include "tests/support/check.h"

#include "lcp/base/fields.h"

#include <string.h>

typedef struct options {
  double omega;
  int sweeps, rule;
} options;

static const base_field fields[] = {
    BASE_FIELD(options, omega, BASE_REAL, "1", 1.3, 0.1, 1.9, "relaxation"),
    BASE_FIELD(options, sweeps, BASE_INT, "1", 17, 1, 1e6, "sweeps"),
    BASE_FIELD_CHOICE(options, rule, "lexicographic|least_index", 1, "tie rule"),
};

static base_status parse(options *o, const char *text, base_error *err) {
  base_fields_default(fields, BASE_COUNT(fields), o);
  return base_fields_parse(fields, BASE_COUNT(fields), o, text, err);
}

static void prints_what_it_parsed(void **state) {
  (void)state;
  options o;
  base_error err = {0};
  check_ok(parse(&o, "omega=0.7,rule=lexicographic,sweeps=1e3", &err), &err);
  char text[128];
  const size_t len = base_fields_print(fields, BASE_COUNT(fields), &o, text, sizeof text);
  assert_int_equal(len, strlen(text));
  assert_string_equal(text, "omega=0.7,sweeps=1000,rule=lexicographic");
}

static void refuses(const char *text, const char *says) {
  options o;
  base_error err = {0};
  assert_int_equal(parse(&o, text, &err), BASE_EINVAL);
  if (strstr(err.text, says) == NULL) {
    fail_msg("'%s' gave \"%s\", which lacks \"%s\"", text, err.text, says);
  }
}

static void names_culprit_and_rule(void **state) {
  (void)state;
  refuses("omega=2.5", "omega=2.5: need a value in [0.1, 1.9]");
  refuses("omega=nan", "need a finite number");
  refuses("omega=0.5x", "need a finite number");
  refuses("sweeps=2.5", "need an integer");
  refuses("rule=least", "lexicographic|least_index");
  refuses("relax=1", "unknown option 'relax': known are omega, sweeps, rule");
  refuses("omega", "need name=value");
  refuses("omega=1,sweeps=3,omega=1", "omega=1: need it once, it is given twice");
}

static void shortest_number_that_reads_back(void **state) {
  (void)state;
  char text[32];
  base_real_print(0.1, text, sizeof text);
  assert_string_equal(text, "0.1");
  base_real_print(1.0 / 3.0, text, sizeof text);
  assert_true(strtod(text, NULL) == 1.0 / 3.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(prints_what_it_parsed),
      cmocka_unit_test(names_culprit_and_rule),
      cmocka_unit_test(shortest_number_that_reads_back),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
