/* lcp_problem_check finds every kind of damage and names it; the stopping test is never kinder than
 * the judge; the judge on boxes, free rows, cones and the factored form. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/lcp_judge.h"
#include "lcp/lcp_rho.h"
#include "lcp/lcp_solver.h"
#include "tests/support/golden.h"

#include <string.h>

/* A factored problem of two bodies and two groups, with every array writable. */
typedef struct bench {
  int dof_start[3], weight_start[3], row_start[3], body[4], jac_start[3];
  double weight[2], jac[4], q[2], lo[2], hi[2], dense[4];
  int colptr[3], rowind[4];
  lcp_factored f;
  lcp_block block[2];
  lcp_problem p;
} bench;

static void build(bench *b) {
  *b = (bench){.dof_start = {0, 1, 2},
               .weight_start = {0, 1, 2},
               .row_start = {0, 1, 2},
               .body = {0, -1, 0, 1},
               .jac_start = {0, 1, 3},
               .weight = {0.5, 0.25},
               .jac = {1, -1, 1},
               .q = {-1.5, -2.5},
               .lo = {-1, -1},
               .hi = {2, 2},
               .dense = {2, 1, 1, 3},
               .colptr = {0, 2, 4},
               .rowind = {0, 1, 0, 1}};
  b->f = (lcp_factored){.n_body = 2,
                        .dof_start = b->dof_start,
                        .weight_start = b->weight_start,
                        .weight = b->weight,
                        .n_group = 2,
                        .row_start = b->row_start,
                        .body = b->body,
                        .jac_start = b->jac_start,
                        .jac = b->jac};
  b->block[0] = (lcp_block){
      .start = 0, .size = 2, .set = LCP_CONE, .n_part = 1, .part_dim = {1}, .part_mu = {0.5}};
  b->p = (lcp_problem){.M = {.storage = LCP_FACTORED, .n = 2, .factored = &b->f},
                       .q = b->q,
                       .lo = b->lo,
                       .hi = b->hi,
                       .block = b->block,
                       .n_block = 1};
}

static void as_csc(bench *b) {
  b->p.M = (lcp_matrix){.storage = LCP_CSC, .n = 2, .csc = {2, 2, b->colptr, b->rowind, b->dense}};
}

static void expect_refused(const bench *b, const char *says) {
  base_error err = {0};
  assert_int_equal(lcp_problem_check(&b->p, &err), BASE_EINVAL);
  if (strstr(err.text, says) == NULL) {
    fail_msg("'%s' does not say '%s'", err.text, says);
  }
}

#define REFUSED(damage, says)                                                                      \
  do {                                                                                             \
    build(&b);                                                                                     \
    damage;                                                                                        \
    expect_refused(&b, says);                                                                      \
  } while (0)

static void every_damage_is_named(void **state) {
  (void)state;
  bench b;
  base_error err = {0};
  build(&b);
  check_ok(lcp_problem_check(&b.p, &err), &err);
  REFUSED(b.p.M.n = -1, "n=-1");
  REFUSED(b.p.M.storage = (lcp_storage)9, "storage 9");
  REFUSED(b.p.M.factored = NULL, "missing");
  REFUSED(b.p.q = NULL, "q: missing");
  REFUSED(b.q[1] = HUGE_VAL, "q[1]");
  REFUSED(b.dof_start[0] = 1, "dof_start");
  REFUSED(b.row_start[1] = 3, "row_start[2]");
  REFUSED(b.row_start[2] = 1, "rows");
  REFUSED(b.body[3] = 2, "body 2");
  REFUSED(b.body[3] = 0, "two different");
  REFUSED(b.jac_start[2] = 4, "group 1");
  REFUSED(b.weight_start[2] = 3, "body 1");
  REFUSED(b.weight[0] = NAN, "W[0]");
  REFUSED(b.jac[2] = -HUGE_VAL, "J[2]");
  REFUSED(b.block[0].n_part = 4, "4 parts");
  REFUSED(b.block[0].part_mu[0] = -0.1, "coefficient");
  REFUSED(b.block[0].part_dim[0] = 2, "need 3");
  REFUSED(b.block[0].start = 1, "block 0");
  REFUSED(b.block[0].size = 1; b.block[0].set = LCP_FREE, "cover 1 rows");
  REFUSED(b.block[0].set = (lcp_set)7, "unknown set 7");
  REFUSED(b.block[0].set = LCP_BOX; b.lo[1] = 3, "box row 1");
  REFUSED(b.block[0].set = LCP_BOX; b.hi[0] = NAN, "box row 0");
  REFUSED(b.block[0].set = LCP_BOX; b.p.lo = NULL, "box row 0");
  REFUSED(as_csc(&b); b.rowind[1] = 0, "row index 0");
  REFUSED(as_csc(&b); b.rowind[3] = 2, "row index 2");
  REFUSED(as_csc(&b); b.colptr[1] = 5, "decrease");
  REFUSED(as_csc(&b); b.p.M.csc.n_col = 3, "2 x 3");
  REFUSED(as_csc(&b); b.dense[2] = NAN, "M[2]");
}

static void weights_must_be_symmetric(void **state) {
  (void)state;
  const int dof_start[] = {0, 2};
  const int weight_start[] = {0, 4};
  const int row_start[] = {0, 1};
  const int body[] = {0, -1};
  const int jac_start[] = {0, 2};
  const double weight[] = {1, 0.25, 0.5, 1};
  const double jac[] = {1, 1};
  const double q[] = {1};
  const lcp_factored f = {1,    dof_start, weight_start, weight, 1,    row_start,
                          body, jac_start, jac,          NULL,   NULL, NULL};
  const lcp_problem p = {.M = {.storage = LCP_FACTORED, .n = 1, .factored = &f}, .q = q};
  base_error err = {0};
  assert_int_equal(lcp_problem_check(&p, &err), BASE_EINVAL);
  assert_non_null(strstr(err.text, "not symmetric"));
}

static void capacity_is_what_is_needed(void **state) {
  (void)state;
  bench b;
  build(&b);
  lcp_capacity c = lcp_problem_capacity(&b.p);
  assert_int_equal(c.n, 2);
  assert_int_equal(c.n_dof, 2);
  assert_int_equal(c.n_jac, 3);
  assert_int_equal(c.n_weight, 2);
  assert_int_equal(c.nnz, 0);
  assert_true(lcp_capacity_holds(&c, &c));
  lcp_capacity less = c;
  less.n_jac = 2;
  assert_false(lcp_capacity_holds(&less, &c));
  as_csc(&b);
  c = lcp_problem_capacity(&b.p);
  assert_int_equal(c.nnz, 4);
  assert_int_equal(lcp_problem_sets(&b.p), 1u << LCP_CONE);
}

static lcp_verdict judged(const lcp_problem *p, const double *z) {
  lcp_verdict v;
  base_error err = {0};
  check_ok(lcp_judge(p, z, &v, &err), &err);
  return v;
}

/* M = diag(2, 4), q = (-3, 1): tau0 = (3 + 2 z1, 1 + 4 z2), zref = tau0/d, tau = |q| + tau0. */
static void judge_on_boxes_and_free_rows(void **state) {
  (void)state;
  const double M[] = {2, 0, 0, 4};
  const double q[] = {-3, 1};
  const double lo[] = {-1, -1};
  const double hi[] = {0.5, 1};
  lcp_block block[] = {{.start = 0, .size = 2, .set = LCP_BOX}};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = M},
                         .q = q,
                         .lo = lo,
                         .hi = hi,
                         .block = block,
                         .n_block = 1};
  const double at[] = {0.5, -0.25}; /* w = (-2, 0): at the upper end, and inside */
  assert_true(judged(&p, at).rho == 0 && judged(&p, at).natural == 0);
  const double inside[] = {0.25, -0.25}; /* w = (-2.5, 0): room 0.25, d room 0.5 */
  check_close(judged(&p, inside).natural, 0.5, 0.0);
  check_close(judged(&p, inside).rho, 0.25 / (3.5 / 2), 1e-15);
  const double outside[] = {0.75, -0.25};
  check_close(judged(&p, outside).infeasible_z, 0.25, 0.0);
  block[0].set = LCP_FREE;
  const double root[] = {1.5, -0.25};
  assert_true(judged(&p, root).rho == 0);
  const double off[] = {1, -0.25}; /* w = (-1, 0), tau = 3 + 5 */
  check_close(judged(&p, off).rho, 1.0 / 8, 1e-15);
  check_close(judged(&p, off).infeasible_w, 1.0, 0.0);
}

/* w_1 = -1e500 is far from feasible, but as double it is infinite, and so is its scale: their ratio is no number,
 * which fmin would drop in favour of z_1 = 0. */
static void judge_sees_what_leaves_the_range(void **state) {
  (void)state;
  const double M[] = {1e300, 0, -1e300, 1}, q[] = {1, -1e200}, z[] = {0, 1e200};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = M}, .q = q};
  const lcp_verdict v = judged(&p, z);
  assert_true(v.finite);
  assert_true(v.rho == HUGE_VAL && v.natural == HUGE_VAL && v.infeasible_w == HUGE_VAL);
}

/* The factored form, its dense copy and the cone: the same verdict, by different roads. */
static void judge_is_the_same_in_every_storage(void **state) {
  (void)state;
  bench b;
  build(&b);
  b.block[0] = (lcp_block){.start = 0, .size = 2, .set = LCP_ORTHANT};
  const double z[] = {1.25, 0.5};
  const lcp_verdict factored = judged(&b.p, z);
  double dense[4];
  lcp_matrix_to_dense(&b.p.M, dense);
  /* rows (1 on body 0), (-1 on body 0, 1 on body 1): M = [.5 -.5; -.5 .75] */
  check_close(dense[1], -0.5, 0.0);
  check_close(dense[3], 0.75, 0.0);
  b.p.M = (lcp_matrix){.storage = LCP_DENSE, .n = 2, .val = dense};
  const lcp_verdict plain = judged(&b.p, z);
  assert_true(factored.rho == plain.rho && factored.natural == plain.natural);
  /* w = (.625 - .25 - 1.5, -.625 + .375 - 2.5) */
  check_close(plain.natural, 2.75, 1e-15);
}

/* Random points of every golden problem: the solvers' own residual is the judge's, or larger. */
static void stopping_is_never_kinder_than_judging(void **state) {
  (void)state;
  int count;
  const golden *g = goldens(&count);
  base_rng r = base_rng_seeded(20170316);
  for (int i = 0; i < count; i++) {
    const lcp_problem *p = &g[i].p;
    const lcp_capacity cap = lcp_problem_capacity(p);
    lcp_stop_state s = {0};
    base_arena need = base_arena_measuring();
    lcp_stop_layout(&s, &cap, &need);
    void *mem = base_alloc(need.used);
    double *z = calloc((size_t)p->M.n, sizeof *z);
    assert_true(mem != NULL && z != NULL);
    base_arena a = base_arena_over(mem, need.used);
    lcp_stop_layout(&s, &cap, &a);
    lcp_stop_begin(&s, p);
    for (int trial = 0; trial < 20; trial++) {
      for (int k = 0; k < p->M.n; k++) {
        z[k] = fmax(0.0, base_rng_normal(&r));
      }
      const lcp_stop stop = {.tol = 0, .max_iter = 1, .check_every = 1, .max_seconds = 60};
      lcp_result res = {.work.iterations = 1};
      assert_true(lcp_stop_test(&s, &stop, p, z, NULL, &res));
      const double rho = judged(p, z).rho;
      if (!(res.residual >= rho * (1 - 1e-12))) {
        fail_msg("%s: %g is kinder than %g", g[i].name, res.residual, rho);
      }
      if (p->M.storage != LCP_FACTORED) {
        check_close(res.residual, rho, 1e-12 * rho);
      }
    }
    free(z);
    free(mem);
  }
}

/* Where a term of M z overflows, w is inf - inf. fmin and fmax would drop it, and z = (1e300, 1e300) would solve this. */
static void rho_of_no_number_is_no_number(void **state) {
  (void)state;
  static const lcp_set sets[] = {LCP_ORTHANT, LCP_BOX, LCP_FREE, LCP_CONE};
  const double M[] = {1e200, 1e200, -1e200, -1e200}, q[] = {-1, -1}, z[] = {1e300, 1e300};
  for (int k = 0; k < BASE_COUNT(sets); k++) {
    const double lo[] = {1e300, 1e300}, hi[] = {HUGE_VAL, HUGE_VAL};
    const lcp_block block = {
        .size = 2, .set = sets[k], .n_part = 1, .part_dim = {1}, .part_mu = {0.5}};
    const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = M},
                           .q = q,
                           .lo = lo,
                           .hi = hi,
                           .block = &block,
                           .n_block = 1};
    double w[2], tau0[2], tau[2], zref[2], d[2];
    lcp_matrix_diagonal(&p.M, d);
    lcp_rho_product(&p, z, w, tau0);
    assert_true(w[0] != w[0]);
    lcp_rho_references(&p, d, tau0, zref);
    lcp_rho_product(&p, zref, NULL, tau);
    const double rho = lcp_rho(&p, d, z, w, zref, tau);
    assert_false(rho < HUGE_VAL);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_damage_is_named),
      cmocka_unit_test(weights_must_be_symmetric),
      cmocka_unit_test(capacity_is_what_is_needed),
      cmocka_unit_test(judge_on_boxes_and_free_rows),
      cmocka_unit_test(judge_sees_what_leaves_the_range),
      cmocka_unit_test(judge_is_the_same_in_every_storage),
      cmocka_unit_test(stopping_is_never_kinder_than_judging),
      cmocka_unit_test(rho_of_no_number_is_no_number),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
