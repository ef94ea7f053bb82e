/* ppm on the factored form J W J' + S: the same w as on the formed matrix, linear memory. */
#include "tests/support/check.h"

#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"
#include "tests/support/few_bodies.h"

#include <string.h>

enum { N_MAX = 80, OPT_MAX = 512 };

static size_t run(const lcp_problem *p, double *z, lcp_result *res) {
  const lcp_solver *s = lcp_solver_find("ppm");
  const lcp_capacity cap = lcp_problem_capacity(p);
  _Alignas(16) unsigned char opt[OPT_MAX] = {0};
  base_error err = {0};
  lcp_instance *k;
  lcp_verdict v;
  base_fields_default(s->fields, s->n_fields, opt);
  check_ok(lcp_instance_open(&k, s, &cap, opt, &err), &err);
  check_ok(lcp_instance_prepare(k, p, &err), &err);
  assert_int_equal(lcp_instance_storage(k), p->M.storage);
  const long before = check_heap_calls;
  check_ok(lcp_instance_solve(k, NULL, z, res, &err), &err);
  assert_int_equal(check_heap_calls, before);
  assert_int_equal(res->outcome, LCP_SOLVED);
  check_ok(lcp_judge(p, z, &v, &err), &err);
  check_close(v.rho, 0, 1e-13);
  const size_t bytes = lcp_instance_bytes(k);
  lcp_instance_close(k);
  return bytes;
}

/* Both storages of p give the same w, which is unique: M is positive semidefinite. */
static void check_storages(const lcp_problem *p) {
  static double M[N_MAX * N_MAX];
  const int n = p->M.n;
  assert_true(n <= N_MAX);
  double z[N_MAX] = {0};
  double other[N_MAX] = {0};
  lcp_result res;
  lcp_problem dense = *p;
  lcp_matrix_to_dense(&p->M, M);
  dense.M = (lcp_matrix){.storage = LCP_DENSE, .n = n, .val = M};
  (void)run(p, z, &res);
  (void)run(&dense, other, &res);
  for (int i = 0; i < n; i++) {
    double gap = 0;
    for (int j = 0; j < n; j++) {
      gap += M[j * n + i] * (z[j] - other[j]);
    }
    check_close(gap, 0, 1e-12); /* q is of size 0.1, M below 50 */
  }
  (void)run(p, z, &res); /* z holds the answer */
  assert_int_equal(res.work.pivots, 0);
}

static void both_storages_agree(void **state) {
  (void)state;
  static const int shape[][2] = {{1, 40}, {1, 3}, {5, 60}, {8, 30}, {3, 80}};
  for (int k = 0; k < BASE_COUNT(shape); k++) {
    known_lcp b;
    base_error err = {0};
    check_ok(few_bodies(&b, shape[k][0], shape[k][1], 0, (uint64_t)k, &err), &err);
    check_storages(&b.p);
    lcp_block block[2] = {{.start = 0, .size = 2, .set = LCP_FREE},
                          {.start = 2, .size = b.p.M.n - 2, .set = LCP_ORTHANT}};
    b.p.block = block; /* two of the contacts become joints */
    b.p.n_block = 2;
    check_storages(&b.p);
    known_lcp_free(&b);
  }
}

/* Compliant contacts, S = c I: every row may carry load, more than there are velocities. */
static void compliance_is_kept(void **state) {
  (void)state;
  enum { CONTACTS = 24 };
  known_lcp b;
  base_error err = {0};
  int colptr[CONTACTS + 1];
  int rowind[CONTACTS];
  double val[CONTACTS];
  check_ok(few_bodies(&b, 1, CONTACTS, 0, 9, &err), &err);
  for (int i = 0; i < CONTACTS; i++) {
    colptr[i] = rowind[i] = i;
    val[i] = 0.5;
  }
  colptr[CONTACTS] = CONTACTS;
  const lcp_csc S = {CONTACTS, CONTACTS, colptr, rowind, val};
  lcp_factored f = *b.p.M.factored;
  f.shift = &S;
  b.p.M.factored = &f;
  check_storages(&b.p);
  double z[CONTACTS] = {0};
  lcp_result res;
  (void)run(&b.p, z, &res);
  int carrying = 0;
  for (int i = 0; i < CONTACTS; i++) {
    carrying += z[i] > 0;
  }
  assert_true(carrying > 6);
  known_lcp_free(&b);
}

static void memory_is_linear_in_contacts(void **state) {
  (void)state;
  size_t bytes[2];
  for (int k = 0; k < 2; k++) {
    known_lcp b;
    base_error err = {0};
    lcp_result res;
    const int contacts = (k == 0) ? 200 : 400;
    double z[400] = {0};
    check_ok(few_bodies(&b, 2, contacts, 0, 5, &err), &err);
    bytes[k] = run(&b.p, z, &res);
    known_lcp_free(&b);
  }
  assert_true(bytes[1] <= 2 * bytes[0]);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(both_storages_agree),
      cmocka_unit_test(compliance_is_kept),
      cmocka_unit_test(memory_is_linear_in_contacts),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
