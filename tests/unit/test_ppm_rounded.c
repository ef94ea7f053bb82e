/* ppm where doubles cannot hold what is asked of w: heavy bodies on light ones, and what has no answer all the same. */
#include "tests/support/check.h"

#include "tests/support/solve.h"

#include <string.h>

enum { ROWS = 2 };

static lcp_outcome solve(const lcp_problem *p, double *z) {
  memset(z, 0, sizeof *z * (size_t)p->M.n);
  return solve_by("ppm", "", p, z).outcome;
}

/* A body of `mass` on one of 1 kg on the floor: both fall at `speed`, both stop, by impulses whose difference is what
 * stops 1 kg. Row 1 may be a box, whose upper end is far. */
static void tower(double mass, double speed, bool box) {
  const double M[ROWS * ROWS] = {1, -1, -1, 1 + 1 / mass}, q[ROWS] = {-speed, 0};
  const double lo[ROWS] = {0}, hi[ROWS] = {HUGE_VAL, 2 * mass * speed};
  const lcp_block rows[ROWS] = {{.start = 0, .size = 1, .set = LCP_ORTHANT},
                                {.start = 1, .size = 1, .set = LCP_BOX}};
  lcp_problem p = {.M = {.storage = LCP_DENSE, .n = ROWS, .val = M}, .q = q};
  if (box) {
    p.block = rows;
    p.n_block = ROWS;
    p.lo = lo;
    p.hi = hi;
  }
  double z[ROWS];
  assert_int_equal(solve(&p, z), LCP_SOLVED);
  assert_true(verdict_on(&p, z).rho <= 1e-15);
  const double light = (z[0] - z[1]) - speed, heavy = z[1] / mass - speed;
  assert_true(fabs(light) <= 4e-16 * z[0]); /* as well as doubles can */
  assert_true(fabs(heavy) <= 1e-7 * speed); /* 1 + 1/mass was rounded */
}

static void heavy_on_light(void **state) {
  (void)state;
  for (int k = 0; k < 200; k++) {
    const double mass = pow(10, 4 + 4 * k / 199.0), speed = 0.0981 * (1 + 0.013 * k);
    tower(mass, speed, false);
    tower(mass, speed, true);
  }
}

/* Two rows that say opposite things by 2^-k of the speed: no answer, however large z is made. */
static void contradictions_stay(void **state) {
  (void)state;
  for (int k = 8; k <= 28; k++) {
    const double M[ROWS * ROWS] = {1, -1, -1, 1}, q[ROWS] = {-1, 1 - ldexp(1, -k)};
    const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = ROWS, .val = M}, .q = q};
    double z[ROWS];
    assert_int_not_equal(solve(&p, z), LCP_SOLVED);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(heavy_on_light),
      cmocka_unit_test(contradictions_stay),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
