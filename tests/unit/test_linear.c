/* lin_lu: full matrices, which go to LAPACK, and thin ones, which do not, solve alike; a singular
 * one names its dependent columns either way. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/linear/sparse_lu.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { N = 24, ENTRIES = N * N };

typedef struct rig {
  lin_columns A;
  int colptr[N + 1], rowind[ENTRIES];
  double val[ENTRIES], full[N][N]; /* full[j]: column j */
  lin_lu lu;
  void *memory;
} rig;

/* `share` of the entries random, the diagonal always there. */
static void fill(rig *r, base_rng *random, double share) {
  memset(r->full, 0, sizeof r->full);
  for (int j = 0; j < N; ++j) {
    for (int i = 0; i < N; ++i) {
      const bool there = i == j || base_rng_uniform(random) < share;
      r->full[j][i] = there ? base_rng_between(random, 0.5, 1.5) * ((i + j) % 2 ? -1 : 1) : 0;
    }
    r->full[j][j] *= 4;
  }
}

static bool factor(rig *r) {
  int at = 0;
  for (int j = 0; j < N; ++j) {
    r->colptr[j] = at;
    for (int i = 0; i < N; ++i) {
      if (r->full[j][i] != 0) {
        r->rowind[at] = i;
        r->val[at++] = r->full[j][i];
      }
    }
  }
  r->colptr[N] = at;
  r->A = (lin_columns){N, r->colptr, r->rowind, r->val};
  base_arena measure = base_arena_measuring();
  lin_lu_layout(&r->lu, N, ENTRIES, ENTRIES, &measure);
  r->memory = base_alloc(measure.used);
  assert_non_null(r->memory);
  base_arena a = base_arena_over(r->memory, measure.used);
  lin_lu_layout(&r->lu, N, ENTRIES, ENTRIES, &a);
  memset(r->lu.stack, 0x5a,
         N * sizeof *r->lu.stack); /* scratch: what is read of it leads far away */
  return lin_lu_factor(&r->lu, &r->A);
}

/* max |A x - b| for x of lin_lu_solve. */
static double defect(const rig *r, const double *b) {
  double x[N], rest[N];
  memcpy(x, b, sizeof x);
  memcpy(rest, b, sizeof rest);
  lin_lu_solve(&r->lu, x);
  for (int k = 0; k < N; ++k) {
    for (int i = 0; i < N; ++i) {
      rest[i] -= r->full[r->lu.col[k]][i] * x[r->lu.prow[k]];
    }
  }
  double worst = 0;
  for (int i = 0; i < N; ++i) {
    worst = fmax(worst, fabs(rest[i]));
  }
  return worst;
}

static void both_kinds_solve(void **state) {
  (void)state;
  base_rng random = base_rng_seeded(1);
  for (int k = 0; k < 40; ++k) {
    rig r;
    double b[N];
    fill(&r, &random, (k % 2 == 0) ? 1 : 0.1);
    for (int i = 0; i < N; ++i) {
      b[i] = base_rng_between(&random, -1, 1);
    }
    assert_true(factor(&r));
    assert_int_equal(r.lu.dense, k % 2 == 0);
    assert_true(defect(&r, b) < 1e-12);
    free(r.memory);
  }
}

static void dependent_columns_are_named(void **state) {
  (void)state;
  base_rng random = base_rng_seeded(2);
  for (int k = 0; k < 20; ++k) {
    rig r;
    fill(&r, &random, (k % 2 == 0) ? 1 : 0.1);
    memcpy(r.full[7], r.full[3], sizeof r.full[3]);
    assert_false(factor(&r));
    assert_int_equal(r.lu.deficient, 1);
    const int named = r.lu.col[N - 1];
    assert_true(named == 3 || named == 7);
    free(r.memory);
  }
}

/* A pivot that is zero exactly ends no factor before its rows are all exchanged. */
static void a_column_of_zeros_is_named(void **state) {
  (void)state;
  base_rng random = base_rng_seeded(3);
  for (int at = 0; at < N; ++at) {
    rig r;
    fill(&r, &random, 1);
    memset(r.full[at], 0, sizeof r.full[at]);
    assert_false(factor(&r));
    assert_int_equal(r.lu.deficient, 1);
    assert_int_equal(r.lu.col[N - 1], at);
    free(r.memory);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(both_kinds_solve),
      cmocka_unit_test(dependent_columns_are_named),
      cmocka_unit_test(a_column_of_zeros_is_named),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
