/* Methods for cones beside cone_newton, on random frictional sets: none claims falsely, each solves the share that it is said
 * to solve, and an answer is its own warm start. */
#include "tests/support/check.h"

#include "tests/support/random_cones.h"
#include "tests/support/solve.h"

#include <string.h>

enum { SETS = CHECK_FEWER(45), STORAGES = 3 };

typedef struct method {
  const char *solver, *options;
  int least; /* percent of the sets, in every storage */
} method;

static const method methods[] = {
    {"admm", "law=coulomb,max_iter=2000", 75},
    {"admm", "law=de_saxce,max_iter=2000", 65},
    {"admm", "polish=off,accelerate=anderson,max_iter=2000", 45},
    {"admm", "polish=off,accelerate=none,max_iter=2000", 35},
    {"cone_ipm", "law=coulomb,max_iter=100", 85},
    {"cone_ipm", "law=de_saxce,max_iter=100", 80},
    {"cone_ipm", "polish=off,tol=1e-8,max_iter=100", 60},
    {"prox", "inner=newton,max_iter=2000", 90},
    {"prox", "inner=newton,polish=on,max_iter=2000", 90},
    {"prox", "polish=on,max_iter=20", 50},
    {"nsgs", "polish=on,max_iter=100", 55},
    {"nsgs", "accelerate=anderson,polish=on,max_iter=100", 50},
};

static void solve(const method *m, const lcp_problem *p, double *z, lcp_result *res,
                  lcp_verdict *v) {
  *res = solve_by(m->solver, m->options, p, z);
  *v = verdict_on(p, z);
}

static bool try(const method *m, const lcp_problem *p, double *z) {
  lcp_result res;
  lcp_verdict v;
  memset(z, 0, (size_t)p->M.n * sizeof *z);
  solve(m, p, z, &res, &v);
  if (res.outcome != LCP_SOLVED) {
    assert_true(res.outcome != LCP_INFEASIBLE && v.finite);
    return false;
  }
  assert_true(v.rho <= 1e-8);
  solve(m, p, z, &res, &v);
  assert_string_equal(lcp_outcome_name(res.outcome), "ok");
  assert_true(v.rho <= 1e-8 && res.work.iterations <= 1);
  return true;
}

static void random_sets_are_solved_and_never_claimed_falsely(void **state) {
  (void)state;
  int solved[BASE_COUNT(methods)][STORAGES] = {0};
  for (int seed = 1; seed <= SETS; seed++) {
    known_lcp k;
    lcp_csc csc;
    base_error err = {0};
    check_ok(random_cones(&k, (uint64_t)seed, &err), &err);
    const int n = k.p.M.n;
    double *z = calloc((size_t)n, sizeof *z);
    double *dense = calloc((size_t)n * (size_t)n, sizeof *dense);
    assert_true(z != NULL && dense != NULL);
    check_ok(lcp_matrix_to_csc(&k.p.M, &csc, &err), &err);
    lcp_matrix_to_dense(&k.p.M, dense);
    const lcp_matrix stored[STORAGES] = {k.p.M,
                                         {.storage = LCP_CSC, .n = n, .csc = csc},
                                         {.storage = LCP_DENSE, .n = n, .val = dense}};
    for (int m = 0; m < BASE_COUNT(methods); m++) {
      lcp_problem p = k.p;
      const int st =
          (seed + m) % STORAGES; /* each method meets each storage at a third of the sets */
      p.M = stored[st];
      solved[m][st] += try(&methods[m], &p, z);
    }
    lcp_csc_free(&csc);
    free(z);
    free(dense);
    known_lcp_free(&k);
  }
  for (int m = 0; m < BASE_COUNT(methods); m++) {
    int sum = 0;
    for (int st = 0; st < STORAGES; st++) {
      sum += solved[m][st];
      assert_true(100 * solved[m][st] >= (methods[m].least - 15) * SETS / STORAGES);
    }
    print_message("%s %s: %d of %d\n", methods[m].solver, methods[m].options, sum, SETS);
    assert_true(100 * sum >= methods[m].least * SETS);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(random_sets_are_solved_and_never_claimed_falsely),
  };
  return cmocka_run_group_tests_name("cone_methods", tests, NULL, NULL);
}
