/* Every registered family: passes the problem check, and its stated answer is one. */
#include "tests/support/check.h"

#include "problems/families/family.h"

#include <stdio.h>
#include <string.h>

/* Largest violation of w = M z + q, z, w >= 0, z w = 0, row by row relative to its own terms. */
static double defect(const lcp_problem *p, const double *z) {
  const size_t n = (size_t)p->M.n;
  double *w = calloc(n + 1, sizeof *w), *size = calloc(n + 1, sizeof *w),
         *dense = calloc(n * n + 1, sizeof *w), worst = 0.0;
  assert_true(w != NULL && size != NULL && dense != NULL);
  lcp_matrix_to_dense(&p->M, dense);
  for (size_t j = 0; j < n; j++) {
    for (size_t i = 0; i < n; i++) {
      w[i] += dense[j * n + i] * z[j];
      size[i] += fabs(dense[j * n + i] * z[j]);
    }
  }
  for (size_t i = 0; i < n; i++) {
    const double rel = (w[i] + p->q[i]) / (size[i] + fabs(p->q[i]) + 1e-300);
    worst = fmax(worst, fmax(-rel, (z[i] > 0.0) ? fabs(rel) : 0.0));
    worst = fmax(worst, -z[i]);
  }
  free(w);
  free(size);
  free(dense);
  return worst;
}

/* y >= 0, M'y <= 0, q.y < 0 prove that no z >= 0 has M z + q >= 0. */
static void check_farkas(const lcp_problem *p, const double *y) {
  const int n = p->M.n;
  double dense[64], gain = 0.0;
  assert_true(n <= 8);
  lcp_matrix_to_dense(&p->M, dense);
  for (int j = 0; j < n; j++) {
    double column = 0.0;
    for (int i = 0; i < n; i++) {
      column += dense[j * n + i] * y[i];
    }
    assert_true(y[j] >= 0.0 && column <= 0.0);
    gain += p->q[j] * y[j];
  }
  assert_true(gain < 0.0);
}

static void check_family(const char *text) {
  known_lcp k;
  base_error err = {0};
  check_ok(lcp_family_load(text, &k, &err), &err);
  if (k.z != NULL) {
    check_close(defect(&k.p, k.z), 0.0, 1e-12);
  }
  if ((k.answer == KNOWN_UNIQUE && k.z == NULL && strstr(text, "lcg") == NULL) ||
      (k.answer == KNOWN_INFEASIBLE && k.farkas == NULL)) {
    fail_msg("%s states an answer without giving it", text);
  }
  if (k.farkas != NULL) {
    check_farkas(&k.p, k.farkas);
  }
  known_lcp_free(&k);
}

static void every_family_states_the_truth(void **state) {
  (void)state;
  int n;
  const lcp_family *const *all = lcp_families(&n);
  assert_true(n >= 14);
  for (int i = 0; i < n; i++) {
    assert_ptr_equal(lcp_family_find(all[i]->name), all[i]);
    assert_true(strlen(all[i]->about) > 80);
    check_family(all[i]->name);
  }
  static const char *const variants[] = {
      "kostreva:variant=2",
      "kostreva:variant=3",
      "kostreva:variant=4",
      "kostreva:variant=5",
      "murty:n=6,upper=1",
      "murty:n=6,q=hat",
      "random_p:definite=0",
      "random_spd:n=300,degree=0",
      "random_spd:n=1",
      "random_psd:n=7,repeat=3",
      "box_stack:storage=sparse,n=7",
      "box_stack:n=1",
      "subset_sum:solvable=0",
      "subset_sum:n=30,largest=1000",
      "stack:n=1",
      "stack:n=2,mass_ratio=1e6",
      "circulant:n=7,a=0.3,b=0.2",
      "tridiagonal:n=1",
      "lcg:kind=p_nonsym,seed=3",
  };
  for (int i = 0; i < BASE_COUNT(variants); i++) {
    check_family(variants[i]);
  }
}

static void storages_agree(void **state) {
  (void)state;
  known_lcp a, b;
  base_error err = {0};
  check_ok(lcp_family_load("box_stack:n=3,mass_ratio=7", &a, &err), &err);
  check_ok(lcp_family_load("box_stack:n=3,mass_ratio=7,storage=sparse", &b, &err), &err);
  double A[144], B[144];
  lcp_matrix_to_dense(&a.p.M, A);
  lcp_matrix_to_dense(&b.p.M, B);
  for (int i = 0; i < 144; i++) {
    check_close(A[i], B[i], 1e-14);
  }
  known_lcp_free(&a);
  known_lcp_free(&b);
}

static void wrong_requests_are_refused(void **state) {
  (void)state;
  static const char *const bad[] = {"murty:n=0",
                                    "murty:n=60,q=hat",
                                    "murtyy",
                                    "murty:upper=1,q=hat",
                                    "circulant:a=-3,b=1",
                                    "stack:n=-1",
                                    "tridiagonal:off=5",
                                    "random_spd:n=1000000,degree=200"};
  for (int i = 0; i < BASE_COUNT(bad); i++) {
    known_lcp k;
    base_error err = {0};
    if (lcp_family_load(bad[i], &k, &err) != BASE_EINVAL) {
      fail_msg("accepted: %s", bad[i]);
    }
    assert_true(err.text[0] != '\0' && strchr(err.text, '\n') == NULL);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_family_states_the_truth),
      cmocka_unit_test(storages_agree),
      cmocka_unit_test(wrong_requests_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
