/* The two engines of lemke hold the same bases: one path on both, a table that grows, a small pivot; and phase one
 * of the simplex method on the table. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/solvers/lemke/proof.h"
#include "tests/support/solve.h"

#include <string.h>

enum { N = 24 };

typedef struct rig {
  lemke_system built;
  lemke_store store;
  lemke_path path;
  lemke_table table;
  lemke_basis basis;
  double M[N * N], q[N];
  lcp_problem p;
  void *memory;
} rig;

static void carve(rig *r, base_arena *a) {
  const lcp_capacity cap = {.n = N, .nnz = N * N};
  lemke_system_layout(&r->built, &r->store, &cap, a);
  lemke_path_layout(&r->path, N, a);
  lemke_table_layout(&r->table, N, a);
  lemke_basis_layout(&r->basis, N, N * N, a);
}

static void rig_open(rig *r) {
  memset(r, 0, sizeof *r);
  base_arena a = base_arena_measuring();
  carve(r, &a);
  r->memory = base_alloc(a.used);
  assert_non_null(r->memory);
  a = base_arena_over(r->memory, a.used);
  carve(r, &a);
  r->path.deadline = HUGE_VAL;
  r->path.pivot_limit = 10000;
}

/* Positive definite with a skew part, `share` of the entries beside the diagonal. */
static void pose(rig *r, base_rng *random, int n, double share) {
  for (int i = 0; i < n; ++i) {
    r->q[i] = base_rng_between(random, -1, 0.5);
    for (int j = 0; j < n; ++j) {
      const bool there = base_rng_uniform(random) < share;
      r->M[j * n + i] = (i == j) ? n : there ? base_rng_between(random, -1, 1) : 0;
    }
  }
  r->p = (lcp_problem){.M = {.storage = LCP_DENSE, .n = n, .val = r->M}, .q = r->q};
}

/* z of the complementary basis that the engine holds, in the units of the problem. */
static void read_z(const lemke_engine *e, const lemke_system *s, double *z) {
  for (int i = 0; i < s->n; ++i) {
    const int at = e->where[s->n + i];
    z[i] = (at < 0) ? 0 : ldexp(e->x[at], s->q_exp + s->col_exp[i]);
  }
}

/* B^-1 of every nonbasic column, by basic variable; of the table before anybody settled it: columns follow the last pivot
 * late. */
static void check_columns(lemke_engine *e, lemke_engine *reference, int n) {
  double room[2][N];
  for (int var = 0; var < 2 * n; ++var) {
    assert_int_equal(e->where[var] < 0, reference->where[var] < 0);
    if (e->where[var] >= 0) {
      continue;
    }
    const double *a = e->kind->column(e, var, room[0]);
    const double *b = reference->kind->column(reference, var, room[1]);
    for (int p = 0; p < n; ++p) {
      check_close(a[p], b[reference->where[e->head[p]]], 1e-12);
    }
  }
}

static void both_engines_take_the_same_path(void **state) {
  (void)state;
  static const lemke_tolerance tol = {1e-11, 1e-12, false};
  base_rng random = base_rng_seeded(3);
  rig r;
  rig_open(&r);
  for (int trial = 0; trial < 60; ++trial) {
    const int n = 1 + trial % N;
    double z[2][N] = {{0}};
    long pivots[2];
    pose(&r, &random, n, (trial % 3 == 0) ? 0.2 : 1);
    lemke_system_build(&r.built, &r.store, &r.p, false);
    lemke_engine *const engines[2] = {&r.table.engine, &r.basis.engine};
    for (int k = 0; k < 2; ++k) {
      memset(r.path.in_z, 0, sizeof(unsigned char) * (size_t)n);
      r.path.pivots = 0;
      assert_int_equal(lemke_path_run(&r.path, engines[k], &r.built, tol), LEMKE_SOLVED);
      pivots[k] = r.path.pivots;
    }
    assert_int_equal(pivots[0], pivots[1]);
    check_columns(engines[0], engines[1], n);
    for (int k = 0; k < 2; ++k) {
      assert_true(lemke_path_settle(&r.path, engines[k], &r.built, 1));
      read_z(engines[k], &r.built, z[k]);
    }
    for (int i = 0; i < n; ++i) {
      check_close(z[0][i], z[1][i], 1e-15);
    }
  }
  free(r.memory);
}

/* A view reads the problem where it stands: same path, same numbers. */
static void a_view_is_the_built_system(void **state) {
  (void)state;
  static const lemke_tolerance tol = {1e-11, 1e-12, false};
  base_rng random = base_rng_seeded(5);
  rig r;
  rig_open(&r);
  for (int trial = 0; trial < 20; ++trial) {
    double z[2][N];
    pose(&r, &random, N, 1);
    for (int i = 0; i < N; ++i) { /* columns in units of their own, and q */
      r.q[i] = ldexp(r.q[i], -30);
      for (int j = 0; j < N; ++j) {
        r.M[j * N + i] = ldexp(r.M[j * N + i], 7 * (j % 5));
      }
    }
    for (int k = 0; k < 2; ++k) {
      if (k == 0) {
        lemke_system_build(&r.built, &r.store, &r.p, false);
      } else {
        assert_true(lemke_system_view(&r.built, &r.store, &r.p));
      }
      memset(r.path.in_z, 0, sizeof r.path.in_z[0] * N);
      assert_int_equal(lemke_path_run(&r.path, &r.table.engine, &r.built, tol), LEMKE_SOLVED);
      assert_true(lemke_path_settle(&r.path, &r.table.engine, &r.built, 1));
      read_z(&r.table.engine, &r.built, z[k]);
    }
    assert_memory_equal(z[0], z[1], sizeof z[0]);
  }
  free(r.memory);
}

/* A table that grew by pairs, some of their z basic before the next came, holds what one filled at once does. */
static void a_table_grows(void **state) {
  (void)state;
  base_rng random = base_rng_seeded(7);
  rig r;
  rig_open(&r);
  pose(&r, &random, N, 0.5);
  lemke_engine *e = &r.table.engine;
  lemke_table_clear(&r.table);
  for (int n = 0; n < N; ++n) {
    double column[N], row[N];
    for (int i = 0; i <= n; ++i) {
      column[i] = r.M[n * N + i];
      row[i] = r.M[i * N + n];
    }
    e->kind->append(e, column, row, r.q[n]);
    if (n % 3 == 0) {
      assert_true(lemke_path_take(&r.path, e, n));
    }
  }
  for (int i = 0; i < N; ++i) { /* w = M z + q with the values it holds */
    double w = r.q[i];
    for (int j = 0; j < N; ++j) {
      w += (e->where[N + j] < 0) ? 0 : r.M[j * N + i] * e->x[e->where[N + j]];
    }
    check_close(w, (e->where[i] < 0) ? 0 : e->x[e->where[i]], 1e-12);
  }
  free(r.memory);
}

/* The path takes a pivot of 1e-9 in a column of size 1, and the answer is right to the last digit all the same. */
static void a_small_pivot_costs_no_digit(void **state) {
  (void)state;
  const double M[4] = {1e-9, 1, 1, 1}, q[2] = {-1, 5};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = M}, .q = q};
  double z[2] = {0, 0};
  const lcp_result res = solve_by("lemke", "", &p, z);
  assert_int_equal(res.outcome, LCP_SOLVED);
  assert_string_equal(res.variant, "table");
  assert_int_equal(res.work.fallbacks, 0);
  check_close(z[0] * 1e-9, 1, 1e-15);
}

/* M y = 0 for a y > 0 that is no round number, q'y < 0: feasible once q is raised. */
static void phase_one_decides(void **state) {
  (void)state;
  base_rng random = base_rng_seeded(9);
  rig r;
  rig_open(&r);
  int proofs = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + trial % 6;
    const bool hopeless = trial % 2 == 0;
    double y[N], proof[N];
    for (int i = 0; i < n; ++i) {
      y[i] = base_rng_between(&random, 0.5, 2);
    }
    for (int j = 0; j < n; ++j) { /* (M'y)_j < 0 */
      double sum = 0;
      for (int i = 0; i < n; ++i) {
        r.M[j * n + i] = base_rng_between(&random, -1, 1);
        sum += y[i] * r.M[j * n + i];
      }
      r.M[j * n] -= (sum + 0.1) / y[0];
    }
    double value = 0;
    for (int i = 0; i < n; ++i) {
      r.q[i] = base_rng_between(&random, -1, 1);
      value += y[i] * r.q[i];
    }
    r.q[0] -= (value + 0.1) / y[0];
    for (int i = 0; i < n && !hopeless; ++i) {
      r.q[i] = fabs(r.q[i]); /* z = 0 is feasible */
    }
    r.p = (lcp_problem){.M = {.storage = LCP_DENSE, .n = n, .val = r.M}, .q = r.q};
    lemke_system_build(&r.built, &r.store, &r.p, false);
    const lemke_end end =
        lemke_phase_one(&r.path, &r.table, &r.built, (lemke_phase){.lift = 0}, proof);
    assert_int_equal(end, hopeless ? LEMKE_RAY : LEMKE_SOLVED);
    const bool proved = lemke_search_proof(&r.path, &r.table, &r.built, &r.p, proof);
    assert_int_equal(proved, hopeless);
    double z[N] = {0};
    const lcp_result res = solve_by("lemke", "", &r.p, z); /* the solver says so too */
    assert_true(!hopeless || res.outcome == LCP_INFEASIBLE);
    assert_true(hopeless || res.outcome != LCP_INFEASIBLE);
    proofs += proved;
  }
  assert_int_equal(proofs, 100);
  free(r.memory);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(both_engines_take_the_same_path),
      cmocka_unit_test(a_view_is_the_built_system),
      cmocka_unit_test(a_table_grows),
      cmocka_unit_test(a_small_pivot_costs_no_digit),
      cmocka_unit_test(phase_one_decides),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
