/* Readers: what they accept, and that every hostile file is refused with its line and a rule. */
#include "tests/support/check.h"

#include "lcp/io/lcp_read.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define BANNER "%%MatrixMarket matrix "

static char m_path[64], q_path[64];

static int make_paths(void **state) {
  (void)state;
  (void)snprintf(m_path, sizeof m_path, "/tmp/lcp_read_%ld_M.mtx", (long)getpid());
  (void)snprintf(q_path, sizeof q_path, "/tmp/lcp_read_%ld_q.mtx", (long)getpid());
  return 0;
}

static int drop_paths(void **state) {
  (void)state;
  (void)remove(m_path);
  (void)remove(q_path);
  return 0;
}

static void put(const char *path, const char *text) {
  FILE *f = fopen(path, "w");
  assert_non_null(f);
  assert_true(fputs(text, f) >= 0 && fclose(f) == 0);
}

static void check_pair(const char *m, const char *q, const double *want) {
  base_error err = {0};
  lcp_file_problem f;
  double dense[4];
  put(m_path, m);
  put(q_path, q);
  check_ok(lcp_read_mtx(m_path, q_path, &f, &err), &err);
  assert_int_equal(f.p.M.n, 2);
  lcp_matrix_to_dense(&f.p.M, dense);
  assert_memory_equal(dense, want, sizeof dense);
  check_close(f.p.q[0], -1.5, 0.0);
  check_close(f.p.q[1], 0.0, 0.0);
  lcp_file_problem_free(&f);
}

static void accepts_the_forms_of_the_format(void **state) {
  (void)state;
  const char *q = BANNER "array real general\n2 1\n-1.5\n0\n";
  const char *sparse_q = BANNER "coordinate real general\n% a remark\n2 1 1\n1 1 -1.5\n";
  const double full[] = {1, 3, 2, 4};
  const double sym[] = {1, 3, 3, 4};
  const double skew[] = {0, 3, -3, 0};
  const double part[] = {0, 3, 0, 4};
  check_pair(BANNER "array real general\n2 2\n1\n3\n2\n4\n", q, full);
  check_pair(BANNER "array integer symmetric\n2 2\n1\n3\n4\n", sparse_q, sym);
  check_pair(BANNER "array real skew-symmetric\n2 2\n3\n", q, skew);
  check_pair(BANNER "coordinate real symmetric\n2 2 3\n2 2 4\n1 1 1\n2 1 3", q, sym);
  check_pair(BANNER "coordinate real general\n2 2 2\n2 2 4\n2 1 3\n", q, part);
}

static void refuses_hostile_matrices(void **state) {
  (void)state;
  static const struct {
    const char *text, *says;
  } bad[] = {
      {"", "MatrixMarket"},
      {"%%MatrixMarket tensor coordinate real general\n", "tensor"},
      {BANNER "coordinate complex general\n1 1 1\n1 1 1 0\n", "complex"},
      {BANNER "coordinate pattern general\n1 1 1\n1 1\n", "pattern"},
      {BANNER "coordinate real hermitian\n1 1 1\n1 1 1\n", "hermitian"},
      {BANNER "coordinate real general\n2 3 1\n1 1 1\n", "square"},
      {BANNER "coordinate real general\n-2 2 1\n1 1 1\n", "rows"},
      {BANNER "coordinate real general\n99999999 99999999 0\n", "announces"},
      {BANNER "coordinate real general\n2 2 900000000\n1 1 1\n", "announces"},
      {BANNER "array real general\n30000 30000\n1\n", "announces"},
      {BANNER "coordinate real general\n2 2 1\n3 1 1\n", ":3"},
      {BANNER "coordinate real general\n2 2 1\n0 1 1\n", ":3"},
      {BANNER "coordinate real general\n2 2 1\n1 1 nan\n", ":3"},
      {BANNER "coordinate real general\n2 2 1\n1 1 1e999\n", ":3"},
      {BANNER "coordinate real general\n2 2 1\n1 1 one\n", ":3"},
      {BANNER "coordinate real general\n2 2 2\n1 1 1.25\n1 1 2.5\n", "twice"},
      {BANNER "array real general\n2 2\n1.5\n2.5\n3.5\n", "entry"},
      {BANNER "array real general\n1 1\n1.5\n2.5\n", "'2.5' after the last"},
      {BANNER "coordinate real general\n2 2 1\n1 1 1\n2 2 1\n", "'2' after the last"},
  };
  put(q_path, BANNER "array real general\n2 1\n-1.5\n0\n");
  for (int i = 0; i < BASE_COUNT(bad); i++) {
    base_error err = {0};
    lcp_file_problem f;
    put(m_path, bad[i].text);
    assert_int_not_equal(lcp_read_mtx(m_path, q_path, &f, &err), BASE_OK);
    if (strstr(err.text, bad[i].says) == NULL) {
      fail_msg("case %d: '%s' does not say '%s'", i, err.text, bad[i].says);
    }
    assert_int_equal(f.n_owned, 0); /* nothing left to free */
  }
}

static void refuses_the_wrong_vector(void **state) {
  (void)state;
  base_error err = {0};
  double x[3] = {0};
  put(q_path, BANNER "array real general\n2 1\n-1.5\n0\n");
  assert_int_not_equal(lcp_read_mtx_vector(q_path, 3, x, &err), BASE_OK);
  assert_int_equal(lcp_read_mtx_vector("/nowhere/at/all", 3, x, &err), BASE_EIO);
  const double out[] = {0.1, -0x1p-1074, 1e300};
  check_ok(lcp_write_mtx_vector(q_path, 3, out, &err), &err);
  check_ok(lcp_read_mtx_vector(q_path, 3, x, &err), &err);
  assert_memory_equal(x, out, sizeof out); /* 17 digits read back to the bit */
  assert_int_equal(lcp_write_mtx_vector("/nowhere/at/all", 3, out, &err), BASE_EIO);
}

static void siconos_text(void **state) {
  (void)state;
  base_error err = {0};
  lcp_file_problem f;
  put(m_path, "2\n0\n2\n2\n2\t2\n1.5 2.5\n3.5 4.5\n-1 -2\n\na remark z = (1, 2)\n");
  check_ok(lcp_read_siconos(m_path, &f, &err), &err);
  check_close(f.p.M.val[1], 2.5, 0.0); /* column by column */
  check_close(f.p.q[1], -2.0, 0.0);
  lcp_file_problem_free(&f);
  static const char *const bad[] = {
      "",
      "0\n",
      "2\n1\n2\n2\n2 2\n",
      "2\n0\n3\n2\n2 2\n1 2 3 4 5 6\n",
      "900000\n0\n900000\n900000\n",
      "2\n0\n2\n2\n2 2\n1 2 3 inf\n-1 -1\n",
      "2\n0\n2\n2\n2 2\n1 2 3 4\n-1 x\n",
  };
  for (int i = 0; i < BASE_COUNT(bad); i++) {
    put(m_path, bad[i]);
    assert_int_not_equal(lcp_read_siconos(m_path, &f, &err), BASE_OK);
    assert_non_null(strstr(err.text, m_path));
    assert_int_equal(f.n_owned, 0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(accepts_the_forms_of_the_format, make_paths, drop_paths),
      cmocka_unit_test_setup_teardown(refuses_hostile_matrices, make_paths, drop_paths),
      cmocka_unit_test_setup_teardown(refuses_the_wrong_vector, make_paths, drop_paths),
      cmocka_unit_test_setup_teardown(siconos_text, make_paths, drop_paths),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
