#include "tests/support/check.h"

#include "lcp/base/crew.h"
#include "lcp/base/rng.h"
#include "problems/geometry/broad_phase.h"

static base_error err;

static int overlap(const broad_ball *a, const broad_ball *b) {
  double s = 0.0;
  for (int k = 0; k < 3; k++) {
    s += (a->x[k] - b->x[k]) * (a->x[k] - b->x[k]);
  }
  return s <= (a->r + b->r) * (a->r + b->r);
}

/* Sizes from one to a hundred, clustered and spread out, far from the origin too. */
static void fill(broad_phase *bp, int dim, int n, double far, base_rng *r) {
  check_ok(broad_reserve(bp, n, &err), &err);
  for (int i = 0; i < n; i++) {
    broad_ball *b = &bp->ball[i];
    for (int k = 0; k < 3; k++) {
      b->x[k] = (k < dim) ? far + base_rng_between(r, -20, 20) : 0.0;
    }
    b->r = (i % 17 == 0) ? base_rng_between(r, 1, 50) : base_rng_between(r, 0.5, 1.5);
  }
}

static void finds_exactly_the_overlapping_pairs(void **state) {
  (void)state;
  const double far[] = {0.0, -1e4, 1e12, 1e300};
  broad_phase bp = {0};
  base_rng r = base_rng_seeded(8);
  for (int trial = 0; trial < 40; trial++) {
    const int dim = 2 + trial % 2, n = 1 + trial * 10;
    fill(&bp, dim, n, far[trial / 2 % 4], &r);
    check_ok(broad_find(&bp, dim, &err), &err);
    unsigned char *seen = calloc((size_t)n * (size_t)n, 1);
    for (int k = 0; k < bp.n_pair; k++) {
      const broad_pair p = bp.pair[k];
      assert_true(p.a < p.b && p.b < n);
      assert_int_equal(seen[p.a * n + p.b]++, 0); /* no pair twice */
    }
    for (int i = 0; i < n; i++) {
      for (int j = i + 1; j < n; j++) {
        assert_int_equal(seen[i * n + j], overlap(&bp.ball[i], &bp.ball[j]));
      }
    }
    free(seen);
  }
  broad_close(&bp);
}

/* Pairs tested and memory do not grow faster than the balls: the table has at most 4 n buckets. */
static void memory_is_linear_in_the_balls(void **state) {
  (void)state;
  broad_phase bp = {0};
  base_rng r = base_rng_seeded(9);
  for (int n = 100; n <= 100000; n *= 10) {
    check_ok(broad_reserve(&bp, n, &err), &err);
    const double side = cbrt((double)n);
    for (int i = 0; i < n; i++) {
      for (int k = 0; k < 3; k++) {
        bp.ball[i].x[k] = base_rng_between(&r, 0, side);
      }
      bp.ball[i].r = 0.5;
    }
    check_ok(broad_find(&bp, 3, &err), &err);
    assert_true(bp.cap_bucket <= 4 * n + 16);
    assert_true(bp.n_pair < 4 * n); /* 2.1 n expected: (4/3) pi / 2 */
    assert_true(bp.n_pair > n);
  }
  broad_close(&bp);
}

/* A fifth of the balls is thirty times larger than the others: the comparisons still grow as the balls do. */
static void two_sizes_are_linear_too(void **state) {
  (void)state;
  broad_phase bp = {0};
  base_rng r = base_rng_seeded(10);
  for (int n = 300; n <= 30000; n *= 10) {
    const double side = 30.0 * cbrt((double)n);
    check_ok(broad_reserve(&bp, n, &err), &err);
    for (int i = 0; i < n; i++) {
      for (int k = 0; k < 3; k++) {
        bp.ball[i].x[k] = base_rng_between(&r, 0, side);
      }
      bp.ball[i].r = (i % 5 == 0) ? 15.0 : 0.5;
    }
    check_ok(broad_find(&bp, 3, &err), &err);
    print_message("# %d balls: %ld compared, %d overlap\n", n, bp.tested, bp.n_pair);
    assert_true(bp.tested < 10L * n);
    assert_true(bp.n_pair > n / 10);
  }
  broad_close(&bp);
}

static void refuses_what_is_not_finite(void **state) {
  (void)state;
  broad_phase bp = {0};
  base_rng r = base_rng_seeded(9);
  fill(&bp, 3, 5, 0.0, &r);
  bp.ball[3].x[1] = HUGE_VAL;
  assert_int_equal(broad_find(&bp, 3, &err), BASE_EINVAL);
  broad_close(&bp);
}

/* Balls of many sizes, in several parts: the same pairs in the same order, and as many compared. */
static void threads_find_the_same_list(void **state) {
  (void)state;
  enum { N = 5000 };
  broad_phase alone = {0};
  for (int threads = 1; threads <= 4; threads++) {
    broad_phase bp = {0};
    base_rng r = base_rng_seeded(11);
    base_crew *crew;
    check_ok(base_crew_open(&crew, threads, &err), &err);
    (void)base_crew_take_up(crew);
    fill(&bp, 3, N, 0.0, &r);
    check_ok(broad_find(&bp, 3, &err), &err);
    (void)base_crew_take_up(NULL);
    base_crew_close(crew);
    if (threads == 1) {
      alone = bp;
      assert_true(bp.n_pair > N);
      continue;
    }
    assert_int_equal(bp.n_pair, alone.n_pair);
    assert_int_equal(bp.tested, alone.tested);
    assert_memory_equal(bp.pair, alone.pair, (size_t)bp.n_pair * sizeof *bp.pair);
    broad_close(&bp);
  }
  broad_close(&alone);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(finds_exactly_the_overlapping_pairs),
      cmocka_unit_test(memory_is_linear_in_the_balls),
      cmocka_unit_test(two_sizes_are_linear_too),
      cmocka_unit_test(threads_find_the_same_list),
      cmocka_unit_test(refuses_what_is_not_finite),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
