/* lemke: exact pivot counts, scalings, order of the unknowns, planted solutions, mixed problems,
 * warm starts, rays and proofs. The factored form: test_lemke_factored.c. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"

#include <string.h>

enum { N_MAX = 60 };

typedef struct small {
  int n;
  double M[N_MAX * N_MAX], q[N_MAX], z[N_MAX];
  lcp_problem p;
  lcp_result res;
  lcp_verdict v;
  unsigned char basis[N_MAX];
  double vector[N_MAX];
} small;

static double *at(small *s, int i, int j) {
  return &s->M[(ptrdiff_t)j * s->n + i];
}

static void start(small *s, int n) {
  memset(s, 0, sizeof *s);
  s->n = n;
  s->p = (lcp_problem){.M = {.storage = LCP_DENSE, .n = n, .val = s->M}, .q = s->q};
}

static void run_with(small *s, const char *options) {
  const lcp_solver *solver = lcp_solver_find("lemke");
  const lcp_capacity cap = lcp_problem_capacity(&s->p);
  unsigned char opt[512];
  base_error err = {0};
  lcp_instance *k = NULL;
  assert_true(solver->options_size <= sizeof opt);
  base_fields_default(solver->fields, solver->n_fields, opt);
  check_ok(base_fields_parse(solver->fields, solver->n_fields, opt, options, &err), &err);
  check_ok(lcp_instance_open(&k, solver, &cap, opt, &err), &err);
  check_ok(lcp_instance_prepare(k, &s->p, &err), &err);
  const long before = check_heap_calls;
  check_ok(lcp_instance_solve(k, NULL, s->z, &s->res, &err), &err);
  assert_int_equal(check_heap_calls, before);
  if (s->res.certificate.basis != NULL) {
    memcpy(s->basis, s->res.certificate.basis, (size_t)s->n);
  }
  if (s->res.certificate.vector != NULL) {
    memcpy(s->vector, s->res.certificate.vector, sizeof(double) * (size_t)s->n);
  }
  check_ok(lcp_judge(&s->p, s->z, &s->v, &err), &err);
  lcp_instance_close(k);
}

static void run(small *s) {
  run_with(s, "");
}

static void check_solved(const small *s) {
  if (s->res.outcome != LCP_SOLVED || !(s->v.rho <= 1e-12)) {
    fail_msg("%s, rho %.2g", lcp_outcome_name(s->res.outcome), s->v.rho);
  }
  assert_int_equal(s->res.certificate.kind, LCP_CERT_BASIS);
}

/* Lower Murty matrix L, or Fathi's L L'; q = -1. */
static void fill_exponential(small *s, int n, bool fathi) {
  start(s, n);
  for (int i = 0; i < n; ++i) {
    s->q[i] = -1;
    for (int j = 0; j < n; ++j) {
      const int low = (i < j) ? i : j;
      const double murty = (j < i) ? 2 : (i == j);
      *at(s, i, j) = fathi ? 4 * low + 2 - (i == j) : murty;
    }
  }
}

static void murty_and_fathi_take_two_to_the_n(void **state) {
  (void)state;
  for (int k = 4; k < 22; ++k) { /* n = 2 .. 10, both kinds */
    small s;
    fill_exponential(&s, k / 2, k % 2);
    run(&s);
    check_solved(&s);
    assert_int_equal(s.res.work.pivots, 1L << (k / 2));
    check_close(s.z[0], 1, 0);
  }
}

/* M = G'G / n + c I and a skew part, z and w planted with strict complementarity. */
static void plant(small *s, base_rng *r, int n, double shift, double skew) {
  double g[N_MAX * N_MAX];
  start(s, n);
  for (int k = 0; k < n * n; ++k) {
    g[k] = base_rng_between(r, -1, 1);
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      double sum = (i == j) ? shift : (i < j) ? skew * g[i * n + j] : -skew * g[j * n + i];
      for (int k = 0; k < n; ++k) {
        sum += g[k * n + i] * g[k * n + j] / n;
      }
      *at(s, i, j) = sum;
    }
  }
}

static void plant_solution(small *s, base_rng *r, double *z) {
  for (int i = 0; i < s->n; ++i) {
    const bool active = base_rng_uniform(r) < 0.5;
    z[i] = active ? base_rng_between(r, 0.5, 2) : 0;
    s->q[i] = active ? 0 : base_rng_between(r, 0.5, 2);
  }
  for (int i = 0; i < s->n; ++i) {
    for (int j = 0; j < s->n; ++j) {
      s->q[i] -= *at(s, i, j) * z[j];
    }
  }
}

static void planted_solutions_are_found(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(3);
  for (int trial = 0; trial < 60; ++trial) {
    small s;
    double z[N_MAX];
    const int n = 1 + trial;
    plant(&s, &r, (n < N_MAX) ? n : N_MAX, 0.5, (trial % 2) ? 1.0 : 0.0);
    plant_solution(&s, &r, z);
    run(&s);
    check_solved(&s);
    for (int i = 0; i < s.n; ++i) {
      check_close(s.z[i], z[i], 1e-11);
      assert_int_equal(s.basis[i] != 0, z[i] > 0);
    }
  }
}

/* D1 M D2, D1 q has the solution D2^-1 z. */
static void scaling_changes_nothing(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(5);
  static const int reach[] = {1, 10, 40, 100, 200};
  for (int trial = 0; trial < 5 * BASE_COUNT(reach); ++trial) {
    small s;
    small t;
    double z[N_MAX];
    const int span = reach[trial % BASE_COUNT(reach)];
    plant(&s, &r, 12, 0.5, 1);
    plant_solution(&s, &r, z);
    start(&t, s.n);
    int row[N_MAX];
    int col[N_MAX];
    for (int i = 0; i < s.n; ++i) {
      row[i] = (int)base_rng_between(&r, -span, span);
      col[i] = (int)base_rng_between(&r, -span, span);
      t.q[i] = ldexp(s.q[i], row[i]);
    }
    for (int i = 0; i < s.n; ++i) {
      for (int j = 0; j < s.n; ++j) {
        *at(&t, i, j) = ldexp(*at(&s, i, j), row[i] + col[j]);
      }
    }
    run(&t);
    check_solved(&t);
    for (int i = 0; i < s.n; ++i) {
      check_close(ldexp(t.z[i], col[i]), z[i], 1e-10);
    }
  }
}

static void order_does_not_matter(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(7);
  for (int trial = 0; trial < 20; ++trial) {
    small s;
    small t;
    double z[N_MAX];
    int to[N_MAX];
    plant(&s, &r, 30, 0.2, 0.5);
    plant_solution(&s, &r, z);
    start(&t, s.n);
    for (int i = 0; i < s.n; ++i) {
      const int k = (int)(base_rng_uniform(&r) * (i + 1));
      to[i] = to[k];
      to[k] = i;
    }
    for (int i = 0; i < s.n; ++i) {
      t.q[to[i]] = s.q[i];
      for (int j = 0; j < s.n; ++j) {
        *at(&t, to[i], to[j]) = *at(&s, i, j);
      }
    }
    run(&t);
    check_solved(&t);
    for (int i = 0; i < s.n; ++i) {
      check_close(t.z[to[i]], z[i], 1e-11);
    }
  }
}

/* A bar on three contacts, the middle one too low or too high by less than a tie: the basis that the
 * first path takes for equal is put right without a new start. */
static void redundant_contacts_are_right_to_rounding(void **state) {
  (void)state;
  static const int order[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int k = 0; k < 12; ++k) {
    const double error = (k < 6) ? 5e-13 : -5e-13;
    small s;
    start(&s, 3);
    for (int i = 0; i < 3; ++i) {
      const int x = order[k % 6][i] - 1;
      s.q[i] = -1 + ((x == 0) ? error : 0);
      for (int j = 0; j < 3; ++j) {
        *at(&s, i, j) = 1 + x * (order[k % 6][j] - 1);
      }
    }
    run(&s);
    check_solved(&s);
    assert_true(s.v.rho <= 1e-15);
    assert_int_equal(s.res.work.fallbacks, 0);
  }
}

static void warm_start_takes_no_pivot(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(9);
  small s;
  double z[N_MAX];
  plant(&s, &r, 40, 0.5, 1);
  plant_solution(&s, &r, z);
  run(&s);
  assert_true(s.res.work.pivots > 0);
  run(&s); /* z holds the solution */
  check_solved(&s);
  assert_int_equal(s.res.work.pivots, 0);
  for (int i = 0; i < s.n; ++i) {
    s.z[i] = 1; /* a wrong support */
  }
  run(&s);
  check_solved(&s);
}

static void two_runs_give_the_same_bits(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(11);
  small s;
  small t;
  double z[N_MAX];
  plant(&s, &r, 50, 0, 0.3);
  plant_solution(&s, &r, z);
  t = s;
  t.p.M.val = t.M;
  t.p.q = t.q;
  run(&s);
  run(&t);
  assert_memory_equal(s.z, t.z, sizeof(double) * (size_t)s.n);
  assert_int_equal(s.res.work.pivots, t.res.work.pivots);
}

/* One closing gap between two walls: [1 -1; -1 1], q = (-1, -1) has y = (1, 1). */
static void infeasible_is_proved(void **state) {
  (void)state;
  small s;
  start(&s, 2);
  *at(&s, 0, 0) = *at(&s, 1, 1) = 1;
  *at(&s, 0, 1) = *at(&s, 1, 0) = -1;
  s.q[0] = s.q[1] = -1;
  run(&s);
  assert_int_equal(s.res.outcome, LCP_INFEASIBLE);
  assert_int_equal(s.res.certificate.kind, LCP_CERT_FARKAS);
  assert_true(s.vector[0] > 0);
  check_close(s.vector[0], s.vector[1], 0);
}

/* M = G G' of rank 2 in rounded numbers, y > 0 in its null space, q'y < 0: infeasible but for
 * rounding, which makes M regular and "solved" by z of 1e16. */
static void rounding_makes_nothing_feasible(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(17);
  for (int trial = 0; trial < 200; ++trial) {
    small s;
    double g[3][2];
    start(&s, 3);
    for (int k = 0; k < 2; ++k) { /* columns orthogonal to y = (0.3, 0.7, 1.1) */
      g[0][k] = base_rng_between(&r, -1, 1);
      g[1][k] = base_rng_between(&r, -1, 1);
      g[2][k] = -(0.3 * g[0][k] + 0.7 * g[1][k]) / 1.1;
    }
    for (int i = 0; i < 3; ++i) {
      s.q[i] = base_rng_between(&r, -1, -0.1);
      for (int j = 0; j < 3; ++j) {
        *at(&s, i, j) = g[i][0] * g[j][0] + g[i][1] * g[j][1];
      }
    }
    run(&s);
    assert_true(s.res.outcome != LCP_SOLVED);
    assert_true(s.res.outcome != LCP_INFEASIBLE || s.res.certificate.kind == LCP_CERT_FARKAS);
  }
}

/* Feasible but unsolvable: a ray proves nothing and must not be called a proof. */
static void ray_is_not_a_proof(void **state) {
  (void)state;
  small s;
  start(&s, 2);
  *at(&s, 0, 1) = 1;
  s.q[0] = -1;
  s.q[1] = 1;
  run(&s);
  assert_int_equal(s.res.outcome, LCP_RAY);
  assert_int_equal(s.res.certificate.kind, LCP_CERT_RAY);
}

/* Bimatrix games end on a ray from the origin; the restart finds the equilibrium. */
static void bimatrix_game_is_solved(void **state) {
  (void)state;
  static const double M[16] = {0, 0, 10, 20, 0, 0, 30, 15, 10, 20, 0, 0, 30, 15, 0, 0};
  small s;
  start(&s, 4);
  memcpy(s.M, M, sizeof M);
  s.q[0] = s.q[1] = s.q[2] = s.q[3] = -1;
  run_with(&s, "restarts=0");
  assert_int_equal(s.res.outcome, LCP_RAY);
  memset(s.z, 0, sizeof s.z);
  run(&s);
  check_solved(&s);
  assert_string_equal(s.res.variant, "restarted");
  assert_true(s.res.work.fallbacks > 0);
}

static void pivot_limit_is_reported(void **state) {
  (void)state;
  small s;
  start(&s, 8);
  for (int i = 0; i < 8; ++i) {
    s.q[i] = -1;
    for (int j = 0; j <= i; ++j) {
      *at(&s, i, j) = (i == j) ? 1 : 2;
    }
  }
  run_with(&s, "max_iter=100");
  assert_int_equal(s.res.outcome, LCP_MAX_ITER);
  assert_int_equal(s.res.work.pivots, 100);
}

/* Makes the block of free rows zero. */
static void clear_block(small *s, int n) {
  for (int k = 0; k < n * n; ++k) {
    *at(s, k / n, k % n) = 0;
  }
}

/* Row and column 1 repeat row and column 0. */
static void repeat_first(small *s) {
  for (int i = 0; i < s->n; ++i) {
    *at(s, i, 1) = *at(s, i, 0);
  }
  for (int j = 0; j < s->n; ++j) {
    *at(s, 1, j) = *at(s, 0, j);
  }
}

/* q such that z, of any sign in the free rows, solves. */
static void plant_mixed(small *s, base_rng *r, int n_free, double *z) {
  plant_solution(s, r, z); /* for w of the bounded rows */
  for (int i = 0; i < s->n; ++i) {
    double w = s->q[i];
    for (int j = 0; j < s->n; ++j) {
      w += *at(s, i, j) * z[j];
    }
    s->q[i] = (i < n_free || z[i] > 0) ? 0 : w;
  }
  for (int i = 0; i < n_free; ++i) {
    z[i] = base_rng_between(r, -1, 1);
  }
  for (int i = 0; i < s->n; ++i) {
    for (int j = 0; j < s->n; ++j) {
      s->q[i] -= *at(s, i, j) * z[j];
    }
  }
}

/* Free rows first; M_FF regular, zero (a saddle point) and redundant. */
static void mixed_problems(void **state) {
  (void)state;
  enum { N_FREE = 4 };
  base_rng r = base_rng_seeded(13);
  const lcp_block block[2] = {{.start = 0, .size = N_FREE, .set = LCP_FREE},
                              {.start = N_FREE, .size = 16, .set = LCP_ORTHANT}};
  for (int trial = 0; trial < 30; ++trial) {
    small s;
    double z[N_MAX];
    plant(&s, &r, N_FREE + 16, 0.5, 0.5);
    if (trial % 3 == 1) {
      clear_block(&s, N_FREE);
    } else if (trial % 3 == 2) {
      repeat_first(&s);
    }
    plant_mixed(&s, &r, N_FREE, z);
    s.p.block = block;
    s.p.n_block = 2;
    run(&s);
    check_solved(&s);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(murty_and_fathi_take_two_to_the_n),
      cmocka_unit_test(planted_solutions_are_found),
      cmocka_unit_test(scaling_changes_nothing),
      cmocka_unit_test(order_does_not_matter),
      cmocka_unit_test(redundant_contacts_are_right_to_rounding),
      cmocka_unit_test(warm_start_takes_no_pivot),
      cmocka_unit_test(two_runs_give_the_same_bits),
      cmocka_unit_test(infeasible_is_proved),
      cmocka_unit_test(rounding_makes_nothing_feasible),
      cmocka_unit_test(ray_is_not_a_proof),
      cmocka_unit_test(bimatrix_game_is_solved),
      cmocka_unit_test(pivot_limit_is_reported),
      cmocka_unit_test(mixed_problems),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
