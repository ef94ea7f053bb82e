/* Storages agree: a factored matrix against its own dense and sparse copies, and the judge against
 * numbers worked by hand. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/lcp_cone.h"
#include "lcp/lcp_judge.h"
#include "lcp/lcp_rho.h"
#include "lcp/lcp_wide_column.h"

#include <string.h>

enum { N_BODY = 3, N_GROUP = 5, N_ROW = 12, N_DOF = 7 };

/* Bodies of 3, 1 and 3 dofs; groups of 3, 2, 1, 3, 3 rows, one on a single body, one on one body
 * twice removed, and a shift on some rows, also of groups without a common body. */
typedef struct fixture {
  double weight[9 + 1 + 9], jac[128];
  int jac_start[N_GROUP + 1];
  lcp_csc shift;
  lcp_factored f;
  lcp_matrix M;
} fixture;

static const int dof_start[] = {0, 3, 4, 7}, weight_start[] = {0, 9, 10, 19};
static const int row_start[] = {0, 3, 5, 6, 9, 12};
static const int body[] = {0, 1, 0, -1, -1, 1, 2, 0, 1, 2};
static const int shift_ptr[] = {0, 1, 1, 1, 1, 3, 4, 4, 4, 4, 4, 4, 4};
static const int shift_row[] = {4, 0, 4, 3};
static const double shift_val[] = {0.25, -0.5, 1.5, 0.75};
/* The same with one group on no body at all, and S inside groups alone, as formulations pose it. */
static const int alone[] = {0, 1, 0, -1, -1, -1, 2, 0, 1, 2};
static const int own_ptr[] = {0, 1, 1, 1, 1, 3, 4, 5, 5, 5, 5, 5, 5};
static const int own_row[] = {1, 3, 4, 5, 8};
static const double own_val[] = {0.25, -0.5, 1.5, 0.75, -2.0};

static void build_on(fixture *x, const int *bodies, lcp_csc shift) {
  base_rng r = base_rng_seeded(20161105);
  memset(x, 0, sizeof *x);
  for (int b = 0; b < N_BODY; b++) {
    const int n = dof_start[b + 1] - dof_start[b];
    for (int i = 0; i < n; i++) {
      for (int j = 0; j <= i; j++) {
        const double w = (i == j) ? 2.0 + base_rng_uniform(&r) : base_rng_between(&r, -0.4, 0.4);
        x->weight[weight_start[b] + i * n + j] = x->weight[weight_start[b] + j * n + i] = w;
      }
    }
  }
  int used = 0;
  for (int g = 0; g < N_GROUP; g++) {
    x->jac_start[g] = used;
    for (int side = 0; side < 2; side++) {
      const int b = bodies[2 * g + side];
      const int dofs = (b >= 0) ? dof_start[b + 1] - dof_start[b] : 0;
      for (int k = 0; k < dofs * (row_start[g + 1] - row_start[g]); k++) {
        x->jac[used++] = base_rng_between(&r, -1.0, 1.0);
      }
    }
  }
  x->jac_start[N_GROUP] = used;
  x->shift = shift;
  x->f = (lcp_factored){N_BODY, dof_start,    weight_start, x->weight, N_GROUP, row_start,
                        bodies, x->jac_start, x->jac,       &x->shift, NULL,    NULL};
  x->M = (lcp_matrix){.storage = LCP_FACTORED, .n = N_ROW, .factored = &x->f};
}

static void build(fixture *x) {
  build_on(x, body, (lcp_csc){N_ROW, N_ROW, shift_ptr, shift_row, shift_val});
}

static void storages_agree(void **state) {
  (void)state;
  fixture x;
  base_error err = {0};
  build(&x);
  double dense[N_ROW * N_ROW], d[N_ROW], scratch[2 * N_DOF], y[N_ROW], z[N_ROW];
  lcp_matrix_to_dense(&x.M, dense);
  assert_int_equal(lcp_matrix_scratch(&x.M), 2 * N_DOF);
  lcp_csc copy;
  check_ok(lcp_matrix_to_csc(&x.M, &copy, &err), &err);
  const lcp_matrix D = {.storage = LCP_DENSE, .n = N_ROW, .val = dense};
  const lcp_matrix S = {.storage = LCP_CSC, .n = N_ROW, .csc = copy};
  for (int i = 0; i < N_ROW; i++) {
    z[i] = 0.3 * i - 1.1;
  }
  double want[N_ROW] = {0};
  for (int j = 0; j < N_ROW; j++) {
    for (int i = 0; i < N_ROW; i++) {
      want[i] += dense[j * N_ROW + i] * z[j];
    }
  }
  const lcp_matrix *all[] = {&x.M, &D, &S};
  for (int k = 0; k < 3; k++) {
    lcp_matrix_apply(all[k], z, NULL, y, scratch);
    lcp_matrix_diagonal(all[k], d);
    for (int i = 0; i < N_ROW; i++) {
      check_close(y[i], want[i], 1e-13);
      check_close(d[i], dense[i * N_ROW + i], 1e-14);
    }
  }
  assert_false(lcp_matrix_is_symmetric(&D)); /* the shift is not symmetric */
  lcp_csc_free(&copy);
}

/* The product J (W (J' e_j)) is an independent way to column j. */
static void dense_copy_matches_products(void **state) {
  (void)state;
  fixture x;
  build(&x);
  double dense[N_ROW * N_ROW], y[N_ROW], scratch[2 * N_DOF];
  lcp_matrix_to_dense(&x.M, dense);
  for (int j = 0; j < N_ROW; j++) {
    double e[N_ROW] = {0};
    e[j] = 1.0;
    lcp_matrix_apply(&x.M, e, NULL, y, scratch);
    for (int i = 0; i < N_ROW; i++) {
      check_close(dense[j * N_ROW + i], y[i], 1e-13);
    }
  }
}

static const double two[] = {2.0, 1.0, 1.0, 2.0};

static void judge_matches_hand_work(void **state) {
  (void)state;
  base_error err = {0};
  const double q[] = {-5.0, -6.0}, z[] = {4.0 / 3.0, 7.0 / 3.0}, off[] = {1.0, 2.0};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = two}, .q = q};
  lcp_verdict v;
  check_ok(lcp_judge(&p, z, &v, &err), &err);
  assert_true(v.rho < 1e-15 && v.natural < 1e-15);
  check_ok(lcp_judge(&p, off, &v, &err), &err);
  /* w = (-1, -1); tau0 = (9, 11), zref = (4.5, 5.5), tau = (5 + 9 + 5.5, 6 + 4.5 + 11) */
  check_close(v.rho, 1.0 / 19.5, 1e-15);
  check_close(v.natural, 1.0, 0.0);
  check_close(v.natural_rel, 1.0 / 7.0, 1e-15);
  check_close(v.infeasible_w, 1.0, 0.0);
  check_close(v.comp, 3.0, 0.0);
}

/* D1 M D2, D1 q, z / D2 with powers of two leaves rho to the last bit. */
static void rho_ignores_scaling(void **state) {
  (void)state;
  base_error err = {0};
  const double d1[] = {0x1p300, 0x1p-40}, d2[] = {0x1p-120, 0x1p90};
  const double q[] = {-5.0, -6.0}, z[] = {1.0, 2.0};
  double M[4], sq[2], sz[2];
  for (int i = 0; i < 2; i++) {
    sq[i] = d1[i] * q[i];
    sz[i] = z[i] / d2[i];
    for (int j = 0; j < 2; j++) {
      M[2 * j + i] = d1[i] * two[2 * j + i] * d2[j];
    }
  }
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = two}, .q = q};
  const lcp_problem s = {.M = {.storage = LCP_DENSE, .n = 2, .val = M}, .q = sq};
  lcp_verdict a, b;
  check_ok(lcp_judge(&p, z, &a, &err), &err);
  check_ok(lcp_judge(&s, sz, &b, &err), &err);
  assert_true(a.rho == b.rho);
}

/* The sums over a factored matrix against its columns, and the verdict on it against that on its dense copy. Every `few`th entry of
 * z is `tiny` times as large. */
static void judge_factors(const fixture *x, int few, double tiny) {
  base_error err = {0};
  lcp_wide_columns c;
  double dense[N_ROW * N_ROW], z[N_ROW], q[N_ROW], d[N_ROW];
  long double size_of[N_ROW], w[N_ROW] = {0}, size[N_ROW] = {0};
  long double want[N_ROW] = {0}, sizes[N_ROW] = {0};
  for (int i = 0; i < N_ROW; i++) {
    z[i] = ((i % 3 == 2) ? 0.0 : 0.3 * i - 1.1) * ((i % few == 0) ? tiny : 1.0);
    q[i] = 0.7 - 0.2 * i;
    size_of[i] = fabs(z[i]);
  }
  check_ok(lcp_wide_columns_open(&c, &x->M, &err), &err);
  lcp_wide_factored_product(&c, z, w);
  lcp_wide_factored_sizes(&c, size_of, size);
  lcp_wide_factored_diagonal(&c, d);
  for (int j = 0; j < N_ROW; j++) {
    const lcp_wide_column col = lcp_wide_columns_at(&c, j);
    for (int k = 0; k < col.count; k++) {
      want[col.row[k]] += col.val[k] * z[j];
      sizes[col.row[k]] += fabsl(col.val[k] * z[j]);
      assert_true(col.row[k] != j || d[j] == (double)col.val[k]);
    }
  }
  lcp_wide_columns_close(&c);
  for (int i = 0; i < N_ROW; i++) {
    assert_true(fabsl(w[i] - want[i]) <= 1e-17L * sizes[i]);
    assert_true(fabsl(size[i] - sizes[i]) <= 4e-16L * sizes[i]);
  }
  lcp_matrix_to_dense(&x->M, dense);
  const lcp_problem p = {.M = x->M, .q = q};
  const lcp_problem s = {.M = {.storage = LCP_DENSE, .n = N_ROW, .val = dense}, .q = q};
  lcp_verdict a, b;
  check_ok(lcp_judge(&p, z, &a, &err), &err);
  check_ok(lcp_judge(&s, z, &b, &err), &err);
  assert_true(b.rho > 0.01);
  check_close(a.rho, b.rho, 1e-14);
  check_close(a.natural, b.natural, 1e-14);
  check_close(a.comp, b.comp, 1e-14);
}

/* With entries that sums in double have no room for, some of them or all. */
static void judge_reads_factors(void **state) {
  static const struct {
    int few;
    double tiny;
  } given[] = {{1, 1.0}, {5, 1e-230}, {2, 1e-310}, {1, 1e-250}};
  const lcp_csc own = {N_ROW, N_ROW, own_ptr, own_row, own_val};
  (void)state;
  for (int k = 0; k < BASE_COUNT(given); k++) {
    fixture x;
    build(&x);
    judge_factors(&x, given[k].few, given[k].tiny);
    build_on(&x, alone, own);
    judge_factors(&x, given[k].few, given[k].tiny);
  }
}

/* tau0 / d is beyond double: z = 0 leaves w = q, which solves q = 1 and not q = -1, whose row has the scale 1 + 1. */
static void judge_weighs_tiny_pivots(void **state) {
  (void)state;
  base_error err = {0};
  const double tiny = 1e-310, z = 0.0, q[] = {-1.0, 1.0};
  lcp_verdict v;
  for (int k = 0; k < 2; k++) {
    const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 1, .val = &tiny}, .q = q + k};
    check_ok(lcp_judge(&p, &z, &v, &err), &err);
    assert_true(v.rho == ((k == 0) ? 0.5 : 0.0));
  }
}

/* A sweep that diverges on a P-matrix: at 1e306 the scales overflow before w does, and no such point solves anything. */
static void overflow_is_no_solution(void **state) {
  (void)state;
  base_error err = {0};
  const double M[] = {1.0, 60.0, -60.0, 1.0}, q[] = {-1.0, -1.0}, d[] = {1.0, 1.0};
  const double z[] = {1e306, 1e306};
  double w[2], zref[2], tau[2];
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = M}, .q = q};
  lcp_verdict v;
  lcp_rho_product(&p, z, w, tau);
  lcp_rho_references(&p, d, tau, zref);
  lcp_rho_product(&p, zref, NULL, tau);
  assert_true(isfinite(w[0]) && isfinite(w[1]) && isinf(tau[0]));
  assert_false(lcp_rho(&p, d, z, w, zref, tau) <= 1.0);
  check_ok(lcp_judge(&p, z, &v, &err), &err);
  assert_true(v.rho > 0.01);
}

static void judge_refuses_nan(void **state) {
  (void)state;
  base_error err = {0};
  const double q[] = {1.0, 1.0}, z[] = {0.0, NAN};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = two}, .q = q};
  lcp_verdict v;
  check_ok(lcp_judge(&p, z, &v, &err), &err);
  assert_false(v.finite);
  assert_true(v.rho == HUGE_VAL);
}

/* The projection is characterised by: result in K, x - result in the polar cone, orthogonal. */
static void cone_projection_is_exact(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(7);
  const lcp_block b = {
      .size = 6, .set = LCP_CONE, .n_part = 3, .part_dim = {2, 1, 2}, .part_mu = {0.7, 0.05, 0.3}};
  for (int trial = 0; trial < 2000; trial++) {
    double x[6], p[6], rest[6], dot = 0.0;
    for (int i = 0; i < 6; i++) {
      x[i] = base_rng_normal(&r);
    }
    lcp_cone_project(&b, x, p);
    assert_true(lcp_cone_violation(&b, p) < 1e-15);
    for (int i = 0; i < 6; i++) {
      rest[i] = p[i] - x[i];
      dot += rest[i] * p[i];
    }
    check_close(dot, 0.0, 1e-14);
    assert_true(rest[0] >= lcp_cone_shift(&b, rest) - 1e-14); /* rest in the dual cone */
  }
}

static void check_names_the_culprit(void **state) {
  (void)state;
  base_error err = {0};
  const double q[] = {1.0, NAN};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = two}, .q = q};
  assert_int_equal(lcp_problem_check(&p, &err), BASE_EINVAL);
  assert_non_null(strstr(err.text, "q[1]"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(storages_agree),           cmocka_unit_test(dense_copy_matches_products),
      cmocka_unit_test(judge_matches_hand_work),  cmocka_unit_test(rho_ignores_scaling),
      cmocka_unit_test(judge_reads_factors),      cmocka_unit_test(judge_weighs_tiny_pivots),
      cmocka_unit_test(overflow_is_no_solution),  cmocka_unit_test(judge_refuses_nan),
      cmocka_unit_test(cone_projection_is_exact), cmocka_unit_test(check_names_the_culprit),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
