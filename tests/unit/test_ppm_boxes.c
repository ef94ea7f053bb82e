/* ppm on redundant impulses between two bounds: of many answers it takes the one that its start is at, or near. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "tests/support/solve.h"

#include <string.h>

enum { DOF = 6, CONTACTS = 16, N = 2 * CONTACTS, SEEDS = 40 };

/* A normal and a friction row of each contact of one body, M = J J', and an answer z with w = 0 of which all but DOF of the
 * rows are a matter of choice. */
typedef struct redundant {
  double M[N * N], q[N], lo[N], hi[N], z[N];
  lcp_block block[2 * CONTACTS];
  lcp_problem p;
} redundant;

static void move(const redundant *b, const double *z, double *w) {
  for (int i = 0; i < N; i++) {
    w[i] = 0;
    for (int j = 0; j < N; j++) {
      w[i] += b->M[j * N + i] * z[j];
    }
  }
}

static void fill(redundant *b, uint64_t seed) {
  base_rng rng = base_rng_seeded(seed);
  double J[N][DOF];
  for (int i = 0; i < N; i++) {
    const int contact = i / 2;
    const bool normal = i % 2 == 0;
    for (int k = 0; k < DOF; k++) {
      J[i][k] = base_rng_between(&rng, -1, 1);
    }
    b->z[i] = normal ? base_rng_between(&rng, 0.5, 1.5) : base_rng_between(&rng, -0.2, 0.2);
    b->lo[i] = normal ? 0 : -0.25;
    b->hi[i] = normal ? HUGE_VAL : 0.25;
    b->block[i] = (lcp_block){
        .start = 2 * contact + !normal, .size = 1, .set = normal ? LCP_ORTHANT : LCP_BOX};
  }
  for (int i = 0; i < N; i++) {
    for (int j = 0; j < N; j++) {
      double sum = 0;
      for (int k = 0; k < DOF; k++) {
        sum += J[i][k] * J[j][k];
      }
      b->M[j * N + i] = sum;
    }
  }
  move(b, b->z, b->q);
  for (int i = 0; i < N; i++) {
    b->q[i] = -b->q[i];
  }
  b->p = (lcp_problem){.M = {.storage = LCP_DENSE, .n = N, .val = b->M},
                       .q = b->q,
                       .lo = b->lo,
                       .hi = b->hi,
                       .block = b->block,
                       .n_block = N,
                       .traits = LCP_SYMMETRIC | LCP_PSD};
}

static lcp_result solve(const lcp_problem *p, double *z) {
  const lcp_result res = solve_by("ppm", "", p, z);
  assert_int_equal(res.outcome, LCP_SOLVED);
  check_close(verdict_on(p, z).rho, 0, 1e-10);
  return res;
}

/* All of the problem's data is that of the last step: nothing is to be done. */
static void an_answer_comes_back_to_the_bit(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    redundant b;
    double z[N];
    fill(&b, seed);
    memcpy(z, b.z, sizeof z);
    const lcp_result res = solve(&b.p, z);
    assert_memory_equal(z, b.z, sizeof z);
    assert_int_equal(res.work.pivots, 0);
  }
}

/* Loads that change by a millionth change impulses by as much, times what the rows of F are conditioned by; rows that go to
 * their bounds change by a quarter. */
static void a_small_change_moves_little(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    redundant b;
    double z[N], push[N], by[N];
    fill(&b, seed);
    base_rng rng = base_rng_seeded(seed + 1000);
    for (int i = 0; i < N; i++) {
      push[i] = base_rng_between(&rng, -1e-6, 1e-6);
    }
    move(&b, push, by);
    for (int i = 0; i < N; i++) {
      b.q[i] += by[i];
    }
    memcpy(z, b.z, sizeof z);
    (void)solve(&b.p, z);
    for (int i = 0; i < N; i++) {
      check_close(z[i], b.z[i], 1e-3);
    }
  }
}

/* From zero friction is at zero, and what needs none ends without: rows whose w is zero all along take no part. */
static void what_needs_no_friction_has_none(void **state) {
  (void)state;
  redundant b;
  double z[N] = {0};
  fill(&b, 7);
  for (int i = 0; i < N; i++) { /* friction acts on a body of its own that nothing moves */
    for (int j = 0; j < N; j++) {
      b.M[j * N + i] = (i % 2 == j % 2) ? b.M[j * N + i] : 0;
    }
    b.z[i] = (i % 2 == 0) ? b.z[i] : 0;
  }
  move(&b, b.z, b.q);
  for (int i = 0; i < N; i++) {
    b.q[i] = -b.q[i];
  }
  (void)solve(&b.p, z);
  for (int i = 1; i < N; i += 2) {
    assert_true(z[i] == 0);
  }
}

/* Impulses of a jam grow from step to step: what redundant rows keep of them would drown the answer. */
static void a_far_start_is_given_up(void **state) {
  (void)state;
  int from_zero = 0;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    redundant b;
    double z[N];
    fill(&b, seed);
    for (int i = 0; i < N; i++) {
      z[i] = (i % 2 == 0) ? 1e12 * b.z[i] : b.z[i];
    }
    const lcp_result res = solve(&b.p, z);
    for (int i = 0; i < N && res.work.fallbacks > 0; i++) {
      assert_true(fabs(z[i]) < 1e3);
    }
    from_zero += res.work.fallbacks > 0;
  }
  assert_true(from_zero > 0);
}

/* Zero is no start from another solve, also where a box does not have it. */
static void zero_outside_of_a_box_is_cold(void **state) {
  (void)state;
  enum { ROWS = 2 };
  const double M[ROWS * ROWS] = {2, 1, 1, 2}, q[ROWS] = {-5, 1}, lo[ROWS] = {1, -1},
                        hi[ROWS] = {9, 2};
  const lcp_block rows = {.start = 0, .size = ROWS, .set = LCP_BOX};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = ROWS, .val = M},
                         .q = q,
                         .lo = lo,
                         .hi = hi,
                         .block = &rows,
                         .n_block = 1,
                         .traits = LCP_SYMMETRIC | LCP_PSD};
  double z[ROWS] = {0};
  assert_string_equal(solve(&p, z).variant, "");
  check_close(z[0], 3, 1e-15); /* w = (0, 2) */
  check_close(z[1], -1, 0);
  assert_string_equal(solve(&p, z).variant, "warm");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_answer_comes_back_to_the_bit),
      cmocka_unit_test(a_small_change_moves_little),
      cmocka_unit_test(what_needs_no_friction_has_none),
      cmocka_unit_test(a_far_start_is_given_up),
      cmocka_unit_test(zero_outside_of_a_box_is_cold),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
