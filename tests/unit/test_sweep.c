/* Gauss-Seidel methods: rates and cycles that theory fixes, local problems solved to rounding, and the
 * matrix-free sweep against a plain one. */
#include "tests/support/check.h"

#include "lcp/base/crew.h"
#include "lcp/base/rng.h"
#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"
#include "lcp/solvers/cone_block.h"
#include "lcp/solvers/cone_parts.h"
#include "lcp/solvers/contact_sweep.h"
#include "lcp/solvers/lemke/block.h"
#include "tests/support/plain_sweep.h"

#include <string.h>

enum { OPT_MAX = 256 };

/* Options "a=b,..." of the solver called name, in buf. */
static const lcp_solver *solver(const char *name, const char *options, void *buf) {
  const lcp_solver *s = lcp_solver_find(name);
  base_error err = {0};
  assert_non_null(s);
  assert_true(s->options_size <= OPT_MAX);
  base_fields_default(s->fields, s->n_fields, buf);
  check_ok(base_fields_parse(s->fields, s->n_fields, buf, options, &err), &err);
  return s;
}

static lcp_result run(const char *name, const char *options, const lcp_problem *p, double *z,
                      lcp_trace *trace) {
  _Alignas(16) unsigned char opt[OPT_MAX] = {0};
  const lcp_solver *s = solver(name, options, opt);
  const lcp_capacity cap = lcp_problem_capacity(p);
  base_error err = {0};
  lcp_instance *k;
  lcp_result res = {0};
  check_ok(lcp_instance_open(&k, s, &cap, opt, &err), &err);
  check_ok(lcp_instance_prepare(k, p, &err), &err);
  const long heap_before = check_heap_calls;
  check_ok(lcp_instance_solve(k, trace, z, &res, &err), &err);
  if (!s->allocates) {
    assert_int_equal(check_heap_calls, heap_before);
  }
  lcp_instance_close(k);
  return res;
}

static lcp_problem dense(int n, const double *M, const double *q) {
  return (lcp_problem){.M = {.storage = LCP_DENSE, .n = n, .val = M}, .q = q};
}

/* ---- theory -------------------------------------------------------------------------------- */

/* Tower of n equal masses: the sweep contracts by cos^2(pi / (2 n)) (Jacobi's spectral radius of
 * tridiag(-1, 2, -1) with a free end, squared). Measured between residuals far in the tail. */
static void pgs_contracts_on_a_tower_as_theory_says(void **state) {
  (void)state;
  enum { N = 10, LEN = 500 };
  double M[N * N] = {0}, q[N] = {-9.81}, z[N] = {0}, residual[LEN];
  long iteration[LEN];
  for (int i = 0; i < N; i++) {
    M[i * N + i] = (i == 0) ? 1.0 : 2.0;
    if (i > 0) {
      M[i * N + i - 1] = M[(i - 1) * N + i] = -1.0;
    }
  }
  const lcp_problem p = dense(N, M, q);
  lcp_trace trace = {.cap = LEN, .iteration = iteration, .residual = residual};
  const lcp_result r = run("pgs", "tol=1e-9,max_iter=2000,check_every=1", &p, z, &trace);
  assert_int_equal(r.outcome, LCP_SOLVED);
  const double pi = 3.14159265358979323846, half = cos(pi / (2 * N));
  const double rate = pow(residual[400] / residual[300], 0.01);
  check_close(rate, half * half, 1e-5); /* the second mode is 0.79^100 smaller there */
}

/* A heavy body (ratio R) on a light one: R / (1 + R), exactly, from the second sweep on. */
static void pgs_contracts_by_the_mass_ratio(void **state) {
  (void)state;
  const double ratio = 37.0, M[4] = {1.0, -1.0, -1.0, 1.0 + 1.0 / ratio}, q[2] = {-9.81, 0.0};
  double z[2] = {0}, before[2];
  const lcp_problem p = dense(2, M, q);
  (void)run("pgs", "tol=0,max_iter=50", &p, z, NULL);
  memcpy(before, z, sizeof z);
  memset(z, 0, sizeof z);
  (void)run("pgs", "tol=0,max_iter=51", &p, z, NULL);
  const double top = 9.81 * ratio, base = top + 9.81; /* z = (base, top) */
  check_close((top - z[1]) / (top - before[1]), ratio / (1.0 + ratio), 1e-12);
  check_close((base - z[0]) / (base - before[0]), ratio / (1.0 + ratio), 1e-12);
}

/* A P-matrix (MATHEMATICS F5) and a rotation: exact cycles, which must be found out and never claimed. From z = 0 the rotation goes
 * z2 = 4, z1 = 3 z2 - 2 = 10, z2 = 0, z1 = 0, z2 = 4: a period of two sweeps. Brent's method compares with the
 * iterate of the tests 1, 2, 4, ..: tested after every sweep it meets sweep 1 again in sweep 3; tested after
 * sweeps 0, 10, 20 it meets sweep 10 in sweep 20. */
static void pgs_says_stalled_where_it_cycles(void **state) {
  (void)state;
  const double A[9] = {1, 0, 2, 2, 1, 0, 0, 2, 1}, a[3] = {-1, -1, -1};
  const double B[4] = {1, 3, -3, 1}, b[2] = {2, -4};
  double z[3] = {0};
  const lcp_problem kostreva = dense(3, A, a), rotation = dense(2, B, b);
  assert_string_equal(lcp_outcome_name(run("pgs", "", &kostreva, z, NULL).outcome), "stalled");
  memset(z, 0, sizeof z);
  const lcp_result seldom = run("pgs", "", &rotation, z, NULL);
  assert_string_equal(lcp_outcome_name(seldom.outcome), "stalled");
  assert_int_equal(seldom.work.iterations, 20);
  memset(z, 0, sizeof z);
  const lcp_result often = run("pgs", "check_every=1", &rotation, z, NULL);
  assert_string_equal(lcp_outcome_name(often.outcome), "stalled");
  assert_int_equal(often.work.iterations, 3);
}

static void infeasible_problems_are_never_claimed(void **state) {
  (void)state;
  const char *names[] = {
      "pgs",    "projected_gradient", "jacobi", "apgd", "nncg",    "nsgs", "prox", "newton",
      "pgs_sm", "interior_point",     "sqp",    "admm", "cone_ipm"};
  /* Two closing walls, and walls that close by a hair, whose iterates can run away along the null space. */
  const double M[4] = {1, -1, -1, 1}, q[2][2] = {{-1, -1}, {-1, 0.9999990463256836}};
  for (int c = 0; c < 2; c++) {
    const lcp_problem p = dense(2, M, q[c]);
    for (int i = 0; i < BASE_COUNT(names); i++) {
      double z[2] = {0};
      const lcp_result r = run(names[i], "max_iter=3000", &p, z, NULL);
      if (r.outcome == LCP_SOLVED || r.outcome == LCP_INFEASIBLE) {
        fail_msg("%s claims %s on q=(-1, %g)", names[i], lcp_outcome_name(r.outcome), q[c][1]);
      }
    }
  }
}

static void zero_diagonals_are_refused_without_blocks(void **state) {
  (void)state;
  const char *names[] = {"pgs", "nncg", "pgs_sm", "jacobi", "nsgs", "prox"};
  const double M[4] = {0, 1, 1, 0}, q[2] = {-1, -1};
  const lcp_problem p = dense(2, M, q);
  for (int i = 0; i < BASE_COUNT(names); i++) {
    _Alignas(16) unsigned char opt[OPT_MAX] = {0};
    const lcp_solver *s = solver(names[i], "", opt);
    const lcp_capacity cap = lcp_problem_capacity(&p);
    base_error err = {0};
    lcp_instance *k;
    check_ok(lcp_instance_open(&k, s, &cap, opt, &err), &err);
    assert_int_equal(lcp_instance_prepare(k, &p, &err), BASE_EUNSUPPORTED);
    assert_non_null(strstr(err.text, "diagonal"));
    lcp_instance_close(k);
  }
}

/* A block that sticks on a plane, as one block of the problem: zero diagonal in sigma's row, one sweep is exact. */
static void pgs_solves_a_contact_block_in_one_sweep(void **state) {
  (void)state;
  const double M[16] = {0.5, 0, 0, 0.5, 0, 0.5, -0.5, -1, 0, -0.5, 0.5, -1, 0, 1, 1, 0};
  const double q[4] = {-0.15625, 0.03125, -0.03125, 0};
  const lcp_block block = {.start = 0, .size = 4, .set = LCP_ORTHANT};
  lcp_problem p = dense(4, M, q);
  p.block = &block;
  p.n_block = 1;
  double z[4] = {0};
  const lcp_result r = run("pgs", "check_every=1", &p, z, NULL);
  assert_int_equal(r.outcome, LCP_SOLVED);
  assert_string_equal(r.variant, "block");
  assert_int_equal(r.work.iterations, 1);
  check_close(z[0], 0.3125, 1e-15);
  check_close(z[1] - z[2], -0.0625, 1e-15);
}

/* ---- local problems ------------------------------------------------------------------------ */

static void random_spd(base_rng *r, int n, double *A) {
  double B[LCP_CONE_MAX * LCP_CONE_MAX];
  for (int i = 0; i < n * n; i++) {
    B[i] = base_rng_between(r, -1.0, 1.0);
  }
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++) {
      A[i + j * n] = (i == j) ? 0.05 : 0.0;
      for (int k = 0; k < n; k++) {
        A[i + j * n] += B[k + i * n] * B[k + j * n];
      }
    }
  }
}

/* Coulomb's law, part by part. */
static void check_law(const lcp_block *k, const double *A, const double *b, const double *r) {
  double w[LCP_CONE_MAX], size = 0.0;
  for (int i = 0; i < k->size; i++) {
    w[i] = b[i];
    size += fabs(b[i]);
    for (int j = 0; j < k->size; j++) {
      w[i] += A[i + j * k->size] * r[j];
      size += fabs(A[i + j * k->size] * r[j]);
    }
  }
  assert_true(r[0] >= 0.0 && w[0] >= -1e-13 * size);
  check_close(fmin(r[0], fabs(w[0])), 0.0, 1e-13 * size);
  for (int p = 0, at = 1; p < k->n_part; at += k->part_dim[p++]) {
    const int two = k->part_dim[p] == 2;
    const double rt = hypot(r[at], two ? r[at + 1] : 0.0), wt = hypot(w[at], two ? w[at + 1] : 0.0);
    const double bound = k->part_mu[p] * r[0];
    const double along = r[at] * w[at] + (two ? r[at + 1] * w[at + 1] : 0.0);
    assert_true(rt <= bound * (1.0 + 1e-12) + 1e-300);
    if (r[0] > 0.0 && rt < bound * (1.0 - 1e-9)) {
      check_close(wt, 0.0, 1e-11 * size);
    } else if (r[0] > 0.0) {
      check_close(along, -rt * wt, 1e-11 * size * (rt + 1e-3));
    }
  }
}

static void the_cone_block_obeys_coulomb(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(11);
  const lcp_block kinds[] = {
      {.size = 3, .set = LCP_CONE, .n_part = 1, .part_dim = {2}},
      {.size = 2, .set = LCP_CONE, .n_part = 1, .part_dim = {1}},
      {.size = 1, .set = LCP_CONE, .n_part = 0},
      {.size = 6, .set = LCP_CONE, .n_part = 3, .part_dim = {2, 1, 2}},
  };
  int modes[3] = {0}; /* open, stick, slip of the first kind */
  for (int c = 0; c < 4000; c++) {
    lcp_block k = kinds[c % 4];
    double A[LCP_CONE_MAX * LCP_CONE_MAX], b[LCP_CONE_MAX], x[LCP_CONE_MAX];
    for (int p = 0; p < k.n_part; p++) {
      k.part_mu[p] = (c % 28 == 0) ? 0.0 : base_rng_between(&r, 0.01, (p == 0) ? 1.0 : 0.2);
    }
    random_spd(&r, k.size, A);
    for (int i = 0; i < k.size; i++) {
      b[i] = base_rng_between(&r, -1.0, 0.5);
    }
    lcp_cone_solve(&k, A, b, x);
    check_law(&k, A, b, x);
    if (c % 4 == 0) {
      const double slack = k.part_mu[0] * x[0] - hypot(x[1], x[2]);
      modes[(x[0] == 0.0) ? 0 : ((slack > 1e-9 * x[0]) ? 1 : 2)]++;
    }
  }
  assert_true(modes[0] > 100 && modes[1] > 30 && modes[2] > 100);
}

/* Singular blocks, as joints make them, numbers at the ends of the range, parts without friction: what is said to be found is. */
static void newton_claims_no_block_that_it_has_not_found(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(13);
  const double far[2][3] = {{-2.8, 3.02, 0.0}, {-1.0, -1.0, 0.0}},
               v[2][2] = {{-1.0, 0.9}, {0.1, -0.13}};
  for (int c = 0; c < 2;
       c++) { /* along its null vector r has no end, and any w is rounding of A r */
    const lcp_block k = {
        .size = 3, .set = LCP_CONE, .n_part = 2, .part_dim = {1, 1}, .part_mu = {2.0, 0.1}};
    const double A[9] = {v[c][0] * v[c][0],
                         v[c][0] * v[c][1],
                         0.0,
                         v[c][0] * v[c][1],
                         v[c][1] * v[c][1],
                         0.0,
                         0.0,
                         0.0,
                         1.0};
    double x[3];
    assert_true(!lcp_cone_parts_newton(&k, A, far[c], x) || fabs(x[0]) < 1e6);
  }
  int found[4] = {0};
  for (int c = 0; c < 4000; c++) {
    lcp_block k = {.size = 6, .set = LCP_CONE, .n_part = 3, .part_dim = {2, 1, 2}};
    const int kind =
        c % 4; /* of rank 4; in other units; without friction in some part; an overflow */
    const double unit = (kind == 1) ? ldexp(1.0, (c % 8 < 4) ? 500 : -500) : 1.0;
    double A[LCP_CONE_MAX * LCP_CONE_MAX], b[LCP_CONE_MAX], x[LCP_CONE_MAX], J[6][4];
    random_spd(&r, k.size, A);
    for (int i = 0; i < 6 * 4; i++) {
      J[i / 4][i % 4] = base_rng_between(&r, -1.0, 1.0);
    }
    for (int i = 0; i < 6; i++) {
      for (int j = 0; j < 6 && kind == 0; j++) {
        A[i + j * 6] = 0.0;
        for (int l = 0; l < 4; l++) {
          A[i + j * 6] += J[i][l] * J[j][l];
        }
      }
      b[i] = base_rng_between(&r, -1.0, (i == 0) ? -0.01 : 1.0) * unit;
      b[i] = (kind == 3) ? ldexp(b[i], 1000) : b[i];
      for (int j = 0; j < 6; j++) {
        A[i + j * 6] *= (kind == 3) ? ldexp(1.0, -600) : unit;
      }
    }
    for (int p = 0; p < k.n_part; p++) {
      k.part_mu[p] = (kind == 2 && (c / 4) % 3 == p) ? 0.0 : base_rng_between(&r, 0.01, 3.0);
    }
    if (!lcp_cone_parts_newton(&k, A, b, x)) {
      continue;
    }
    found[kind]++;
    double data = 0.0, w[LCP_CONE_MAX];
    for (int i = 0; i < 6; i++) {
      assert_true(isfinite(x[i]));
      data = fmax(data, fabs(b[i]) / sqrt(A[i + i * 6]));
      w[i] = b[i];
      for (int j = 0; j < 6; j++) {
        w[i] += A[i + j * 6] * x[j];
      }
    }
    for (int p = 0, at = 1; p < k.n_part; at += k.part_dim[p++]) {
      const bool two = k.part_dim[p] == 2;
      const double size = two ? hypot(x[at], x[at + 1]) : fabs(x[at]), most = k.part_mu[p] * x[0];
      const double speed = two ? hypot(w[at], w[at + 1]) : fabs(w[at]);
      assert_true(size <= most * (1.0 + 1e-12));
      assert_true(size >= most * (1.0 - 1e-9) ||
                  speed <= 1e-9 * data * sqrt(A[at + at * 6]) * 10.0);
    }
    assert_true(fabs(w[0]) <= 1e-9 * data * sqrt(A[0]));
  }
  assert_true(found[0] > 0 && found[1] > 850 && found[2] > 850 && found[3] == 0);
}

/* What Newton's steps do not find brackets do, more slowly. */
static void brackets_find_the_same_blocks(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(14);
  for (int c = 0; c < 200; c++) {
    lcp_block k = {.size = 6, .set = LCP_CONE, .n_part = 3, .part_dim = {2, 1, 2}};
    double A[LCP_CONE_MAX * LCP_CONE_MAX], b[LCP_CONE_MAX], x[LCP_CONE_MAX] = {0};
    random_spd(&r, k.size, A);
    for (int i = 0; i < k.size; i++) {
      b[i] = base_rng_between(&r, -1.0, (i == 0) ? -0.01 : 0.5);
    }
    for (int p = 0; p < k.n_part; p++) {
      k.part_mu[p] = base_rng_between(&r, 0.01, (p == 0) ? 1.0 : 0.2);
    }
    lcp_cone_solve_by_brackets(&k, A, b, x);
    check_law(&k, A, b, x);
  }
}

/* Friction, torsion and rolling at one contact: Newton's steps come to rounding nearly always, also where the arms of the moments are a hundredth
 * of a length, and what they come to obeys the law. */
static void several_parts_are_found_by_newton(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(12);
  int found = 0, closed = 0, rest[3] = {0}, slip[3] = {0};
  for (int c = 0; c < 4000; c++) {
    lcp_block k = {.size = 6, .set = LCP_CONE, .n_part = 3, .part_dim = {2, 1, 2}};
    const double arm = (c % 2 == 0) ? 1.0 : 0.01; /* of the moments, in the unit of length */
    double A[LCP_CONE_MAX * LCP_CONE_MAX], b[LCP_CONE_MAX], x[LCP_CONE_MAX];
    random_spd(&r, k.size, A);
    for (int i = 0; i < k.size; i++) {
      b[i] = base_rng_between(&r, -1.0, (i == 0) ? -0.01 : 1.0) * ((i > 2) ? arm : 1.0);
      for (int j = 0; j < k.size; j++) {
        A[i + j * k.size] *= ((i > 2) ? arm : 1.0) * ((j > 2) ? arm : 1.0);
      }
    }
    for (int p = 0; p < k.n_part; p++) {
      k.part_mu[p] = base_rng_between(&r, 0.01, (p == 0) ? 1.0 : 0.5) / ((p == 0) ? 1.0 : arm);
    }
    closed++;
    if (!lcp_cone_parts_newton(&k, A, b, x)) {
      continue;
    }
    found++;
    check_law(&k, A, b, x);
    for (int p = 0, at = 1; p < k.n_part; at += k.part_dim[p++]) {
      const double size = (k.part_dim[p] == 2) ? hypot(x[at], x[at + 1]) : fabs(x[at]);
      (size < k.part_mu[p] * x[0] * (1.0 - 1e-9) ? rest : slip)[p]++;
    }
  }
  assert_true(found > 0.99 * closed);
  for (int p = 0; p < 3; p++) {
    assert_true(rest[p] > 100 && slip[p] > 100);
  }
}

static lemke_block block_open(int rows, void **memory) {
  lemke_block k;
  base_arena a = base_arena_measuring();
  lemke_block_layout(&k, rows, &a);
  *memory = base_alloc(a.used);
  assert_non_null(*memory);
  a = base_arena_over(*memory, a.used);
  lemke_block_layout(&k, rows, &a);
  return k;
}

/* Planted: z and w >= 0 with z'w = 0 chosen first, M positive definite, q = w - M z; then the same in other units. */
static void blocks_have_their_planted_solutions(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(5);
  void *memory = NULL;
  lemke_block k = block_open(LCP_CONE_MAX, &memory);
  for (int c = 0; c < 2000; c++) {
    const int n = 1 + c % LCP_CONE_MAX;
    const double unit = ldexp(1, (c % 3 - 1) * 60);
    double A[LCP_CONE_MAX * LCP_CONE_MAX], q[LCP_CONE_MAX], want[LCP_CONE_MAX], z[LCP_CONE_MAX];
    random_spd(&r, n, A);
    for (int i = 0; i < n; i++) {
      want[i] = fmax(0.0, base_rng_between(&r, -1.0, 1.0));
    }
    for (int i = 0; i < n; i++) {
      q[i] = (want[i] > 0.0) ? 0.0 : base_rng_between(&r, 0.0, 1.0);
      for (int j = 0; j < n; j++) {
        q[i] -= A[i + j * n] * want[j];
      }
    }
    for (int i = 0; i < n * n; i++) {
      A[i] *= unit;
    }
    assert_true(lemke_block_solve(&k, n, A, q, z));
    for (int i = 0; i < n; i++) {
      check_close(z[i] * unit, want[i], 1e-10); /* condition up to 1e3 or so */
    }
  }
  free(memory);
}

/* What stands in the basis of z is a solution; the planted one stays; of a neighbour with another basis nothing is said. */
static void a_block_stays_where_its_basis_holds(void **state) {
  (void)state;
  enum { M_MAX = LCP_CONE_MAX };
  base_rng r = base_rng_seeded(11);
  double A[M_MAX * M_MAX], inverse[M_MAX * M_MAX], q[M_MAX], want[M_MAX], x[M_MAX];
  int kept = 0, left = 0;
  for (int c = 0; c < 2000; c++) {
    const int n = 1 + c % M_MAX;
    lemke_kept k = {.support = 0};
    random_spd(&r, n, A);
    for (int i = 0; i < n; i++) {
      want[i] = fmax(0.0, base_rng_between(&r, -1.0, 1.0));
    }
    for (int pass = 0; pass < 3; pass++) { /* the planted q, then two moved from it */
      for (int i = 0; i < n; i++) {
        q[i] = (want[i] > 0.0) ? 0.0 : base_rng_between(&r, 0.0, 1.0);
        q[i] += (pass > 0) ? base_rng_between(&r, -0.3, 0.3) * want[i] : 0.0;
        for (int j = 0; j < n; j++) {
          q[i] -= A[i + j * n] * want[j];
        }
      }
      const bool stays = lemke_block_stays(&k, inverse, n, A, q, want, x);
      assert_true(stays || pass > 0);
      for (int i = 0; i < n && stays; i++) {
        double w = q[i];
        for (int j = 0; j < n; j++) {
          w += A[i + j * n] * x[j];
        }
        assert_true(x[i] >= 0.0 && w >= -1e-11);
        check_close(x[i] * w, 0.0, 1e-10);
        check_close((pass == 0) ? x[i] - want[i] : 0.0, 0.0, 1e-10);
      }
      kept += stays;
      left += !stays;
    }
  }
  assert_true(kept > 2500 && left > 100);
}

/* Two equal columns: no inverse, so nothing is said; nor where a resting row would have to move. */
static void a_singular_basis_does_not_stay(void **state) {
  (void)state;
  const double M[4] = {1, 1, 1, 1}, q[2] = {-1, -1}, z[2] = {0.5, 0.5}, rest[2] = {0};
  double inverse[4], x[2];
  lemke_kept k = {.support = 0};
  assert_false(lemke_block_stays(&k, inverse, 2, M, q, z, x));
  assert_false(lemke_block_stays(&k, inverse, 2, M, q, rest, x));
}

static void a_block_reports_a_ray(void **state) {
  (void)state;
  const double M[4] = {1, -1, -1, 1}, q[2] = {-1, -1};
  double z[2] = {2.385, 2.385};
  void *memory = NULL;
  lemke_block k = block_open(2, &memory);
  assert_false(lemke_block_solve(&k, 2, M, q, z));
  check_close(z[0], 2.385, 0.0);
  free(memory);
}

/* ---- the matrix-free sweep ------------------------------------------------------------------- */

typedef struct fixture {
  contact_bed bed;
  lcp_gs gs;
  lcp_contact_sweep fast;
  void *memory;
} fixture;

static void carve(fixture *f, base_arena *a) {
  const lcp_capacity cap = lcp_problem_capacity(&f->bed.p);
  lcp_gs_layout(&f->gs, &cap, a);
  lcp_contact_sweep_layout(&f->fast, &cap, a);
}

static void fixture_open(fixture *f, int contacts) {
  base_error err = {0};
  f->bed = contact_bed_open(contacts, 3);
  assert_non_null(f->bed.memory);
  check_ok(lcp_problem_check(&f->bed.p, &err), &err);
  base_arena a = base_arena_measuring();
  carve(f, &a);
  f->memory = base_alloc(a.used);
  assert_non_null(f->memory);
  a = base_arena_over(f->memory, a.used);
  carve(f, &a);
  check_ok(lcp_gs_prepare(&f->gs, &f->bed.p, &err), &err);
}

static void fixture_close(fixture *f) {
  contact_bed_close(&f->bed);
  free(f->memory);
}

/* Ten sweeps in batches against ten plain sweeps in the same order; at least so many lanes are busy. */
static void batches_equal_a_plain_sweep(int contacts, double least_busy) {
  fixture f;
  fixture_open(&f, contacts);
  assert_true(lcp_contact_sweep_prepare(&f.fast, &f.gs, &f.bed.p));
  assert_true(contacts >= least_busy * LCP_LANES * f.fast.in.n_batch);
  const size_t n = (size_t)f.bed.p.M.n;
  double *z = calloc(n, sizeof *z), *v = calloc(6 * ((size_t)f.bed.n_body + 1), sizeof *v);
  int *order = calloc((size_t)contacts, sizeof *order);
  plain_contact_rows *rows = calloc((size_t)contacts, sizeof *rows);
  assert_true(z != NULL && v != NULL && order != NULL && rows != NULL);
  for (int k = 0, met = 0; met < contacts; k++) {
    order[met] = f.fast.in.order[k];
    met += order[met] >= 0;
  }
  plain_rows_fill(&f.bed, order, rows);
  lcp_contact_sweep_import(&f.fast, &f.bed.p, z);
  lcp_contact_sweep_run(&f.fast, 1.0, 10);
  lcp_contact_sweep_export(&f.fast, &f.bed.p, z);
  double moved = 0.0;
  for (int k = 0; k < 10; k++) {
    plain_rows_sweep(rows, contacts, v);
  }
  for (int k = 0; k < contacts; k++) {
    for (int r = 0; r < 3; r++) {
      check_close(z[3 * order[k] + r], rows[k].z[r], 1e-12);
      moved += fabs(rows[k].z[r]);
    }
  }
  assert_true(moved > 0.1 * contacts);
  free(z);
  free(v);
  free(order);
  free(rows);
  fixture_close(&f);
}

/* Sweeps one behind the other, by crews of one to four. */
static void batches_sweep_the_same_by_any_crew(void **state) {
  (void)state;
  enum { CONTACTS = 3001 };
  static double kept[3 * CONTACTS], z[3 * CONTACTS];
  for (int threads = 1; threads <= 4; threads++) {
    base_error err = {0};
    base_crew *crew;
    fixture f;
    check_ok(base_crew_open(&crew, threads, &err), &err);
    (void)base_crew_take_up(crew);
    fixture_open(&f, CONTACTS);
    assert_true(lcp_contact_sweep_prepare(&f.fast, &f.gs, &f.bed.p));
    assert_int_equal(f.fast.in.shared, threads > 1);
    memset(z, 0, sizeof z);
    lcp_contact_sweep_import(&f.fast, &f.bed.p, z);
    lcp_contact_sweep_run(&f.fast, 0.9, 1);
    lcp_contact_sweep_run(&f.fast, 1.0, 50);
    lcp_contact_sweep_export(&f.fast, &f.bed.p, z);
    (void)base_crew_take_up(NULL);
    base_crew_close(crew);
    assert_true(threads == 1 || memcmp(kept, z, sizeof z) == 0);
    memcpy(kept, z, sizeof z);
    fixture_close(&f);
  }
}

/* Of many contacts nearly all come after those before them of their bodies, which keeps what a plain sweep converges with. */
static void batches_keep_the_order_given(void **state) {
  (void)state;
  fixture f;
  int late = 0;
  fixture_open(&f, 3001);
  assert_true(lcp_contact_sweep_prepare(&f.fast, &f.gs, &f.bed.p));
  int *last = calloc((size_t)f.bed.n_body, sizeof *last);
  assert_non_null(last);
  for (int k = 0; k < LCP_LANES * f.fast.in.n_batch; k++) {
    const int c = f.fast.in.order[k];
    bool in_turn = true;
    for (int side = 0; side < 2 && c >= 0; side++) {
      const int b = f.bed.p.M.factored->body[2 * (ptrdiff_t)c + side];
      if (b >= 0) {
        in_turn = in_turn && last[b] <= c;
        last[b] = (last[b] > c) ? last[b] : c;
      }
    }
    late += !in_turn;
  }
  assert_in_range(late, 0, 60);
  free(last);
  fixture_close(&f);
}

static void batches_sweep_as_a_plain_loop_does(void **state) {
  (void)state;
  batches_equal_a_plain_sweep(1, 0.0);
  batches_equal_a_plain_sweep(7, 0.25);
  batches_equal_a_plain_sweep(40, 0.8);
  batches_equal_a_plain_sweep(3001, 0.98);
}

/* The two plain sweeps of the fixture agree, so the baseline is no straw man with another answer. */
static void plain_sweeps_agree(void **state) {
  (void)state;
  enum { N = 200 };
  contact_bed bed = contact_bed_open(N, 3);
  assert_non_null(bed.memory);
  const size_t bodies = (size_t)bed.n_body + 1;
  plain_contact_rows *rows = calloc(N, sizeof *rows);
  plain_contact_frames *frames = calloc(N, sizeof *frames);
  plain_body *body = calloc(bodies, sizeof *body);
  double *v = calloc(6 * bodies, sizeof *v), *u = calloc(6 * bodies, sizeof *u);
  assert_true(rows != NULL && frames != NULL && body != NULL && v != NULL && u != NULL);
  plain_rows_fill(&bed, NULL, rows);
  plain_frames_fill(&bed, NULL, frames, body);
  for (int k = 0; k < 10; k++) {
    plain_rows_sweep(rows, N, v);
    plain_frames_sweep(frames, N, body, u);
  }
  for (int k = 0; k < N; k++) {
    for (int r = 0; r < 3; r++) {
      check_close(frames[k].z[r], rows[k].z[r], 1e-12);
    }
  }
  free(rows);
  free(frames);
  free(body);
  free(v);
  free(u);
  contact_bed_close(&bed);
}

static void pgs_on_the_factored_form_solves_the_bed(void **state) {
  (void)state;
  const char *names[] = {"pgs", "projected_gradient", "apgd", "nncg", "jacobi", "nsgs"};
  const char *variants[] = {"batches", "spg", "", "point", "", ""};
  contact_bed bed = contact_bed_open(300, 3);
  assert_non_null(bed.memory);
  double *z = calloc((size_t)bed.p.M.n, sizeof *z);
  assert_non_null(z);
  for (int i = 0; i < BASE_COUNT(names); i++) {
    memset(z, 0, (size_t)bed.p.M.n * sizeof *z);
    const lcp_result r = run(names[i], "tol=1e-8,check_every=10", &bed.p, z, NULL);
    lcp_verdict verdict;
    base_error err = {0};
    check_ok(lcp_judge(&bed.p, z, &verdict, &err), &err);
    assert_string_equal(lcp_outcome_name(r.outcome), "ok");
    assert_string_equal(r.variant != NULL ? r.variant : "", variants[i]);
    check_close(verdict.rho, 0.0, 1e-8);
  }
  free(z);
  contact_bed_close(&bed);
}

/* Asymmetric bounds, an angular row that belongs to no arm, coupled inertia: swept row by row. */
static void batches_refuse_other_forms(void **state) {
  (void)state;
  fixture f;
  fixture_open(&f, 40);
  double *weight = f.bed.memory, *jac = f.bed.memory + 36 * f.bed.n_body;
  assert_true(lcp_contact_sweep_prepare(&f.fast, &f.gs, &f.bed.p));
  f.gs.lo[1] = -0.1;
  assert_false(lcp_contact_sweep_prepare(&f.fast, &f.gs, &f.bed.p));
  f.gs.lo[1] = -f.gs.hi[1];
  jac[3] += 1e-10;
  assert_false(lcp_contact_sweep_prepare(&f.fast, &f.gs, &f.bed.p));
  jac[3] -= 1e-10;
  assert_true(lcp_contact_sweep_prepare(&f.fast, &f.gs, &f.bed.p));
  weight[3] = weight[18] = 1e-3;
  assert_false(lcp_contact_sweep_prepare(&f.fast, &f.gs, &f.bed.p));
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pgs_contracts_on_a_tower_as_theory_says),
      cmocka_unit_test(pgs_contracts_by_the_mass_ratio),
      cmocka_unit_test(pgs_says_stalled_where_it_cycles),
      cmocka_unit_test(infeasible_problems_are_never_claimed),
      cmocka_unit_test(zero_diagonals_are_refused_without_blocks),
      cmocka_unit_test(pgs_solves_a_contact_block_in_one_sweep),
      cmocka_unit_test(the_cone_block_obeys_coulomb),
      cmocka_unit_test(several_parts_are_found_by_newton),
      cmocka_unit_test(newton_claims_no_block_that_it_has_not_found),
      cmocka_unit_test(brackets_find_the_same_blocks),
      cmocka_unit_test(blocks_have_their_planted_solutions),
      cmocka_unit_test(a_block_stays_where_its_basis_holds),
      cmocka_unit_test(a_singular_basis_does_not_stay),
      cmocka_unit_test(a_block_reports_a_ray),
      cmocka_unit_test(batches_sweep_as_a_plain_loop_does),
      cmocka_unit_test(batches_sweep_the_same_by_any_crew),
      cmocka_unit_test(batches_keep_the_order_given),
      cmocka_unit_test(plain_sweeps_agree),
      cmocka_unit_test(pgs_on_the_factored_form_solves_the_bed),
      cmocka_unit_test(batches_refuse_other_forms),
  };
  return cmocka_run_group_tests_name("sweep", tests, NULL, NULL);
}
