/* The C library through its header and its shared object alone: what it refuses, in one line each, and what it answers. */
#include "tests/support/check.h"

#include "include/lcpbench/lcpbench.h"

#include <math.h>
#include <string.h>

static const double M2[] = {2, 1, -1, 2}; /* not symmetric */
static const double Q2[] = {-3, -1};

static void refused(int code, int want, const char *names) {
  assert_int_equal(code, want);
  assert_non_null(strstr(lcp_last_error(), names));
}

static void no_handle(const lcp_problem *p, const char *names) {
  assert_null(p);
  assert_non_null(strstr(lcp_last_error(), names));
}

static void problems_are_checked(void **state) {
  (void)state;
  const double bad[] = {1, 0, 0, (double)NAN};
  const int colptr[] = {0, 2, 3}, unsorted[] = {1, 0, 1}, decreasing[] = {0, 2, 1};
  const double val[] = {1, 2, 3};
  no_handle(lcp_problem_dense(0, M2, 0, Q2), "n=0");
  no_handle(lcp_problem_dense(2, NULL, 0, Q2), "M");
  no_handle(lcp_problem_dense(2, M2, 0, NULL), "q");
  no_handle(lcp_problem_dense(2, bad, 0, Q2), "M[3]");
  no_handle(lcp_problem_csc(2, colptr, unsorted, val, Q2), "increasing");
  no_handle(lcp_problem_csc(2, decreasing, unsorted, val, Q2), "decrease");
  no_handle(lcp_problem_csc(2, NULL, unsorted, val, Q2), "missing");
  lcp_problem_free(NULL);
}

static void rows_and_columns(void **state) {
  (void)state;
  const double z[] = {1, 3};
  double w[2];
  lcp_problem *rows = lcp_problem_dense(2, M2, 1, Q2), *columns = lcp_problem_dense(2, M2, 0, Q2);
  assert_int_equal(lcp_problem_size(rows), 2);
  assert_int_equal(lcp_residual(rows, z, w), LCP_OK);
  check_close(w[0], 2 + 3 - 3, 0.0);
  check_close(w[1], -1 + 6 - 1, 0.0);
  assert_int_equal(lcp_residual(columns, z, w), LCP_OK);
  check_close(w[0], 2 - 3 - 3, 0.0);
  const double other[] = {1, 5, 0, 1}, q[] = {0, 0};
  assert_int_equal(lcp_problem_set_values(rows, other), LCP_OK);
  assert_int_equal(lcp_problem_set_q(rows, q), LCP_OK);
  assert_int_equal(lcp_residual(rows, z, w), LCP_OK);
  check_close(w[0], 16, 0.0);
  check_close(w[1], 3, 0.0);
  const double nan[] = {0, (double)NAN};
  refused(lcp_problem_set_q(rows, nan), LCP_INVALID, "q[1]");
  lcp_problem_free(rows);
  lcp_problem_free(columns);
}

static void answers_are_judged(void **state) {
  (void)state;
  double z[] = {0, 0};
  lcp_report r;
  lcp_problem *p = lcp_problem_dense(2, M2, 1, Q2); /* z = (1, 1) */
  assert_int_equal(lcp_solve(p, "lemke", z, &r), LCP_OK);
  check_close(z[0], 1.0, 1e-12);
  check_close(z[1], 1.0, 1e-12);
  assert_string_equal(r.solver, "lemke");
  assert_string_equal(r.status, "ok");
  assert_true(r.verified && r.rho < 1e-9);
  assert_int_equal(lcp_verify(p, z, 1e-9, NULL), LCP_OK);
  z[0] = 1.1;
  assert_int_equal(lcp_verify(p, z, 1e-9, &r), LCP_UNSOLVED);
  assert_true(!r.verified && r.rho > 1e-3);
  z[0] = (double)NAN;
  assert_int_equal(lcp_verify(p, z, 1e-9, NULL), LCP_UNSOLVED);
  refused(lcp_verify(p, z, 0.0, NULL), LCP_INVALID, "tolerance");
  memset(z, 0, sizeof z);
  assert_int_equal(lcp_solve(p, "pgs:max_iter=1", z, &r), LCP_UNSOLVED);
  assert_string_equal(r.status, "max_iter");
  refused(lcp_solve(p, "pgs:omega=7", z, NULL), LCP_INVALID, "omega");
  refused(lcp_solve(p, "lemkee", z, NULL), LCP_INVALID, "lemke");
  assert_int_equal(lcp_solve(p, NULL, z, NULL), LCP_OK);
  lcp_problem_free(p);

  const double none[] = {-1, 0, 0, -1}, q[] = {-1, -1};
  p = lcp_problem_dense(2, none, 0, q);
  assert_int_equal(lcp_solve(p, "lemke", z, &r), LCP_UNSOLVED);
  assert_string_equal(r.status, "infeasible");
  lcp_problem_free(p);
}

static void sets(void **state) {
  (void)state;
  const double I3[] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, q[] = {-2, -2, -2};
  const double lo[] = {0, -HUGE_VAL, -1}, hi[] = {1, HUGE_VAL, 1}, crossed[] = {0, 0, 2};
  const int start[] = {0}, size[] = {3}, late[] = {1}, twice[] = {0, 2}, sizes[] = {3, 1};
  const double mu[] = {0.5, 0.5};
  double z[] = {0, 0, 0};
  lcp_problem *p = lcp_problem_dense(3, I3, 0, q);
  assert_int_equal(lcp_problem_set_bounds(p, lo, hi), LCP_OK);
  refused(lcp_problem_set_bounds(p, crossed, hi), LCP_INVALID, "row 2"); /* as it was */
  assert_int_equal(lcp_solve(p, NULL, z, NULL), LCP_OK);
  check_close(z[0], 1.0, 1e-6);
  check_close(z[1], 2.0, 1e-6);
  check_close(z[2], 1.0, 1e-6);
  refused(lcp_solve(p, "lemke", z, NULL), LCP_UNSUPPORTED, "box");
  refused(lcp_problem_set_cones(p, 1, late, size, mu), LCP_INVALID, "cone 0");
  refused(lcp_problem_set_cones(p, 2, twice, sizes, mu), LCP_INVALID, "cone 1");
  assert_int_equal(lcp_problem_set_cones(p, 1, start, size, mu), LCP_OK);
  assert_string_equal(lcp_default_solver(p), "cone_newton");
  memset(z, 0, sizeof z);
  assert_int_equal(lcp_solve(p, NULL, z, NULL), LCP_OK);
  check_close(hypot(z[1], z[2]), 0.5 * z[0], 1e-6); /* it slides */
  assert_int_equal(lcp_problem_set_cones(p, 0, NULL, NULL, NULL), LCP_OK);
  refused(lcp_problem_declare(p, "positive"), LCP_INVALID, "positive");
  assert_int_equal(lcp_problem_declare(p, "pd"), LCP_OK);
  lcp_problem_free(p);
}

static void lists(void **state) {
  (void)state;
  char text[640], little[8];
  lcp_solver_info s;
  lcp_option_info o;
  const int n = lcp_solver_count();
  assert_true(n >= 17);
  for (int i = 0; i < n; i++) {
    assert_int_equal(lcp_solver_describe(i, &s), LCP_OK);
    assert_int_equal(lcp_options(s.name, text, sizeof text), LCP_OK);
    for (int k = 0; k < s.n_option; k++) {
      assert_int_equal(lcp_option_describe(i, k, &o), LCP_OK);
      assert_non_null(strstr(text, o.name));
    }
    refused(lcp_option_describe(i, s.n_option, &o), LCP_INVALID, s.name);
  }
  refused(lcp_solver_describe(n, &s), LCP_INVALID, "solver");
  refused(lcp_options("lemke", little, sizeof little), LCP_INVALID, "bytes");
  assert_null(lcp_workspace_new("lemkee"));
  assert_null(lcp_workspace_new(NULL));
  lcp_workspace_free(NULL);
}

static void a_step(void **state) {
  (void)state;
  const double mass[] = {1, 0}, zeros[18] = {0}, point[] = {0, 0, 0}, up[] = {0, 0, 1};
  const double long_[] = {0, 0, 2}, mu[] = {0.5};
  const int ground[] = {0, -1}, fixed[] = {1, -1}, itself[] = {0, 0};
  double v[12] = {1, 0, -1}, impulse[3] = {0};
  lcp_contacts c = {2, mass, zeros, zeros, 1, ground, point, up, mu, NULL};
  lcp_report r;
  assert_int_equal(lcp_contact_step(&c, NULL, v, impulse, &r), LCP_OK); /* lands, and slides on */
  check_close(v[2], 0.0, 1e-8);
  check_close(v[0], 0.5, 1e-8);
  check_close(impulse[2], 1.0, 1e-8);
  check_close(impulse[0], -0.5, 1e-8);
  const double bounce[] = {-0.5};
  c.bias = bounce; /* leaves at 0.5 m/s */
  v[0] = 0, v[2] = -1;
  assert_int_equal(lcp_contact_step(&c, "nsgs", v, impulse, NULL), LCP_OK);
  check_close(v[2], 0.5, 1e-6);
  c.body = fixed;
  refused(lcp_contact_step(&c, NULL, v, impulse, NULL), LCP_INVALID, "can move");
  c.body = itself;
  refused(lcp_contact_step(&c, NULL, v, impulse, NULL), LCP_INVALID, "bodies 0 and 0");
  c.body = ground, c.normal = long_;
  refused(lcp_contact_step(&c, NULL, v, impulse, NULL), LCP_INVALID, "length one");
  c.normal = up;
  refused(lcp_contact_step(&c, "lemke", v, impulse, NULL), LCP_UNSUPPORTED, "cone");
  check_close(v[2], 0.5, 1e-6); /* untouched */
  c.n_contact = 0;
  assert_int_equal(lcp_contact_step(&c, NULL, v, impulse, NULL), LCP_OK);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(problems_are_checked),
      cmocka_unit_test(rows_and_columns),
      cmocka_unit_test(answers_are_judged),
      cmocka_unit_test(sets),
      cmocka_unit_test(lists),
      cmocka_unit_test(a_step),
  };
  return cmocka_run_group_tests_name("library", tests, NULL, NULL);
}
