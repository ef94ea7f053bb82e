/* Methods for cones beside cone_newton, on random frictional sets: none claims falsely, each solves the share that it is said
 * to solve, and an answer is its own warm start. */
#include "tests/support/check.h"

#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"
#include "tests/support/random_cones.h"

#include <string.h>

enum { SETS = CHECK_FEWER(45), STORAGES = 3 };

typedef struct method {
  const char *solver, *options[3][2]; /* names and values, NULL at the end */
  const char *most;                   /* iterations */
  int least;                          /* percent of the sets, in every storage */
} method;

static const method methods[] = {
    {"admm", {{"law", "coulomb"}}, "2000", 75},
    {"admm", {{"law", "de_saxce"}}, "2000", 65},
    {"admm", {{"polish", "off"}, {"accelerate", "anderson"}}, "2000", 45},
    {"admm", {{"polish", "off"}, {"accelerate", "none"}}, "2000", 35},
    {"cone_ipm", {{"law", "coulomb"}}, "100", 85},
    {"cone_ipm", {{"law", "de_saxce"}}, "100", 80},
    {"cone_ipm", {{"polish", "off"}, {"tol", "1e-8"}}, "100", 60},
    {"prox", {{"inner", "newton"}}, "2000", 90},
    {"prox", {{"inner", "newton"}, {"polish", "on"}}, "2000", 90},
    {"prox", {{"polish", "on"}}, "20", 50},
    {"nsgs", {{"polish", "on"}}, "100", 55},
    {"nsgs", {{"accelerate", "anderson"}, {"polish", "on"}}, "100", 50},
};

static void solve(const method *m, const lcp_problem *p, double *z, lcp_result *res,
                  lcp_verdict *v) {
  _Alignas(16) unsigned char opt[512] = {0};
  const lcp_solver *s = lcp_solver_find(m->solver);
  assert_true(s != NULL && s->options_size <= sizeof opt);
  lcp_instance *k;
  base_error err = {0};
  const lcp_capacity cap = lcp_problem_capacity(p);
  base_fields_default(s->fields, s->n_fields, opt);
  check_ok(base_fields_set(s->fields, s->n_fields, opt, "max_iter", m->most, &err), &err);
  for (int i = 0; i < 3 && m->options[i][0] != NULL; i++) {
    check_ok(base_fields_set(s->fields, s->n_fields, opt, m->options[i][0], m->options[i][1], &err),
             &err);
  }
  check_ok(lcp_instance_open(&k, s, &cap, opt, &err), &err);
  check_ok(lcp_instance_prepare(k, p, &err), &err);
  check_ok(lcp_instance_solve(k, NULL, z, res, &err), &err);
  check_ok(lcp_judge(p, z, v, &err), &err);
  lcp_instance_close(k);
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
    print_message("%s %s=%s: %d of %d\n", methods[m].solver, methods[m].options[0][0],
                  methods[m].options[0][1], sum, SETS);
    assert_true(100 * sum >= methods[m].least * SETS);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(random_sets_are_solved_and_never_claimed_falsely),
  };
  return cmocka_run_group_tests_name("cone_methods", tests, NULL, NULL);
}
