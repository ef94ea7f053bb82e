/* Properties of every solver on random well-conditioned problems with a planted solution: it is
 * found; renaming the unknowns renames the answer; positive scalings of M and q scale it. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"

#include <stdio.h>
#include <string.h>

enum { N = 13, SEEDS = 6, OPT_MAX = 512, SOLVERS_MAX = 64 };

typedef struct planted {
  double M[N * N], q[N], z[N];
} planted;

/* M = B B'/N + I (condition below 10), about half of z positive, w of the size of z. */
static void plant(planted *c, uint64_t seed) {
  base_rng r = base_rng_seeded(seed);
  double B[N * N];
  double w[N];
  for (int k = 0; k < N * N; k++) {
    B[k] = base_rng_normal(&r);
  }
  for (int i = 0; i < N; i++) {
    for (int j = 0; j < N; j++) {
      double sum = (i == j) ? 1 : 0;
      for (int k = 0; k < N; k++) {
        sum +=
            B[(i < j ? i : j) * N + k] * B[(i < j ? j : i) * N + k] / N; /* same bits both ways */
      }
      c->M[j * N + i] = sum;
    }
    const double size = base_rng_between(&r, 0.5, 2.0);
    const bool active = base_rng_uniform(&r) < 0.5;
    c->z[i] = active ? size : 0;
    w[i] = active ? 0 : size;
  }
  for (int i = 0; i < N; i++) {
    c->q[i] = w[i];
    for (int j = 0; j < N; j++) {
      c->q[i] -= c->M[j * N + i] * c->z[j];
    }
  }
}

static void permute(const planted *c, const int *to, planted *out) {
  for (int i = 0; i < N; i++) {
    out->q[to[i]] = c->q[i];
    out->z[to[i]] = c->z[i];
    for (int j = 0; j < N; j++) {
      out->M[to[j] * N + to[i]] = c->M[j * N + i];
    }
  }
}

/* D M D, a D q: z becomes a D^-1 z. Powers of two, so nothing is rounded. */
static void rescale(const planted *c, const double *d, double a, planted *out) {
  for (int i = 0; i < N; i++) {
    out->q[i] = a * d[i] * c->q[i];
    out->z[i] = a * c->z[i] / d[i];
    for (int j = 0; j < N; j++) {
      out->M[j * N + i] = d[i] * c->M[j * N + i] * d[j];
    }
  }
}

static void check_solver(const lcp_solver *s, const planted *c, const char *what, uint64_t seed) {
  const lcp_problem p = {
      .M = {.storage = LCP_DENSE, .n = N, .val = c->M},
      .q = c->q,
      .traits =
          LCP_SYMMETRIC | LCP_PSD | LCP_PD | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS | LCP_P_MATRIX,
  };
  const lcp_capacity cap = lcp_problem_capacity(&p);
  _Alignas(16) unsigned char opt[OPT_MAX] = {0};
  base_error err = {0};
  base_fields_default(s->fields, s->n_fields, opt);
  lcp_instance *k;
  double z[N] = {0};
  lcp_result res;
  lcp_verdict v;
  check_ok(lcp_instance_open(&k, s, &cap, opt, &err), &err);
  check_ok(lcp_instance_prepare(k, &p, &err), &err);
  check_ok(lcp_instance_solve(k, NULL, z, &res, &err), &err);
  lcp_instance_close(k);
  check_ok(lcp_judge(&p, z, &v, &err), &err);
  const double tol = s->exact ? LCP_VERIFY_EXACT : LCP_VERIFY_ITERATIVE;
  if (res.outcome != LCP_SOLVED || !(v.rho <= tol)) {
    fail_msg("%s, %s, seed %d: %s with rho %g", s->name, what, (int)seed,
             lcp_outcome_name(res.outcome), v.rho);
  }
  /* error <= condition times residual, both relative to the size of the terms: 1e3 covers 10 N */
  for (int i = 0; i < N; i++) {
    const double size = sqrt(1 / c->M[i * N + i]);
    double top = 0;
    for (int j = 0; j < N; j++) {
      top = fmax(top, fabs(c->z[j]) * sqrt(c->M[j * N + j]));
    }
    if (!(fabs(z[i] - c->z[i]) <= 1e3 * tol * top * size)) {
      fail_msg("%s, %s, seed %d: z[%d] = %.17g, planted %.17g", s->name, what, (int)seed, i, z[i],
               c->z[i]);
    }
  }
}

static void holds_its_answer(void **state) {
  const lcp_solver *s = *state;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    planted c;
    planted other;
    int to[N];
    double d[N];
    base_rng r = base_rng_seeded(1000 + seed);
    plant(&c, seed);
    check_solver(s, &c, "as planted", seed);
    for (int i = 0; i < N; i++) {
      to[i] = i;
      d[i] = ldexp(1, (int)base_rng_between(&r, -20, 20));
    }
    for (int i = N - 1; i > 0; i--) {
      const int j = (int)(base_rng_bits(&r) % (uint64_t)(i + 1));
      const int t = to[i];
      to[i] = to[j];
      to[j] = t;
    }
    permute(&c, to, &other);
    check_solver(s, &other, "renamed", seed);
    rescale(&c, d, 1, &other);
    check_solver(s, &other, "D M D", seed);
    for (int i = 0; i < N; i++) {
      d[i] = 1;
    }
    rescale(&c, d, 0x1p-60, &other);
    check_solver(s, &other, "q / 2^60", seed);
    rescale(&c, d, 0x1p60, &other);
    check_solver(s, &other, "2^60 q", seed);
  }
}

int main(void) {
  static struct CMUnitTest tests[SOLVERS_MAX]; /* unused entries are skipped by cmocka */
  static union {                               /* cmocka takes the state without const */
    const lcp_solver *solver;
    void *state;
  } slot[SOLVERS_MAX];
  int ns;
  const lcp_solver *const *s = lcp_solvers(&ns);
  for (int i = 0, used = 0; i < ns && used < SOLVERS_MAX; i++) {
    if (!s[i]->peer && (s[i]->sets & (1u << LCP_ORTHANT)) != 0) {
      slot[used].solver = s[i];
      tests[used] = (struct CMUnitTest){s[i]->name, holds_its_answer, NULL, NULL, slot[used].state};
      used++;
    }
  }
  return cmocka_run_group_tests_name("properties", tests, NULL, NULL);
}
