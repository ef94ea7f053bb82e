/* A matrix whose rows are mixed of fewer, against the same with all rows written out: every reader sees the same. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"
#include "lcp/lcp_mixture.h"
#include "lcp/lcp_rho_factored.h"
#include "lcp/lcp_wide_column.h"
#include "lcp/linear/body_space.h"
#include "tests/support/random_cones.h"

#include <string.h>

enum { SEEDS = 30 };

/* Groups of a set of cones: every other one of at most LCP_STORED_MAX rows is mixed of them. */
typedef struct twin {
  known_lcp k;
  lcp_factored mixed, written;
  lcp_mixture *of;             /* n_group */
  const lcp_mixture **mixture; /* n_group */
  double *c, *jac, *q;
  int *row_start, *jac_start;
  lcp_problem a, b; /* mixed, written */
} twin;

static void *room(size_t count, size_t size) {
  void *mem = calloc(count + 1, size);
  assert_non_null(mem);
  return mem;
}

static int cols_of(const lcp_factored *f, int g) {
  return lcp_factored_dof(f, g, 0) + lcp_factored_dof(f, g, 1);
}

/* A mixture of random numbers, some of them 0 and 1. */
static void draw(base_rng *r, lcp_mixture *m, int stored, double *c) {
  *m = (lcp_mixture){.rows = 1 + (int)(base_rng_uniform(r) * 9), .stored = stored, .c = c};
  for (int i = 0; i < m->rows * stored; i++) {
    const double kind = base_rng_uniform(r);
    c[i] = (kind < 0.3) ? 0.0 : (kind < 0.5) ? 1.0 : base_rng_normal(r);
  }
}

static void open_twin(twin *t, uint64_t seed) {
  base_error err = {0};
  base_rng r = base_rng_seeded(seed + 100);
  memset(t, 0, sizeof *t);
  check_ok(random_cones(&t->k, seed, &err), &err);
  const lcp_factored *f = t->k.p.M.factored;
  const size_t groups = (size_t)f->n_group, most = 12 * groups;
  t->of = room(groups, sizeof *t->of);
  t->mixture = (const lcp_mixture **)room(groups, sizeof *t->mixture);
  t->c = room(groups * 12 * LCP_STORED_MAX, sizeof *t->c);
  t->row_start = room(groups, sizeof(int));
  t->jac_start = room(groups, sizeof(int));
  t->q = room(most, sizeof *t->q);
  t->jac = room(12 * most, sizeof *t->jac);
  t->mixed = *f;
  for (int g = 0; g < f->n_group; g++) {
    const int rows = f->row_start[g + 1] - f->row_start[g];
    if (g % 2 == 0 && rows <= LCP_STORED_MAX) {
      draw(&r, &t->of[g], rows, t->c + (ptrdiff_t)g * 12 * LCP_STORED_MAX);
      t->mixture[g] = &t->of[g];
    }
    const int own = (t->mixture[g] != NULL) ? t->of[g].rows : rows;
    t->row_start[g + 1] = t->row_start[g] + own;
    t->jac_start[g + 1] = t->jac_start[g] + own * cols_of(f, g);
  }
  t->mixed.row_start = t->row_start;
  t->mixed.jac_start = t->jac_start;
  t->mixed.stored_start = f->jac_start;
  t->mixed.mixture = t->mixture;
  t->written = t->mixed;
  t->written.stored_start = NULL;
  t->written.mixture = NULL;
  t->written.jac = t->jac;
  for (int g = 0; g < f->n_group; g++) {
    double made[LCP_MIXED_MAX];
    memcpy(t->jac + t->jac_start[g], lcp_factored_rows(&t->mixed, g, made),
           (size_t)(t->jac_start[g + 1] - t->jac_start[g]) * sizeof *made);
  }
  const int n = t->row_start[f->n_group];
  t->a = (lcp_problem){.M = {.storage = LCP_FACTORED, .n = n, .factored = &t->mixed},
                       .q = t->q,
                       .traits = LCP_SYMMETRIC | LCP_PSD};
  t->b = t->a;
  t->b.M.factored = &t->written;
  double *z = room(2 * (size_t)n + lcp_matrix_scratch(&t->b.M), sizeof *z), *w = z + n;
  for (int i = 0; i < n; i++) { /* a solution: z, or w, is zero */
    z[i] = fmax(base_rng_normal(&r), 0.0);
  }
  lcp_matrix_apply(&t->b.M, z, NULL, w, w + n);
  for (int i = 0; i < n; i++) {
    t->q[i] = ((z[i] > 0) ? 0.0 : base_rng_uniform(&r)) - w[i];
  }
  free(z);
}

static void close_twin(twin *t) {
  void *const mem[] = {t->of, t->c, t->row_start, t->jac_start, t->q, t->jac};
  for (int i = 0; i < BASE_COUNT(mem); i++) {
    free(mem[i]);
  }
  free((void *)t->mixture);
  known_lcp_free(&t->k);
}

static void check_near(const double *x, const double *y, size_t n, double tol) {
  double top = 0;
  for (size_t i = 0; i < n; i++) {
    top = fmax(top, fabs(y[i]));
  }
  for (size_t i = 0; i < n; i++) {
    assert_true(fabs(x[i] - y[i]) <= tol * top);
  }
}

/* Products, diagonal and copies. */
static void the_matrix_is_the_same(void **state) {
  (void)state;
  int mixed = 0;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    twin t;
    base_error err = {0};
    open_twin(&t, seed);
    const size_t n = (size_t)t.a.M.n;
    double *x = room(4 * n + 2 * n * n + lcp_matrix_scratch(&t.a.M), sizeof *x);
    double *y = x + 2 * n, *dense = y + 2 * n, *scratch = dense + 2 * n * n;
    base_rng r = base_rng_seeded(seed);
    check_ok(lcp_problem_check(&t.a, &err), &err);
    check_ok(lcp_problem_check(&t.b, &err), &err);
    for (size_t i = 0; i < n; i++) {
      x[i] = (base_rng_uniform(&r) < 0.3) ? 0.0 : base_rng_normal(&r);
    }
    lcp_matrix_apply(&t.a.M, x, t.q, y, scratch);
    lcp_matrix_apply(&t.b.M, x, t.q, y + n, scratch);
    check_near(y, y + n, n, 1e-13);
    lcp_matrix_diagonal(&t.a.M, y);
    lcp_matrix_diagonal(&t.b.M, y + n);
    assert_memory_equal(y, y + n, n * sizeof *y);
    lcp_matrix_to_dense(&t.a.M, dense);
    lcp_matrix_to_dense(&t.b.M, dense + n * n);
    assert_memory_equal(dense, dense + n * n, n * n * sizeof *dense);
    lcp_csc a, b;
    check_ok(lcp_matrix_to_csc(&t.a.M, &a, &err), &err);
    check_ok(lcp_matrix_to_csc(&t.b.M, &b, &err), &err);
    assert_memory_equal(a.colptr, b.colptr, (n + 1) * sizeof *a.colptr);
    assert_memory_equal(a.val, b.val, (size_t)a.colptr[n] * sizeof *a.val);
    lcp_csc_free(&a);
    lcp_csc_free(&b);
    for (int g = 0; g < t.mixed.n_group; g++) {
      mixed += t.mixture[g] != NULL;
    }
    free(x);
    close_twin(&t);
  }
  assert_true(mixed > 100);
}

/* What the judge and the stopping tests sum. */
static void sums_are_the_same(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    twin t;
    base_error err = {0};
    lcp_wide_columns of[2];
    open_twin(&t, seed);
    const lcp_problem *p[2] = {&t.a, &t.b};
    const size_t n = (size_t)t.a.M.n;
    double *x = room(5 * n, sizeof *x), *size = x + n, *d = size + 2 * n;
    long double *w = room(4 * n, sizeof *w), *s = w + 2 * n;
    long double *wide = room(n, sizeof *wide);
    base_rng r = base_rng_seeded(seed);
    lcp_verdict v[2];
    for (size_t i = 0; i < n; i++) {
      x[i] = (base_rng_uniform(&r) < 0.3) ? 0.0 : fabs(base_rng_normal(&r));
      wide[i] = x[i];
    }
    for (int k = 0; k < 2; k++) {
      const lcp_capacity cap = lcp_problem_capacity(p[k]);
      lcp_rho_factored rho = {0};
      base_arena measure = base_arena_measuring();
      lcp_rho_factored_layout(&rho, &cap, &measure);
      void *mem = base_alloc(measure.used);
      assert_non_null(mem);
      base_arena real = base_arena_over(mem, measure.used);
      lcp_rho_factored_layout(&rho, &cap, &real);
      lcp_rho_factored_product(&rho, p[k], NULL, NULL, x, size + (size_t)k * n);
      free(mem);
      check_ok(lcp_wide_columns_open(&of[k], &p[k]->M, &err), &err);
      lcp_wide_factored_product(&of[k], x, w + (size_t)k * n);
      lcp_wide_factored_sizes(&of[k], wide, s + (size_t)k * n);
      lcp_wide_factored_diagonal(&of[k], d + (size_t)k * n);
      check_ok(lcp_judge(p[k], x, &v[k], &err), &err);
    }
    assert_memory_equal(size, size + n, n * sizeof *size);
    assert_memory_equal(d, d + n, n * sizeof *d);
    double top = 0;
    for (size_t i = 0; i < n; i++) {
      top = fmax(top, (double)s[n + i]);
    }
    for (size_t i = 0; i < n; i++) {
      assert_true(fabsl(w[i] - w[n + i]) <= 1e-17L * top);
      assert_true(fabsl(s[i] - s[n + i]) <= 1e-13L * top);
    }
    for (int j = 0; j < (int)n; j++) {
      const lcp_wide_column a = lcp_wide_columns_at(&of[0], j), b = lcp_wide_columns_at(&of[1], j);
      assert_int_equal(a.count, b.count);
      for (int e = 0; e < a.count; e++) {
        assert_true(a.row[e] == b.row[e] && a.val[e] == b.val[e]);
      }
    }
    check_close(v[0].rho, v[1].rho, 1e-12 * v[1].rho);
    lcp_wide_columns_close(&of[0]);
    lcp_wide_columns_close(&of[1]);
    free(x);
    free(w);
    free(wide);
    close_twin(&t);
  }
}

/* I + K J W J' with K of random numbers over some rows: G of the stored rows, and of all. */
static void systems_in_body_space_are_the_same(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    twin t;
    base_error err = {0};
    open_twin(&t, seed);
    const lcp_factored *f = &t.mixed;
    const size_t n = (size_t)t.a.M.n;
    double *right = room(3 * n, sizeof *right), *x = right + n;
    unsigned char *member = room(n, 1);
    int deficit[2];
    for (int k = 0; k < 2; k++) {
      lin_body_space s = {0};
      bool regular;
      double *L = room((size_t)f->weight_start[f->n_body], sizeof *L);
      double *G =
          room((k == 0) ? lin_stored_length(f) : (size_t)f->jac_start[f->n_group], sizeof *G);
      base_rng r = base_rng_seeded(seed);
      check_ok(lin_weigh_bodies(f, L, &err), &err);
      if (k == 0) {
        lin_weigh_stored(f, L, G);
      } else {
        lin_weigh_rows(f, L, G);
      }
      for (size_t i = 0; i < n; i++) {
        right[i] = base_rng_normal(&r);
        member[i] = base_rng_uniform(&r) < 0.6;
      }
      check_ok(lin_body_space_begin(&s, f, G, k == 0, NULL, member, &err), &err);
      for (int g = 0; g < f->n_group; g++) {
        const int *row, rows = lin_body_space_rows(&s, g, &row);
        for (int i = 0; i < rows; i++) {
          s.T[s.at[g] + (size_t)(i + i * rows)] = 1e-3 * (1 + base_rng_uniform(&r));
          s.Y[s.at[g] + (size_t)(i + i * rows)] = 1;
        }
      }
      check_ok(lin_body_space_factor(&s, true, &regular, &err), &err);
      assert_true(regular);
      lin_body_space_solve(&s, right, x + (size_t)k * n);
      check_ok(lin_body_space_deficit(&s, &deficit[k], &err), &err);
      lin_body_space_close(&s);
      free(L);
      free(G);
    }
    check_near(x, x + n, n, 1e-9);
    assert_int_equal(deficit[0], deficit[1]);
    free(right);
    free(member);
    close_twin(&t);
  }
}

/* The columns of Lemke's method are made of the rows: the same pivots, the same bits. */
static void lemke_takes_the_same_way(void **state) {
  (void)state;
  const lcp_solver *lemke = lcp_solver_find("lemke");
  int solved = 0;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    twin t;
    base_error err = {0};
    lcp_result made[2];
    open_twin(&t, seed);
    const lcp_problem *p[2] = {&t.a, &t.b};
    const size_t n = (size_t)t.a.M.n;
    double *z = room(2 * n, sizeof *z);
    void *opt = room(1, lemke->options_size);
    base_fields_default(lemke->fields, lemke->n_fields, opt);
    for (int k = 0; k < 2; k++) {
      lcp_instance *own;
      const lcp_capacity cap = lcp_problem_capacity(p[k]);
      check_ok(lcp_instance_open(&own, lemke, &cap, opt, &err), &err);
      check_ok(lcp_instance_prepare(own, p[k], &err), &err);
      assert_int_equal(lcp_instance_storage(own), LCP_FACTORED);
      check_ok(lcp_instance_solve(own, NULL, z + (size_t)k * n, &made[k], &err), &err);
      lcp_instance_close(own);
    }
    assert_int_equal(made[0].outcome, made[1].outcome);
    assert_int_equal(made[0].work.pivots, made[1].work.pivots);
    assert_memory_equal(z, z + n, n * sizeof *z);
    solved += made[0].outcome == LCP_SOLVED;
    free(opt);
    free(z);
    close_twin(&t);
  }
  assert_true(solved > SEEDS / 2);
}

static void damage_is_named(void **state) {
  (void)state;
  twin t;
  base_error err = {0};
  open_twin(&t, 1);
  int g = 0;
  while (g < t.mixed.n_group && t.mixture[g] == NULL) {
    g++;
  }
  assert_true(g < t.mixed.n_group);
  lcp_mixture *m = &t.of[g];
  double *c = t.c + (ptrdiff_t)g * 12 * LCP_STORED_MAX;
  const lcp_mixture right = *m;
  const double first = c[0];
  m->rows++;
  assert_int_equal(lcp_problem_check(&t.a, &err), BASE_EINVAL);
  assert_non_null(strstr(err.text, ": need a mixture"));
  *m = right;
  m->stored = LCP_STORED_MAX + 1;
  assert_int_equal(lcp_problem_check(&t.a, &err), BASE_EINVAL);
  *m = right;
  c[0] = HUGE_VAL;
  assert_int_equal(lcp_problem_check(&t.a, &err), BASE_EINVAL);
  assert_non_null(strstr(err.text, "mixture"));
  c[0] = first;
  t.mixed.stored_start = NULL;
  assert_int_equal(lcp_problem_check(&t.a, &err), BASE_EINVAL);
  assert_non_null(strstr(err.text, "where they are stored"));
  close_twin(&t);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_matrix_is_the_same),
      cmocka_unit_test(sums_are_the_same),
      cmocka_unit_test(systems_in_body_space_are_the_same),
      cmocka_unit_test(lemke_takes_the_same_way),
      cmocka_unit_test(damage_is_named),
  };
  return cmocka_run_group_tests_name("mixture", tests, NULL, NULL);
}
