/* linear/blocks.h on random patterns, by the residual of the dense matrix: blocks of 0 to 12 rows, symmetric and not, several factorisations of one
 * pattern, and matrices without the factors asked for. */
#include "tests/support/check.h"

#include "lcp/base/crew.h"
#include "lcp/base/rng.h"
#include "lcp/linear/blocks.h"

#include <stdlib.h>
#include <string.h>

enum { BLOCKS = 14, PAIRS = 40, ROWS = BLOCKS * LIN_BLOCK_MAX };

typedef struct sample {
  int first[BLOCKS + 1], pair[2 * PAIRS];
  double A[ROWS * ROWS]; /* column-major */
} sample;

static double number(base_rng *r) {
  return base_rng_between(r, -1, 1);
}

static void pattern_of(sample *t, base_rng *r) {
  t->first[0] = 0;
  for (int b = 0; b < BLOCKS; b++) {
    t->first[b + 1] = t->first[b] + (int)(base_rng_uniform(r) * (LIN_BLOCK_MAX + 1));
  }
  for (int k = 0; k < 2 * PAIRS; k++) {
    t->pair[k] = (int)(base_rng_uniform(r) * BLOCKS);
  }
}

/* Adds a random block to A_ab of the dense matrix and of the factor. */
static void put(sample *t, lin_blocks *s, base_rng *r, int a, int b, bool symmetric, double scale) {
  const int n = t->first[BLOCKS], m = t->first[a + 1] - t->first[a],
            w = t->first[b + 1] - t->first[b];
  double B[LIN_BLOCK_MAX * LIN_BLOCK_MAX], C[LIN_BLOCK_MAX * LIN_BLOCK_MAX];
  for (int i = 0; i < m; i++) {
    for (int j = 0; j < w; j++) {
      B[i * w + j] = scale * number(r);
      C[j * m + i] = symmetric ? B[i * w + j] : scale * number(r);
      t->A[t->first[a] + i + (t->first[b] + j) * n] += B[i * w + j];
      t->A[t->first[b] + j + (t->first[a] + i) * n] += C[j * m + i];
    }
  }
  lin_blocks_add(s, a, b, B);
  lin_blocks_add(s, b, a, C);
}

static void numbers_of(sample *t, lin_blocks *s, base_rng *r, bool symmetric) {
  const int n = t->first[BLOCKS];
  memset(t->A, 0, sizeof t->A);
  lin_blocks_clear(s, symmetric);
  for (int k = 0; k < PAIRS; k++) {
    put(t, s, r, t->pair[2 * k], t->pair[2 * k + 1], symmetric, 1);
  }
  for (int b = 0; b < BLOCKS; b++) {
    const int m = t->first[b + 1] - t->first[b];
    double one[LIN_BLOCK_MAX * LIN_BLOCK_MAX] = {0};
    for (int i = 0; i < m; i++) {
      one[i + i * m] = 100;
      t->A[(t->first[b] + i) * (n + 1)] += 100;
    }
    lin_blocks_add(s, b, b, one);
  }
}

/* x of the factor solves the dense system, row for row. */
static void solves(sample *t, const lin_blocks *s, base_rng *r) {
  const int n = t->first[BLOCKS];
  double x[ROWS], b[ROWS];
  for (int i = 0; i < n; i++) {
    x[i] = b[i] = number(r);
  }
  lin_blocks_solve(s, x);
  for (int i = 0; i < n; i++) {
    double sum = -b[i];
    for (int j = 0; j < n; j++) {
      sum += t->A[i + j * n] * x[j];
    }
    check_close(sum, 0, 1e-12);
  }
}

static void factors_solve(void **state) {
  (void)state;
  base_error err = {0};
  sample *t = malloc(sizeof *t);
  lin_blocks s = {0};
  base_rng r = base_rng_seeded(7);
  for (int trial = 0; trial < 60; trial++) {
    pattern_of(t, &r);
    const long before = s.analyses;
    for (int again = 0; again < 3; again++) {
      assert_int_equal(lin_blocks_plan(&s, BLOCKS, t->first, t->pair, PAIRS, &err), BASE_OK);
      numbers_of(t, &s, &r, again == 1);
      assert_true(lin_blocks_factor(&s));
      solves(t, &s, &r);
      if (trial % 2 ==
          0) { /* numbers given back: the next plan has them again, without another analysis */
        lin_blocks_rest(&s);
      }
    }
    assert_int_equal(s.analyses, before + 1); /* one for each pattern */
  }
  lin_blocks_close(&s);
  free(t);
}

/* The blocks of the inverse where A has blocks, against solutions for unit vectors. */
static void parts_of_the_inverse(void **state) {
  (void)state;
  base_error err = {0};
  sample *t = malloc(sizeof *t);
  lin_blocks s = {0};
  base_rng r = base_rng_seeded(13);
  for (int trial = 0; trial < 20; trial++) {
    pattern_of(t, &r);
    assert_int_equal(lin_blocks_plan(&s, BLOCKS, t->first, t->pair, PAIRS, &err), BASE_OK);
    numbers_of(t, &s, &r, true);
    assert_true(lin_blocks_factor(&s));
    assert_int_equal(lin_blocks_invert(&s, &err), BASE_OK);
    if (trial % 2 == 0) {
      lin_blocks_rest(&s);
      assert_int_equal(lin_blocks_plan(&s, BLOCKS, t->first, t->pair, PAIRS, &err), BASE_OK);
      numbers_of(t, &s, &r, true);
      assert_true(lin_blocks_factor(&s));
      assert_int_equal(lin_blocks_invert(&s, &err), BASE_OK);
    }
    for (int k = 0; k < 2 * PAIRS; k++) {
      const int a = t->pair[k], b = (k % 3 == 0) ? a : t->pair[k ^ 1];
      const int m = t->first[a + 1] - t->first[a], n = t->first[b + 1] - t->first[b];
      double x[ROWS] = {0}, y[LIN_BLOCK_MAX], left[LIN_BLOCK_MAX], sum = 0;
      for (int i = 0; i < m; i++) {
        left[i] = number(&r);
      }
      for (int i = 0; i < n; i++) {
        x[t->first[b] + i] = y[i] = number(&r);
      }
      lin_blocks_solve(&s, x);
      for (int i = 0; i < m; i++) {
        sum += left[i] * x[t->first[a] + i];
      }
      check_close(lin_blocks_inverse_form(&s, a, left, b, y), sum, 1e-14);
    }
  }
  lin_blocks_close(&s);
  free(t);
}

/* A lattice of bodies that all meet their 26 neighbours: wide enough for dense fronts, which have to give what A x says and, where A
 * has no factors, to say so. */
enum { SIDE = 7, CELLS = SIDE * SIDE * SIDE, MEET = CELLS * 13 };

typedef struct lattice {
  int first[CELLS + 1], pair[2 * MEET];
  size_t n_pair;
  double x[CELLS * LIN_BLOCK_MAX], b[CELLS * LIN_BLOCK_MAX];
} lattice;

static void lattice_pattern(lattice *l, base_rng *r) {
  l->first[0] = 0;
  l->n_pair = 0;
  for (int c = 0; c < CELLS; c++) {
    l->first[c + 1] = l->first[c] + (int)(base_rng_uniform(r) * 7);
  }
  for (int a = 0; a < CELLS; a++) {
    for (int b = 0; b < a; b++) {
      const int x = a % SIDE - b % SIDE, y = a / SIDE % SIDE - b / SIDE % SIDE,
                z = a / (SIDE * SIDE) - b / (SIDE * SIDE);
      if (abs(x) <= 1 && abs(y) <= 1 && abs(z) <= 1) {
        l->pair[2 * l->n_pair] = a;
        l->pair[2 * l->n_pair++ + 1] = b;
      }
    }
  }
}

/* Fills the factor with random blocks and 100 on the diagonal (0 for cell `without`), and b = A x. */
static void lattice_numbers(lattice *l, lin_blocks *s, base_rng *r, bool symmetric, int without) {
  lin_blocks_clear(s, symmetric);
  for (int i = 0; i < l->first[CELLS]; i++) {
    l->x[i] = number(r);
    l->b[i] = 100 * l->x[i];
  }
  for (int c = 0; c < CELLS; c++) {
    double one[LIN_BLOCK_MAX * LIN_BLOCK_MAX] = {0};
    const int m = l->first[c + 1] - l->first[c];
    for (int i = 0; i < m; i++) {
      one[i + i * m] = (c == without) ? -100 : 100;
    }
    lin_blocks_add(s, c, c, one);
  }
  for (size_t k = 0; k < l->n_pair; k++) {
    const int a = l->pair[2 * k], b = l->pair[2 * k + 1];
    const int m = l->first[a + 1] - l->first[a], n = l->first[b + 1] - l->first[b];
    double B[LIN_BLOCK_MAX * LIN_BLOCK_MAX], C[LIN_BLOCK_MAX * LIN_BLOCK_MAX];
    for (int i = 0; i < m; i++) {
      for (int j = 0; j < n; j++) {
        B[i * n + j] = number(r);
        C[j * m + i] = symmetric ? B[i * n + j] : number(r);
        l->b[l->first[a] + i] += B[i * n + j] * l->x[l->first[b] + j];
        l->b[l->first[b] + j] += C[j * m + i] * l->x[l->first[a] + i];
      }
    }
    lin_blocks_add(s, a, b, B);
    lin_blocks_add(s, b, a, C);
  }
}

static void fronts_solve(void **state) {
  (void)state;
  base_error err = {0};
  lattice *l = malloc(sizeof *l);
  lin_blocks s = {0};
  base_rng r = base_rng_seeded(23);
  for (int trial = 0; trial < 3; trial++) {
    lattice_pattern(l, &r);
    assert_int_equal(lin_blocks_plan(&s, CELLS, l->first, l->pair, l->n_pair, &err), BASE_OK);
    assert_true(s.n_front > 1 && s.n_front < CELLS);
    for (int again = 0; again < 3; again++) {
      if (again == 2) {
        lin_blocks_rest(&s);
        assert_int_equal(lin_blocks_plan(&s, CELLS, l->first, l->pair, l->n_pair, &err), BASE_OK);
      }
      lattice_numbers(l, &s, &r, again == 1, -1);
      assert_true(lin_blocks_factor(&s));
      lin_blocks_solve(&s, l->b);
      for (int i = 0; i < l->first[CELLS]; i++) {
        check_close(l->b[i], l->x[i], 1e-12);
      }
    }
    lattice_numbers(l, &s, &r, true, CELLS / 2);
    assert_int_equal(lin_blocks_factor(&s), l->first[CELLS / 2 + 1] == l->first[CELLS / 2]);
  }
  assert_int_equal(s.analyses, 3);
  lin_blocks_close(&s);
  free(l);
}

/* The factor of the lattice in limbs and strips, by crews of one to four: the same bits, and where one has no factor none has. */
static void fronts_are_the_same_by_any_crew(void **state) {
  (void)state;
  base_error err = {0};
  lattice *l = malloc(sizeof *l);
  const int without[] = {-1, 0, CELLS / 2, CELLS - 1};
  for (int symmetric = 0; symmetric < 2; symmetric++) {
    for (int k = 0; k < BASE_COUNT(without); k++) {
      static double kept[CELLS * LIN_BLOCK_MAX];
      bool kept_made = false;
      for (int threads = 1; threads <= 4; threads++) {
        base_rng r = base_rng_seeded(29);
        lin_blocks s = {0};
        base_crew *crew;
        check_ok(base_crew_open(&crew, threads, &err), &err);
        (void)base_crew_take_up(crew);
        lattice_pattern(l, &r);
        assert_int_equal(lin_blocks_plan(&s, CELLS, l->first, l->pair, l->n_pair, &err), BASE_OK);
        assert_true(s.n_front > 1 && (s.n_limb > 3) == (threads > 1));
        lattice_numbers(l, &s, &r, symmetric == 1, without[k]);
        const bool made = lin_blocks_factor(&s);
        (void)base_crew_take_up(NULL);
        base_crew_close(crew);
        if (made) {
          lin_blocks_solve(&s, l->b);
        }
        const size_t bytes = made ? (size_t)l->first[CELLS] * sizeof *kept : 0;
        assert_true(threads == 1 || made == kept_made);
        assert_true(threads == 1 || memcmp(kept, l->b, bytes) == 0);
        kept_made = made;
        memcpy(kept, l->b, bytes);
        lin_blocks_close(&s);
      }
    }
  }
  free(l);
}

/* Planned by one thread and factored by more, and the other way round. */
static void a_plan_is_good_for_any_crew(void **state) {
  (void)state;
  base_error err = {0};
  lattice *l = malloc(sizeof *l);
  for (int planned = 1; planned <= 3; planned++) {
    for (int threads = 1; threads <= 3; threads++) {
      base_rng r = base_rng_seeded(31);
      lin_blocks s = {0};
      base_crew *crew[2];
      check_ok(base_crew_open(&crew[0], planned, &err), &err);
      check_ok(base_crew_open(&crew[1], threads, &err), &err);
      (void)base_crew_take_up(crew[0]);
      lattice_pattern(l, &r);
      assert_int_equal(lin_blocks_plan(&s, CELLS, l->first, l->pair, l->n_pair, &err), BASE_OK);
      (void)base_crew_take_up(crew[1]);
      lattice_numbers(l, &s, &r, false, -1);
      assert_true(lin_blocks_factor(&s));
      assert_ptr_equal(base_crew_take_up(NULL), crew[1]);
      lin_blocks_solve(&s, l->b);
      for (int i = 0; i < l->first[CELLS]; i++) {
        check_close(l->b[i], l->x[i], 1e-12);
      }
      base_crew_close(crew[0]);
      base_crew_close(crew[1]);
      lin_blocks_close(&s);
    }
  }
  free(l);
}

static void what_has_no_factors_is_refused(void **state) {
  (void)state;
  base_error err = {0};
  const int first[3] = {0, 1, 2}, pair[2] = {0, 1};
  const double one = 1, minus = -1, none = 0, less = 1 - 1e-16, tiny = 1e-16;
  lin_blocks s = {0};
  assert_int_equal(lin_blocks_plan(&s, 2, first, pair, 1, &err), BASE_OK);
  lin_blocks_clear(&s, true);
  lin_blocks_add(&s, 0, 0, &one);
  lin_blocks_add(&s, 1, 1, &minus);
  assert_false(lin_blocks_factor(&s)); /* not positive definite */
  for (int symmetric = 0; symmetric < 2; symmetric++) {
    lin_blocks_clear(&s, symmetric == 1); /* 1 1; 1 1 */
    lin_blocks_add(&s, 0, 0, &one);
    lin_blocks_add(&s, 0, 1, &one);
    lin_blocks_add(&s, 1, 0, &one);
    lin_blocks_add(&s, 1, 1, &less);
    assert_false(lin_blocks_factor(&s));
    lin_blocks_clear(&s, symmetric == 1); /* 1 0; 0 1e-16 */
    lin_blocks_add(&s, 0, 0, &one);
    lin_blocks_add(&s, 1, 1, &tiny);
    assert_false(lin_blocks_factor(&s));
  }
  lin_blocks_clear(&s, false);
  lin_blocks_add(&s, 0, 0, &none);
  lin_blocks_add(&s, 1, 1, &none);
  lin_blocks_add(&s, 0, 1, &one);
  lin_blocks_add(&s, 1, 0, &one);
  assert_false(lin_blocks_factor(&s)); /* regular, but not without exchanges between blocks */
  lin_blocks_close(&s);
}

static void nothing_is_a_pattern_too(void **state) {
  (void)state;
  base_error err = {0};
  const int first[1] = {0};
  double x = 3;
  lin_blocks s = {0};
  assert_int_equal(lin_blocks_plan(&s, 0, first, NULL, 0, &err), BASE_OK);
  lin_blocks_clear(&s, true);
  assert_true(lin_blocks_factor(&s));
  lin_blocks_solve(&s, &x);
  assert_true(x == 3);
  lin_blocks_close(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(factors_solve),
      cmocka_unit_test(fronts_solve),
      cmocka_unit_test(fronts_are_the_same_by_any_crew),
      cmocka_unit_test(a_plan_is_good_for_any_crew),
      cmocka_unit_test(parts_of_the_inverse),
      cmocka_unit_test(what_has_no_factors_is_refused),
      cmocka_unit_test(nothing_is_a_pattern_too),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
