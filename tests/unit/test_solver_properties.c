/* Properties every iterative solver must have: planted solutions of mixed problems are found, and
 * powers of two in the units change no bit of the iteration. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "tests/support/solve.h"

#include <stdio.h>
#include <string.h>

enum { N = 24 };
static const char *const names[] = {
    "pgs",    "projected_gradient", "jacobi", "apgd",        "nncg", "nsgs",    "prox", "newton",
    "pgs_sm", "interior_point",     "sqp",    "cone_newton", "admm", "cone_ipm"};

/* M = B'B / N + I/5 (+ K - K'), 8 orthant, 8 box and 8 free rows. The solution is chosen first: a third
 * of the orthant and box rows inside, the rest on a bound with w of the right sign. */
typedef struct planted {
  double M[N * N], q[N], lo[N], hi[N], z[N];
  lcp_block block[3];
  lcp_problem p;
} planted;

static void plant(planted *t, unsigned long seed, bool symmetric, bool boxes) {
  base_rng r = base_rng_seeded(seed);
  double B[N * N];
  for (int i = 0; i < N * N; i++) {
    B[i] = base_rng_between(&r, -1.0, 1.0);
  }
  for (int i = 0; i < N; i++) {
    for (int j = 0; j <= i; j++) {
      double sum = (i == j) ? 0.2 : 0.0;
      for (int k = 0; k < N; k++) {
        sum += B[k + i * N] * B[k + j * N] / N;
      }
      const double skew = (symmetric || i == j) ? 0.0 : base_rng_between(&r, -0.05, 0.05);
      t->M[i + j * N] = sum + skew;
      t->M[j + i * N] = sum - skew;
    }
  }
  for (int i = 0; i < N; i++) {
    const bool box = boxes && i / 8 == 1, open = i / 8 == 2 || i % 3 == 0;
    t->lo[i] = box ? -0.7 : 0.0;
    t->hi[i] = box ? 0.9 : HUGE_VAL;
    const bool top = box && i % 3 == 1;
    t->z[i] = open ? base_rng_between(&r, 0.1, 0.8) : (top ? t->hi[i] : t->lo[i]);
    t->q[i] = open ? 0.0 : (top ? -1.0 : 1.0) * base_rng_between(&r, 0.1, 1.0);
  }
  for (int i = 0; i < N; i++) {
    for (int j = 0; j < N; j++) {
      t->q[i] -= t->M[i + j * N] * t->z[j];
    }
    t->hi[i] = (t->hi[i] < HUGE_VAL) ? t->hi[i] : 0.0; /* finite data; read on the box rows only */
  }
  const lcp_set set[3] = {LCP_ORTHANT, boxes ? LCP_BOX : LCP_ORTHANT, LCP_FREE};
  for (int b = 0; b < 3; b++) {
    t->block[b] = (lcp_block){.start = 8 * b, .size = 8, .set = set[b]};
  }
  t->p = (lcp_problem){.M = {.storage = LCP_DENSE, .n = N, .val = t->M},
                       .q = t->q,
                       .lo = t->lo,
                       .hi = t->hi,
                       .block = t->block,
                       .n_block = 3,
                       .traits = LCP_PSD | LCP_PD | (symmetric ? (unsigned)LCP_SYMMETRIC : 0u)};
}

/* What the methods are not for: boxes in an interior point, matrices that are not symmetric in a minimisation. */
static bool outside(const char *name, const lcp_problem *p) {
  const bool minimises = strcmp(name, "apgd") == 0 || strcmp(name, "sqp") == 0;
  bool boxes = false;
  for (int b = 0; b < p->n_block; b++) {
    boxes = boxes || p->block[b].set == LCP_BOX;
  }
  return (boxes && strcmp(name, "interior_point") == 0) ||
         (minimises && !(p->traits & LCP_SYMMETRIC));
}

/* False where the solver refuses p, which it must where p is outside what it is for, and only there. */
static bool run_limited(const char *name, const char *options, const lcp_problem *p, double *z,
                        lcp_result *res) {
  base_error err = {0};
  if (lcp_solver_admits(lcp_solver_find(name), p, NULL) != BASE_OK) {
    assert_true(outside(name, p));
    return false;
  }
  const base_status prepared = try_solve(name, options, p, z, res, &err);
  assert_true(prepared == BASE_OK || prepared == BASE_EUNSUPPORTED);
  if ((prepared != BASE_OK) != outside(name, p)) {
    fail_msg("%s: %s", name, (prepared == BASE_OK) ? "not refused" : err.text);
  }
  return prepared == BASE_OK;
}

static bool run(const char *name, const lcp_problem *p, double *z, lcp_result *res) {
  return run_limited(name, "max_iter=20000", p, z, res);
}

static void planted_solutions_are_found(void **state) {
  (void)state;
  int runs = 0;
  for (int c = 0; c < 12; c++) {
    planted t;
    plant(&t, 100ul + (unsigned long)c, c % 2 == 0, c % 3 != 0);
    for (int s = 0; s < BASE_COUNT(names); s++) {
      double z[N] = {0};
      lcp_result res = {0};
      if (!run(names[s], &t.p, z, &res)) {
        continue;
      }
      runs++;
      lcp_verdict verdict;
      base_error err = {0};
      check_ok(lcp_judge(&t.p, z, &verdict, &err), &err);
      if (res.outcome != LCP_SOLVED || !(verdict.rho <= 1e-8)) {
        fail_msg("%s, seed %d: %s, rho %g", names[s], 100 + c, lcp_outcome_name(res.outcome),
                 verdict.rho);
      }
      for (int i = 0; i < N; i++) { /* smallest eigenvalue 0.2, rows of size one: 1e-8 * 20 / 0.2 */
        check_close(z[i], t.z[i], 1e-6);
      }
    }
  }
  assert_int_equal(runs, 12 * BASE_COUNT(names) - 6 - 6 - 8); /* apgd, sqp; interior_point */
}

/* D M D, D q with D = 2^k: the same iteration, so z = D z' to the last bit. */
static void powers_of_two_change_no_bit(void **state) {
  (void)state;
  planted t, u;
  plant(&t, 7, true, true);
  plant(&u, 7, true, true);
  double D[N];
  for (int i = 0; i < N; i++) {
    D[i] = ldexp(1.0, (i * 29) % 61 - 30);
  }
  for (int i = 0; i < N; i++) {
    for (int j = 0; j < N; j++) {
      u.M[i + j * N] *= D[i] * D[j];
    }
    u.q[i] *= D[i];
    u.lo[i] /= D[i];
    u.hi[i] /= D[i];
  }
  u.p.M.val = u.M;
  u.p.q = u.q;
  u.p.lo = u.lo;
  u.p.hi = u.hi;
  u.p.block = u.block;
  int runs = 0;
  for (int s = 0; s < BASE_COUNT(names); s++) {
    double z[N] = {0}, scaled[N] = {0};
    lcp_result a = {0}, b = {0};
    if (run(names[s], &t.p, z, &a) && run(names[s], &u.p, scaled, &b)) {
      runs++;
      if (a.work.iterations != b.work.iterations) {
        fail_msg("%s: %ld and %ld iterations", names[s], a.work.iterations, b.work.iterations);
      }
      for (int i = 0; i < N; i++) {
        if (scaled[i] * D[i] != z[i]) {
          fail_msg("%s: z[%d] = %.17g and %.17g", names[s], i, z[i], scaled[i] * D[i]);
        }
      }
    }
  }
  assert_int_equal(runs, BASE_COUNT(names) - 1); /* all but interior_point */
}

/* M = J J' of rank 1 to 3 and a q with no solution, q'y < 0 for a y >= 0 with J'y = 0: rounding makes some of these M
 * regular, with a z of 1e15 whose terms hide any violation from a residual that is relative to them. */
static void singular_but_for_rounding_is_no_solution(void **state) {
  (void)state;
  enum { ROWS = 8, PROBLEMS = 100 };
  static const char *const direct[] = {"lemke",          "ppm",           "murty", "enumerate",
                                       "block_pivoting", "interior_point"};
  for (unsigned long seed = 0; seed < PROBLEMS; seed++) {
    base_rng r = base_rng_seeded(500 + seed);
    const int rank = 1 + (int)(seed % 3);
    double J[ROWS][3] = {{0}}, M[ROWS * ROWS] = {0}, q[ROWS], y[ROWS], work = 0;
    for (int i = 0; i < ROWS; i++) {
      y[i] = (i < ROWS - 1) ? base_rng_between(&r, 0.2, 1) : 1;
      q[i] = base_rng_between(&r, -1, 0.2);
      work += q[i] * y[i];
      for (int k = 0; k < rank && i < ROWS - 1; k++) {
        J[i][k] = base_rng_normal(&r);
        J[ROWS - 1][k] -= y[i] * J[i][k];
      }
    }
    for (int e = 0; e < ROWS * ROWS * rank; e++) {
      M[e / rank] += J[e / rank / ROWS][e % rank] * J[e / rank % ROWS][e % rank];
    }
    const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = ROWS, .val = M},
                           .q = q,
                           .traits = LCP_SYMMETRIC | LCP_PSD};
    for (int s = 0; s < BASE_COUNT(direct) && work < -0.1; s++) {
      double z[ROWS] = {0};
      lcp_result res = {0};
      assert_true(run(direct[s], &p, z, &res));
      if (res.outcome == LCP_SOLVED) {
        fail_msg("%s claims to solve problem %lu: z[0] = %g", direct[s], seed, z[0]);
      }
    }
  }
}

/* M = [1 -1; -1 1], infeasible by 2^-k: from a z far out, and by steps that lead there, the violation is as large as the
 * rounding in M z. */
static void a_z_that_ran_away_hides_nothing(void **state) {
  (void)state;
  static const double M[] = {1, -1, -1, 1};
  int runs = 0;
  for (int k = 3; k <= 18; k++) {
    const double q[] = {-1, 1 - ldexp(1, -k)};
    const lcp_problem p = {
        .M = {.storage = LCP_DENSE, .n = 2, .val = M}, .q = q, .traits = LCP_SYMMETRIC | LCP_PSD};
    for (int s = 0; s < 2 * BASE_COUNT(names); s++) {
      const double far = (s % 2 == 0) ? 0 : ldexp(1, k + 7);
      double z[] = {far + far / 128, far};
      lcp_result res = {0};
      runs += run(names[s / 2], &p, z, &res);
      if (res.outcome == LCP_SOLVED) {
        fail_msg("%s claims to solve what is infeasible by 2^-%d: z = (%g, %g)", names[s / 2], k,
                 z[0], z[1]);
      }
    }
  }
  assert_int_equal(runs, 16 * 2 * BASE_COUNT(names));
}

/* A pivoting method that runs out of iterations leaves the point it had, and its residual. */
static void given_up_points_are_handed_over(void **state) {
  (void)state;
  static const char *const pivoting[] = {"murty", "block_pivoting", "ppm"};
  planted t;
  plant(&t, 42, true, false);
  t.p.n_block = 0;
  t.p.block = NULL; /* all orthant */
  for (int s = 0; s < BASE_COUNT(pivoting); s++) {
    double z[N] = {0};
    lcp_result res = {0};
    lcp_verdict v;
    base_error err = {0};
    assert_true(run_limited(pivoting[s], "max_iter=1", &t.p, z, &res));
    assert_string_equal(lcp_outcome_name(res.outcome), "max_iter");
    int moved = 0;
    for (int i = 0; i < N; i++) {
      moved += z[i] > 0;
    }
    check_ok(lcp_judge(&t.p, z, &v, &err), &err);
    if (moved == 0 || !(fabs(res.residual - v.rho) <= 1e-9)) {
      fail_msg("%s: %d rows moved, residual %g, judged %g", pivoting[s], moved, res.residual,
               v.rho);
    }
  }
}

/* q = 0 says nothing of how large z is when a box keeps it from zero. */
static void boxes_away_from_zero_need_no_q(void **state) {
  (void)state;
  static const char *const direct[] = {
      "pgs", "jacobi", "projected_gradient", "nncg", "apgd", "ppm", "newton", "pgs_sm", "sqp"};
  const double M[4] = {2, 1, 1, 2}, q[2] = {0}, lo[2] = {1, -3}, hi[2] = {4, 5};
  const lcp_block block = {.start = 0, .size = 2, .set = LCP_BOX};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = M},
                         .q = q,
                         .lo = lo,
                         .hi = hi,
                         .block = &block,
                         .n_block = 1,
                         .traits = LCP_SYMMETRIC | LCP_PSD | LCP_PD};
  for (int s = 0; s < BASE_COUNT(direct); s++) {
    double z[2] = {0};
    lcp_result res = {0};
    assert_true(run(direct[s], &p, z, &res));
    if (res.outcome != LCP_SOLVED) {
      fail_msg("%s: %s, z = (%g, %g)", direct[s], lcp_outcome_name(res.outcome), z[0], z[1]);
    }
    check_close(z[0], 1, 1e-7); /* z2 = -1/2 then makes w2 = 0 */
    check_close(z[1], -0.5, 1e-7);
  }
}

/* A sphere that slides straight: nothing acts along the second tangent, whose answer is zero. Reached
 * from the end of its box it must be zero and not the rest of a cancellation, which counts as wrong
 * in a residual that knows no scale. */
static void idle_rows_of_a_box_end_at_zero(void **state) {
  (void)state;
  for (int k = 0; k < 200; k++) {
    double M[4] = {7.0, 0, 0, 7.0 * (1.0 + k * 2.2e-16)}, q[2] = {2.1, 0}, z[2] = {0};
    double lo[2] = {-0.014715, -0.014715}, hi[2] = {0.014715, 0.014715};
    lcp_block block = {.start = 0, .size = 2, .set = LCP_BOX};
    const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = M},
                           .q = q,
                           .lo = lo,
                           .hi = hi,
                           .block = &block,
                           .n_block = 1,
                           .traits = LCP_SYMMETRIC | LCP_PSD};
    lcp_result res;
    assert_true(run("ppm", &p, z, &res));
    assert_int_equal(res.outcome, LCP_SOLVED);
    check_close(z[0], lo[0], 0);
    check_close(z[1], 0, 0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(planted_solutions_are_found),
      cmocka_unit_test(powers_of_two_change_no_bit),
      cmocka_unit_test(singular_but_for_rounding_is_no_solution),
      cmocka_unit_test(a_z_that_ran_away_hides_nothing),
      cmocka_unit_test(given_up_points_are_handed_over),
      cmocka_unit_test(boxes_away_from_zero_need_no_q),
      cmocka_unit_test(idle_rows_of_a_box_end_at_zero),
  };
  return cmocka_run_group_tests_name("solver properties", tests, NULL, NULL);
}
