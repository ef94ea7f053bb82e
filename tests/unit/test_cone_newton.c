/* The maps of cone_map.h and the proximal Newton method built on them. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/lcp_instance.h"
#include "lcp/solvers/cone_map.h"
#include "tests/support/random_cones.h"
#include "tests/support/solve.h"

#include <stdio.h>
#include <string.h>

static const lcp_block shapes[] = {
    {.size = 1, .set = LCP_ORTHANT},
    {.size = 1, .set = LCP_BOX},
    {.size = 1, .set = LCP_FREE},
    {.size = 1, .set = LCP_CONE},
    {.size = 2, .set = LCP_CONE, .n_part = 1, .part_dim = {1}, .part_mu = {0.7}},
    {.size = 3, .set = LCP_CONE, .n_part = 1, .part_dim = {2}, .part_mu = {0}},
    {.size = 3, .set = LCP_CONE, .n_part = 1, .part_dim = {2}, .part_mu = {2.5}},
    {.size = 6, .set = LCP_CONE, .n_part = 3, .part_dim = {2, 1, 2}, .part_mu = {0.8, 0.1, 0.3}},
};
static const double lo = -0.4, hi = 0.6;

static void draw(base_rng *r, int n, double *x) {
  for (int i = 0; i < n; i++) {
    x[i] = base_rng_normal(r);
  }
}

/* X and Y against central differences, at points that are no kinks almost surely. */
static void derivatives_are_those_of_the_map(void **state) {
  (void)state;
  enum { N = LCP_CONE_MAX };
  base_rng r = base_rng_seeded(11);
  const double h = 1e-6;
  for (int trial = 0; trial < 400; trial++) {
    const lcp_block *b = &shapes[trial % BASE_COUNT(shapes)];
    const lcp_map map = (trial / 100 % 2 == 0) ? LCP_MAP_MIN : LCP_MAP_FISCHER;
    double v[2 * N], F[N], X[N * N], Y[N * N], up[N], down[N];
    double *x = v, *y = v + N;
    const bool interval = b->set != LCP_CONE;
    draw(&r, 2 * N, v);
    lcp_cone_map(map, b, NULL, lo, hi, x, y, F, X, Y);
    for (int j = 0; j < 2 * b->size; j++) {
      double *moved = (j < b->size) ? &x[j] : &y[j - b->size];
      const double *column = (j < b->size) ? X + j * b->size : Y + (j - b->size) * b->size;
      const double old = *moved;
      *moved = old + h;
      lcp_cone_map(map, b, NULL, lo, interval ? hi : 0, x, y, up, NULL, NULL);
      *moved = old - h;
      lcp_cone_map(map, b, NULL, lo, interval ? hi : 0, x, y, down, NULL, NULL);
      *moved = old;
      for (int i = 0; i < b->size; i++) {
        check_close(column[i], (up[i] - down[i]) / (2 * h), 1e-6);
      }
    }
  }
}

/* One contact A z + b, answered to rounding by bracketing (cone_block.h): both maps vanish there, and not beside it. */
static void maps_vanish_at_contact_solutions_only(void **state) {
  (void)state;
  enum { N = LCP_CONE_MAX };
  base_rng r = base_rng_seeded(12);
  for (int trial = 0; trial < 400; trial++) {
    const lcp_block *k = &shapes[4 + trial % 4];
    const int n = k->size;
    double A[N * N], b[N], z[N], w[N], F[N], G[N * N];
    draw(&r, n * n, G);
    draw(&r, n, b);
    for (int e = 0; e < n * n; e++) {
      A[e] = (e % (n + 1) == 0) ? 0.5 : 0.0;
      for (int l = 0; l < n; l++) {
        A[e] += G[e / n + l * n] * G[e % n + l * n];
      }
    }
    lcp_cone_solve(k, A, b, z);
    for (int i = 0; i < n; i++) {
      w[i] = b[i];
      for (int j = 0; j < n; j++) {
        w[i] += A[i + j * n] * z[j];
      }
    }
    for (int map = 0; map < 2; map++) {
      double off = 0;
      lcp_cone_map((map == 0) ? LCP_MAP_MIN : LCP_MAP_FISCHER, k, NULL, 0, 0, z, w, F, NULL, NULL);
      for (int i = 0; i < n; i++) {
        check_close(F[i], 0.0, 1e-6); /* Fischer-Burmeister: the root of what rounding leaves */
      }
      w[0] -= 0.1;
      z[0] += 0.1;
      lcp_cone_map((map == 0) ? LCP_MAP_MIN : LCP_MAP_FISCHER, k, NULL, 0, 0, z, w, F, NULL, NULL);
      for (int i = 0; i < n; i++) {
        off = fmax(off, fabs(F[i]));
      }
      assert_true(off > 1e-3);
      w[0] += 0.1;
      z[0] -= 0.1;
    }
  }
}

/* Solves from z; false where the solver refuses the problem. */
static bool run(const lcp_problem *p, const char *options, double *z, lcp_result *res,
                base_error *err) {
  const base_status prepared = try_solve("cone_newton", options, p, z, res, err);
  assert_true(prepared == BASE_OK || prepared == BASE_EUNSUPPORTED);
  return prepared == BASE_OK;
}

/* Of random sets at most one in fifty is given up, in no storage is a claim false, and an answer is its own warm start. */
static void random_sets_are_solved_and_never_claimed_falsely(void **state) {
  (void)state;
  enum { SETS = 100, DENSE = 80 /* rows: beyond that LAPACK's cube is felt */ };
  static const char *const maps[] = {"map=alart_curnier", "map=fischer"};
  int solved[3] = {0}, posed[3] = {0};
  for (int seed = 1; seed <= SETS; seed++) {
    known_lcp k;
    lcp_csc csc;
    base_error err = {0};
    check_ok(random_cones(&k, (uint64_t)seed, &err), &err);
    const int n = k.p.M.n;
    double *z = calloc((size_t)n, sizeof *z);
    double *dense = calloc((size_t)n * (size_t)n, sizeof *dense);
    assert_true(z != NULL && dense != NULL);
    check_ok(lcp_matrix_to_csc(&k.p.M, &csc, &err), &err);
    lcp_matrix_to_dense(&k.p.M, dense);
    const lcp_matrix stored[3] = {k.p.M,
                                  {.storage = LCP_CSC, .n = n, .csc = csc},
                                  {.storage = LCP_DENSE, .n = n, .val = dense}};
    for (int st = 0; st < ((n <= DENSE) ? 3 : 2); st++) {
      lcp_problem p = k.p;
      lcp_result res;
      lcp_verdict v;
      p.M = stored[st];
      posed[st]++;
      memset(z, 0, (size_t)n * sizeof *z);
      assert_true(run(&p, maps[seed % 2], z, &res, &err));
      check_ok(lcp_judge(&p, z, &v, &err), &err);
      if (res.outcome == LCP_SOLVED) {
        solved[st]++;
        double top = 0;
        for (int i = 0; i < n; i++) {
          top = fmax(top, fabs(z[i]));
        }
        if (!(v.rho <= 1e-9 && v.infeasible_z <= 1e-12 * top)) {
          print_message("seed %d storage %d: rho %g, out of the cone by %g of %g\n", seed, st,
                        v.rho, v.infeasible_z, top);
        }
        assert_true(run(&p, "", z, &res, &err));
        assert_string_equal(lcp_outcome_name(res.outcome), "ok");
        assert_true(res.work.factorizations <= 2 || v.infeasible_z > 1e-12 * top);
      } else {
        assert_true(res.residual > 0.0 && v.rho <= 1.01 * res.residual + 1e-12);
      }
    }
    lcp_csc_free(&csc);
    free(z);
    free(dense);
    known_lcp_free(&k);
  }
  for (int st = 0; st < 3; st++) {
    print_message("storage %d: %d of %d solved\n", st, solved[st], posed[st]);
    assert_true(posed[st] >= SETS / 3 && posed[st] - solved[st] <= SETS / 50);
  }
}

/* An instance whose workspace was given back solves nothing until it is prepared again, and then the same to the last bit. */
static void a_rested_instance_is_prepared_again(void **state) {
  (void)state;
  known_lcp k;
  base_error err = {0};
  lcp_result first, again, refused;
  lcp_instance *instance;
  _Alignas(16) unsigned char opt[512] = {0};
  double z[512] = {0}, other[512] = {0};
  const lcp_solver *s = lcp_solver_find("cone_newton");
  check_ok(random_cones(&k, 8, &err), &err);
  assert_true(k.p.M.n <= 512 && s->options_size <= sizeof opt);
  const lcp_capacity cap = lcp_problem_capacity(&k.p);
  base_fields_default(s->fields, s->n_fields, opt);
  check_ok(lcp_instance_open(&instance, s, &cap, opt, &err), &err);
  check_ok(lcp_instance_prepare(instance, &k.p, &err), &err);
  check_ok(lcp_instance_solve(instance, NULL, z, &first, &err), &err);
  const size_t bytes = lcp_instance_bytes(instance);
  lcp_instance_rest(instance);
  assert_int_equal(lcp_instance_bytes(instance), bytes);
  assert_int_equal(lcp_instance_solve(instance, NULL, other, &refused, &err), BASE_EINVAL);
  check_ok(lcp_instance_prepare(instance, &k.p, &err), &err);
  check_ok(lcp_instance_solve(instance, NULL, other, &again, &err), &err);
  lcp_instance_close(instance);
  assert_string_equal(lcp_outcome_name(first.outcome), "ok");
  assert_int_equal(again.work.iterations, first.work.iterations);
  assert_memory_equal(z, other, (size_t)k.p.M.n * sizeof *z);
  known_lcp_free(&k);
}

/* Contacts without friction, started from their answer: one test, which is two products (w, sizes of its terms), and z stays. */
static void an_answer_is_tested_once(void **state) {
  (void)state;
  enum { N = 3 };
  const double M[N * N] = {2, 1, 0, 1, 3, 1, 0, 1, 2}, q[N] = {-1, -2, 0.5};
  const lcp_problem p = {
      .M = {.storage = LCP_DENSE, .n = N, .val = M}, .q = q, .traits = LCP_SYMMETRIC | LCP_PSD};
  double z[N] = {0}, other[N];
  base_error err = {0};
  lcp_result res;
  assert_true(run(&p, "", z, &res, &err));
  assert_int_equal(res.outcome, LCP_SOLVED);
  assert_true(res.work.iterations > 0 && z[1] > 0);
  memcpy(other, z, sizeof z);
  assert_true(run(&p, "", other, &res, &err));
  assert_int_equal(res.outcome, LCP_SOLVED);
  assert_int_equal(res.work.iterations, 0);
  assert_int_equal(res.work.matvecs, 2);
  assert_memory_equal(z, other, sizeof z);
}

/* What the factored form cannot do is refused by name: a cone over two groups, an S that couples blocks. */
static void factored_form_refuses_what_it_cannot_split(void **state) {
  (void)state;
  known_lcp k;
  base_error err = {0};
  lcp_result res;
  double z[512] = {0};
  check_ok(random_cones(&k, 8, &err), &err);
  assert_true(k.p.n_block >= 2 && k.p.M.n <= 512);
  lcp_factored f = *k.p.M.factored;
  lcp_problem p = k.p;
  p.M.factored = &f;
  assert_true(run(&p, "", z, &res, &err));

  int *colptr = calloc((size_t)p.M.n + 1, sizeof *colptr);
  assert_non_null(colptr);
  const int other = p.block[1].start;
  const double one = 1.0;
  for (int j = 1; j <= p.M.n; j++) {
    colptr[j] = 1; /* one entry: row `other`, column 0 */
  }
  const lcp_csc shift = {p.M.n, p.M.n, colptr, &other, &one};
  f.shift = &shift;
  assert_false(run(&p, "", z, &res, &err));
  assert_non_null(strstr(err.text, "couples"));
  f.shift = NULL;

  lcp_block joined[512]; /* the first two blocks as one, then the others */
  memcpy(joined, p.block + 1, (size_t)(p.n_block - 1) * sizeof *joined);
  joined[0] = p.block[0];
  joined[0].size += p.block[1].size;
  joined[0].n_part = 0;
  p.block = joined;
  p.n_block--;
  assert_true(joined[0].size <= LCP_CONE_MAX);
  assert_false(run(&p, "", z, &res, &err));
  assert_non_null(strstr(err.text, "two groups"));
  free(colptr);
  known_lcp_free(&k);
}

/* Nothing acts on the last row, which starts from an impulse of before: its answer is zero, and any share of the start that is left,
 * however small, is all of its own row's residual. The others press, and end at rounding. In every second problem rounding in M couples
 * the row to one of them. */
static void what_nothing_acts_on_ends_at_zero(void **state) {
  (void)state;
  enum { LOADED = 10, N = LOADED + 1 };
  for (int seed = 1; seed <= 20; seed++) {
    base_rng r = base_rng_seeded((uint64_t)seed);
    double M[N * N] = {0}, G[LOADED * LOADED], q[N] = {0}, z[N], low[N] = {0}, high[N];
    lcp_block block[N];
    draw(&r, LOADED * LOADED, G);
    for (int i = 0; i < N; i++) {
      for (int j = 0; j < LOADED && i < LOADED; j++) {
        M[i + N * j] = (i == j) ? 0.5 : 0.0;
        for (int l = 0; l < LOADED; l++) {
          M[i + N * j] += G[i + LOADED * l] * G[j + LOADED * l];
        }
      }
      q[i] = (i < LOADED) ? -fabs(base_rng_normal(&r)) : 0;
      z[i] = 0.01 * (i + 1);
      high[i] = HUGE_VAL;
      block[i] = (lcp_block){.start = i, .size = 1, .set = LCP_ORTHANT};
    }
    M[N * N - 1] = 2.33;
    M[N - 1] = M[N * (N - 1)] = (seed % 2 == 0) ? 7.8e-18 : 0.0;
    block[LOADED].set = LCP_BOX;
    low[LOADED] = -0.2;
    high[LOADED] = 0.2;
    const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = N, .val = M},
                           .q = q,
                           .lo = low,
                           .hi = high,
                           .block = block,
                           .n_block = N,
                           .traits = LCP_SYMMETRIC | LCP_PSD};
    lcp_result res;
    lcp_verdict v;
    base_error err = {0};
    assert_true(run(&p, "", z, &res, &err));
    check_ok(lcp_judge(&p, z, &v, &err), &err);
    assert_string_equal(lcp_outcome_name(res.outcome), "ok");
    assert_true(v.rho <= 1e-10 && res.work.iterations < 100);
    assert_true(z[LOADED] == 0 || M[N - 1] != 0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(derivatives_are_those_of_the_map),
      cmocka_unit_test(maps_vanish_at_contact_solutions_only),
      cmocka_unit_test(random_sets_are_solved_and_never_claimed_falsely),
      cmocka_unit_test(a_rested_instance_is_prepared_again),
      cmocka_unit_test(an_answer_is_tested_once),
      cmocka_unit_test(factored_form_refuses_what_it_cannot_split),
      cmocka_unit_test(what_nothing_acts_on_ends_at_zero),
  };
  return cmocka_run_group_tests_name("cone_newton", tests, NULL, NULL);
}
