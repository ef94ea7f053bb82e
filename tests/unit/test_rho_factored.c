/* Sizes of the terms of w, where M is held in factors, against those of the dense matrix. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/lcp_rho_factored.h"
#include "tests/support/random_cones.h"

#include <string.h>

/* Memory for p, which the caller frees. */
static void *laid_out(lcp_rho_factored *s, const lcp_problem *p) {
  const lcp_capacity cap = lcp_problem_capacity(p);
  base_arena measure = base_arena_measuring();
  lcp_rho_factored_layout(s, &cap, &measure);
  void *mem = base_alloc(measure.used);
  assert_non_null(mem);
  base_arena real = base_arena_over(mem, measure.used);
  lcp_rho_factored_layout(s, &cap, &real);
  return mem;
}

/* `size` has been summed with s->whole; over some groups the same bits again, the others are left alone. */
static void some_are_summed_again(base_rng *r, lcp_rho_factored *s, const lcp_problem *p,
                                  const double *x, const double *size) {
  const lcp_factored *f = p->M.factored;
  double *other = calloc((size_t)p->M.n, sizeof *other);
  assert_non_null(other);
  for (int i = 0; i < p->M.n; i++) {
    s->again[i] = base_rng_uniform(r) < 0.2;
    other[i] = -1.0;
  }
  lcp_rho_factored_product(s, p, s->again, s->whole, x, other);
  for (int g = 0; g < f->n_group; g++) {
    const size_t rows = (size_t)(f->row_start[g + 1] - f->row_start[g]);
    if (memchr(s->again + f->row_start[g], 1, rows) != NULL) {
      assert_memory_equal(other + f->row_start[g], size + f->row_start[g], rows * sizeof *size);
    }
    for (int i = f->row_start[g];
         memchr(s->again + f->row_start[g], 1, rows) == NULL && i < f->row_start[g + 1]; i++) {
      assert_true(other[i] == -1.0);
    }
  }
  free(other);
}

static bool share_a_body(const lcp_factored *f, int g, int h) {
  bool any = false;
  for (int e = 0; e < 4; e++) {
    const int b = f->body[2 * g + e / 2];
    any = any || (b >= 0 && b == f->body[2 * h + e % 2]);
  }
  return any;
}

/* After a product: with some groups those that share a body with them, and no others. */
static void neighbours_share_a_body(base_rng *r, lcp_rho_factored *s, const lcp_factored *f) {
  unsigned char *rows = s->again;
  bool *asked = calloc((size_t)f->n_group, sizeof *asked);
  assert_non_null(asked);
  for (int g = 0; g < f->n_group; g++) {
    asked[g] = base_rng_uniform(r) < 0.05;
    for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
      rows[i] = asked[g] && i == f->row_start[g + 1] - 1; /* one row stands for its group */
    }
  }
  lcp_rho_factored_neighbours(s, f, rows);
  for (int g = 0; g < f->n_group; g++) {
    bool near = false;
    for (int h = 0; h < f->n_group; h++) {
      near = near || (asked[h] && share_a_body(f, g, h));
    }
    for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
      const bool own = asked[g] && i == f->row_start[g + 1] - 1;
      assert_int_equal(rows[i], near || own);
    }
  }
  free(asked);
}

/* |q| + |M||x| against the dense matrix; S inside the groups. */
static void sizes_are_those_of_the_entries(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(23);
  for (int trial = 0; trial < 40; trial++) {
    known_lcp k;
    base_error err = {0};
    lcp_rho_factored s = {0};
    check_ok(random_cones(&k, (uint64_t)trial + 1, &err), &err);
    const int n = k.p.M.n;
    lcp_factored f = *k.p.M.factored;
    int *colptr = calloc((size_t)n + 1, sizeof *colptr),
        *rowind = calloc((size_t)n, sizeof *rowind);
    double *val = calloc((size_t)n, sizeof *val), *x = calloc((size_t)n, sizeof *x);
    double *dense = calloc((size_t)n * (size_t)n, sizeof *dense),
           *size = calloc((size_t)n, sizeof *size);
    assert_true(colptr && rowind && val && x && dense && size);
    for (int j = 0; j < n; j++) {
      const int g =
          j / 3; /* any row: of the same group, as every third set has groups of three only */
      colptr[j + 1] = j + 1;
      rowind[j] = (trial % 3 == 0) ? 3 * g + (j + 1) % 3 : j;
      val[j] = base_rng_normal(&r);
      x[j] = (base_rng_uniform(&r) < 0.2) ? 0.0 : base_rng_normal(&r);
    }
    const lcp_csc shift = {n, n, colptr, rowind, val};
    f.shift = (trial % 2 == 0) ? &shift : NULL;
    lcp_problem p = k.p;
    p.M.factored = &f;
    lcp_matrix_to_dense(&p.M, dense);
    void *mem = laid_out(&s, &p);
    lcp_rho_factored_product(&s, &p, NULL, NULL, x, size);
    for (int i = 0; i < n; i++) {
      double want = fabs(p.q[i]);
      for (int j = 0; j < n; j++) {
        want += fabs(dense[i + (ptrdiff_t)j * n] * x[j]);
      }
      check_close(size[i], want, 1e-12 * want);
    }
    for (int i = 0; i < n; i++) {
      s.whole[i] = base_rng_uniform(&r) < 0.2;
    }
    lcp_rho_factored_product(&s, &p, NULL, s.whole, x, size);
    for (int g = 0; g < f.n_group; g++) {
      const int first = f.row_start[g], end = f.row_start[g + 1];
      bool whole = false;
      for (int i = first; i < end; i++) {
        whole = whole || s.whole[i];
      }
      for (int i = first; i < end; i++) {
        double want = fabs(p.q[i]);
        for (int j = whole ? 0 : first; j < (whole ? n : end); j++) {
          want += fabs(dense[i + (ptrdiff_t)j * n] * x[j]);
        }
        check_close(size[i], want, 1e-12 * want);
      }
    }
    some_are_summed_again(&r, &s, &p, x, size);
    neighbours_share_a_body(&r, &s, &f);
    free(mem);
    free(colptr);
    free(rowind);
    free(val);
    free(x);
    free(dense);
    free(size);
    known_lcp_free(&k);
  }
}

/* Ten rows of one group, as of eight facets, between bodies of six velocities and of two. */
static void a_wide_group_is_summed_in_strips(void **state) {
  (void)state;
  enum { ROWS = 10, BODIES = 2, DOFS = 8, SHIFTED = 4 };
  static const int dof_start[] = {0, 6, 8}, weight_start[] = {0, 36, 40}, row_start[] = {0, ROWS},
                   body[] = {0, 1}, jac_start[] = {0, ROWS * DOFS},
                   colptr[ROWS + 1] = {0, 1, 1, 1, 1, 1, 1, 1, 1, 1, SHIFTED},
                   rowind[SHIFTED] = {9, 0, 7, 8};
  static const double val[SHIFTED] = {0.5, -2, 1, 3};
  base_rng r = base_rng_seeded(24);
  base_error err = {0};
  double weight[40], jac[ROWS * DOFS], q[ROWS], x[ROWS], size[ROWS], dense[ROWS * ROWS];
  double *const drawn[] = {weight, jac, q, x};
  const int count[] = {40, ROWS * DOFS, ROWS, ROWS};
  for (int k = 0; k < BASE_COUNT(drawn); k++) {
    for (int i = 0; i < count[k]; i++) {
      drawn[k][i] = base_rng_normal(&r);
    }
  }
  for (int b = 0; b < BODIES; b++) { /* symmetric */
    const int n = dof_start[b + 1] - dof_start[b];
    for (int e = 0; e < n * n; e++) {
      weight[weight_start[b] + e] = weight[weight_start[b] + e / n + e % n * n];
    }
  }
  x[3] = 0.0;
  const lcp_csc shift = {ROWS, ROWS, colptr, rowind, val};
  const lcp_factored f = {BODIES, dof_start, weight_start, weight, 1,    row_start,
                          body,   jac_start, jac,          &shift, NULL, NULL};
  const lcp_problem p = {.M = {.storage = LCP_FACTORED, .n = ROWS, .factored = &f}, .q = q};
  check_ok(lcp_problem_check(&p, &err), &err);
  lcp_matrix_to_dense(&p.M, dense);
  lcp_rho_factored s = {0};
  void *mem = laid_out(&s, &p);
  lcp_rho_factored_product(&s, &p, NULL, NULL, x, size);
  for (int i = 0; i < ROWS; i++) {
    double want = fabs(q[i]);
    for (int j = 0; j < ROWS; j++) {
      want += fabs(dense[i + ROWS * j] * x[j]);
    }
    check_close(size[i], want, 1e-12 * want);
  }
  free(mem);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(sizes_are_those_of_the_entries),
      cmocka_unit_test(a_wide_group_is_summed_in_strips),
  };
  return cmocka_run_group_tests_name("rho_factored", tests, NULL, NULL);
}
