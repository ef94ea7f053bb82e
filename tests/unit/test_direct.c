/* lcp_direct: dense and sparse agree, one symbolic analysis per pattern, singular matrices reported. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/linear/direct.h"

#include <string.h>

enum { N = 12, NNZ_MAX = N * N };

typedef struct both {
  double dense[N * N], val[NNZ_MAX];
  int colptr[N + 1], rowind[NNZ_MAX];
  lcp_matrix D, S;
} both;

/* A band of half-width 2 with a heavy diagonal, in both storages. */
static void fill(both *b, base_rng *r) {
  memset(b, 0, sizeof *b);
  int nz = 0;
  for (int j = 0; j < N; j++) {
    b->colptr[j] = nz;
    for (int i = 0; i < N; i++) {
      if (abs(i - j) <= 2) {
        const double v = (i == j) ? 5 : base_rng_between(r, -1, 1);
        b->dense[j * N + i] = v;
        b->rowind[nz] = i;
        b->val[nz++] = v;
      }
    }
  }
  b->colptr[N] = nz;
  b->D = (lcp_matrix){.storage = LCP_DENSE, .n = N, .val = b->dense};
  b->S = (lcp_matrix){.storage = LCP_CSC, .n = N, .csc = {N, N, b->colptr, b->rowind, b->val}};
}

static void *open_for(lcp_direct *d, const lcp_matrix *M) {
  const lcp_problem p = {.M = *M};
  const lcp_capacity cap = lcp_problem_capacity(&p);
  base_arena a = base_arena_measuring();
  lcp_direct_layout(d, &cap, &a);
  void *mem = base_alloc(a.used);
  assert_non_null(mem);
  a = base_arena_over(mem, a.used);
  lcp_direct_layout(d, &cap, &a);
  lcp_direct_begin(d);
  return mem;
}

static void dense_and_sparse_agree(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(21);
  both b;
  fill(&b, &r);
  lcp_direct d;
  lcp_direct s;
  void *md = open_for(&d, &b.D);
  void *ms = open_for(&s, &b.S);
  static const unsigned char some[N] = {1, 1, 0, 1, 1, 1, 0, 0, 1, 1, 1, 1};
  const unsigned char *sets[] = {NULL, NULL, some, some, NULL};
  static const long analyses[] = {1, 1, 2, 2, 3}; /* one per change of S */
  for (int k = 0; k < BASE_COUNT(sets); k++) {
    base_status status = BASE_OK;
    double add[N];
    double x[N];
    double y[N];
    double row[N];
    for (int i = 0; i < N; i++) {
      add[i] = base_rng_uniform(&r);
      row[i] = base_rng_between(&r, 0.5, 2);
      x[i] = y[i] = base_rng_between(&r, -1, 1);
    }
    assert_true(lcp_direct_factor(&d, &b.D, sets[k], add, row, row, &status));
    assert_true(lcp_direct_factor(&s, &b.S, sets[k], add, row, row, &status));
    assert_int_equal(status, BASE_OK);
    lcp_direct_solve(&d, N, x);
    lcp_direct_solve(&s, N, y);
    for (int i = 0; i < N; i++) {
      check_close(y[i], x[i], 1e-13); /* |x| < 1, condition below 10 */
    }
    assert_int_equal(s.analyses, analyses[k]);
  }
  lcp_direct_release(&s);
  free(md);
  free(ms);
}

static void singular_is_reported(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(22);
  both b;
  fill(&b, &r);
  for (int i = 0; i < N; i++) { /* column 3 is zero but for its place in the pattern */
    b.dense[3 * N + i] = 0;
  }
  for (int k = b.colptr[3]; k < b.colptr[4]; k++) {
    b.val[k] = 0;
  }
  const lcp_matrix *M[] = {&b.D, &b.S};
  unsigned char rest[N];
  for (int i = 0; i < N; i++) {
    rest[i] = i != 3;
  }
  for (int k = 0; k < 2; k++) {
    lcp_direct d;
    base_status status = BASE_OK;
    void *mem = open_for(&d, M[k]);
    assert_false(lcp_direct_factor(&d, M[k], NULL, NULL, NULL, NULL, &status));
    assert_int_equal(status, BASE_OK);
    assert_true(lcp_direct_factor(&d, M[k], rest, NULL, NULL, NULL, &status));
    assert_false(lcp_direct_factor(&d, M[k], NULL, NULL, NULL, NULL, &status));
    lcp_direct_release(&d);
    free(mem);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(dense_and_sparse_agree),
      cmocka_unit_test(singular_is_reported),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
