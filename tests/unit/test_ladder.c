/* How the time of a problem is foretold from others of its family that differ in numbers. */
#include "tests/support/check.h"

#include "harness/campaign/ladder.h"
#include "lcp/base/status.h"

#include <math.h>

static void families_are_told_apart(void **state) {
  (void)state;
  assert_true(ladder_same_family("stack", "stack:n=3"));
  assert_true(ladder_same_family("stack:n=5,duration=0.1", "stack:n=3"));
  assert_false(ladder_same_family("stack:n=5", "stacks:n=5"));
  assert_false(ladder_same_family("stack:n=5", "stack:n=5@velocity@lemke@0.01@10"));
  assert_true(
      ladder_same_family("stack:n=5@velocity@lemke@0.01@10", "stack:n=9@velocity@lemke@0.01@10"));
  assert_false(
      ladder_same_family("stack:n=5@velocity@lemke@0.01@10", "stack:n=5@velocity@lemke@0.01@20"));
}

static void numbers_are_read(void **state) {
  (void)state;
  check_close(ladder_value("stack:n=5,duration=0.2", "duration", -1), 0.2, 0);
  check_close(ladder_value("stack:n=5@normal:push=3@lemke", "push", -1), -1,
              0); /* of a formulation */
  check_close(ladder_value("pit:dim=2,kind=3x", "kind", -1), -1, 0);
  check_close(ladder_value("stack", "n", -1), -1, 0);
}

/* t = 1e-6 n^2 at three rungs, whatever the coefficient: n = 100 takes 25 times as long as n = 20. */
static void powers_are_found(void **state) {
  (void)state;
  static const char *const rungs[] = {"stack:n=5,mu=0.5", "stack:n=10,mu=0.5", "stack:n=20,mu=0.5"};
  static const double n[] = {5, 10, 20};
  ladder l;
  ladder_begin(&l, "stack:n=100,duration=0.2,mu=0.7");
  assert_int_equal(l.n, 2); /* a duration is none */
  for (int i = 0; i < BASE_COUNT(rungs); i++) {
    ladder_add(&l, rungs[i], 1e-6 * n[i] * n[i]);
  }
  check_close(ladder_growth(&l, rungs[2]), 25, 1e-9);
  check_close(ladder_growth(&l, rungs[0]), 400, 1e-7);
  assert_true(ladder_distance(&l, rungs[2]) < ladder_distance(&l, rungs[1]));
  check_close(ladder_growth(&l, "stack"), 1, 0);
}

/* One rung alone: a size counts in proportion, a coefficient not at all. */
static void one_rung_tells_sizes(void **state) {
  (void)state;
  ladder l;
  ladder_begin(&l, "stack:n=40,mu=0.5");
  ladder_add(&l, "stack:n=10,mu=0.25", 1);
  check_close(ladder_growth(&l, "stack:n=10,mu=0.25"), 4, 1e-12);
  ladder_begin(&l, "stack:n=40");
  ladder_add(&l, "stack:n=10", 1);
  ladder_add(&l, "stack:n=20", 0.1); /* faster: noise of small times, not a law */
  check_close(ladder_growth(&l, "stack:n=20"), 1, 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(families_are_told_apart),
      cmocka_unit_test(numbers_are_read),
      cmocka_unit_test(powers_are_found),
      cmocka_unit_test(one_rung_tells_sizes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
