/* ppm on small problems: the pivots on the tableau give verified answers with the w of lemke, whatever the units and the rank,
 * and leave to the factored path what a table cannot decide. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "tests/support/solve.h"

#include <string.h>

enum { N_MAX = 64, PROBLEMS = 600 };

typedef struct drawn {
  double M[N_MAX * N_MAX], q[N_MAX], unit[N_MAX];
  lcp_problem p;
} drawn;

/* M = D A A' D of random rank, rows copied exactly or to 1e-12, D powers of two up to 2^+-20; q of a degenerate answer, so that
 * many rows have z = w = 0. */
static void draw(uint64_t seed, drawn *d) {
  static double A[N_MAX * N_MAX];
  base_rng g = base_rng_seeded(seed);
  const int n = 1 + (int)(base_rng_uniform(&g) * N_MAX);
  const int rank = 1 + (int)(base_rng_uniform(&g) * n);
  const double apart = (seed % 3 == 0) ? 1e-12 : 0;
  const int reach = (seed % 2 == 0) ? 20 : 0;
  for (int i = 0; i < n; i++) {
    d->unit[i] = ldexp(1, (int)base_rng_between(&g, -reach, reach));
    for (int k = 0; k < rank; k++) {
      const bool copy = i > 0 && i % 4 == 3;
      A[i * rank + k] =
          copy ? A[(i - 1) * rank + k] + apart * base_rng_normal(&g) : base_rng_normal(&g);
    }
  }
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      double sum = 0;
      for (int k = 0; k < rank; k++) {
        sum += A[i * rank + k] * A[j * rank + k];
      }
      d->M[j * n + i] = d->unit[i] * sum * d->unit[j];
    }
  }
  memset(d->q, 0, sizeof d->q);
  for (int j = 0; j < n; j++) {
    const double z = base_rng_uniform(&g) < 0.5 ? 0 : base_rng_uniform(&g) / d->unit[j];
    for (int i = 0; i < n; i++) {
      d->q[i] -= d->M[j * n + i] * z;
    }
    d->q[j] += (z == 0 && base_rng_uniform(&g) < 0.7) ? base_rng_uniform(&g) * d->unit[j] : 0;
  }
  d->p = (lcp_problem){.M = {.storage = LCP_DENSE, .n = n, .val = d->M}, .q = d->q};
}

static void solve(const char *name, const lcp_problem *p, double *z, lcp_result *res,
                  lcp_verdict *v) {
  *res = solve_by(name, "", p, z);
  *v = verdict_on(p, z);
}

/* Largest row of M (x - y) against the size of its terms: w is unique. */
static double apart(const lcp_problem *p, const double *x, const double *y) {
  const int n = p->M.n;
  double worst = 0;
  for (int i = 0; i < n; i++) {
    double gap = 0, size = fabs(p->q[i]);
    for (int j = 0; j < n; j++) {
      gap += p->M.val[j * n + i] * (x[j] - y[j]);
      size += fabs(p->M.val[j * n + i]) * (fabs(x[j]) + fabs(y[j]));
    }
    worst = fmax(worst, (size > 0) ? fabs(gap) / size : 0);
  }
  return worst;
}

static bool is_zero(const double *z, int n) {
  bool zero = true;
  for (int i = 0; i < n; i++) {
    zero = zero && z[i] == 0;
  }
  return zero;
}

static void answers_are_right_in_any_unit(void **state) {
  (void)state;
  static drawn d;
  int by_table = 0;
  for (uint64_t seed = 1; seed <= PROBLEMS; seed++) {
    double z[N_MAX] = {0};
    double other[N_MAX] = {0};
    lcp_result res;
    lcp_verdict v;
    draw(seed, &d);
    solve("ppm", &d.p, z, &res, &v);
    assert_int_equal(res.outcome, LCP_SOLVED);
    check_close(v.rho, 0, 1e-13);
    assert_true(res.residual >= v.rho - 1e-16); /* a bound */
    const bool table = strcmp(res.variant, "table") == 0;
    assert_int_equal(res.work.fallbacks, !table);
    assert_int_equal(res.certificate.kind, LCP_CERT_BASIS);
    by_table += table;
    solve("lemke", &d.p, other, &res, &v);
    if (res.outcome == LCP_SOLVED) {
      check_close(apart(&d.p, z, other), 0, 1e-10);
    }
    const bool rests = is_zero(z, d.p.M.n);
    solve("ppm", &d.p, z, &res, &v); /* z holds the answer: not cold unless it is zero */
    assert_int_equal(res.outcome, LCP_SOLVED);
    assert_true(rests || strcmp(res.variant, "table") != 0);
  }
  print_message("# %d of %d on the table\n", by_table, (int)PROBLEMS);
  assert_true(by_table >= PROBLEMS * 9 / 10);
}

/* [1 -1; -1 1] with q = (-1, -1): no feasible point. The table gives up, the factored path proves it. */
static void no_answer_is_invented(void **state) {
  (void)state;
  static const double M[] = {1, -1, -1, 1};
  static const double q[] = {-1, -1};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = M}, .q = q};
  double z[2] = {0};
  lcp_result res;
  lcp_verdict v;
  solve("ppm", &p, z, &res, &v);
  assert_int_equal(res.outcome, LCP_INFEASIBLE);
  assert_int_equal(res.work.fallbacks, 1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(answers_are_right_in_any_unit),
      cmocka_unit_test(no_answer_is_invented),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
