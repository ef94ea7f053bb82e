/* Proofs that a factored problem has no feasible point: exact, and in one pass over J. */
#include "tests/support/check.h"

#include "lcp/base/clock.h"
#include "lcp/lcp_farkas.h"

#include <stdlib.h>
#include <string.h>

/* Bodies of one velocity, each between two walls that approach: z >= 0, w = J u + q, q = -1. */
typedef struct squeezed {
  int *dof_start, *weight_start, *row_start, *jac_start, *body;
  double *weight, *jac, *q, *y;
  lcp_farkas_sum *force;
  lcp_factored f;
  lcp_matrix M;
} squeezed;

static void squeeze(squeezed *s, int bodies) {
  const size_t n = 2 * (size_t)bodies;
  *s = (squeezed){.dof_start = calloc(n + 1, sizeof(int)),
                  .weight_start = calloc(n + 1, sizeof(int)),
                  .row_start = calloc(n + 1, sizeof(int)),
                  .jac_start = calloc(n + 1, sizeof(int)),
                  .body = calloc(2 * n, sizeof(int)),
                  .weight = calloc(n, sizeof(double)),
                  .jac = calloc(n, sizeof(double)),
                  .q = calloc(n, sizeof(double)),
                  .y = calloc(n, sizeof(double)),
                  .force = calloc(n, sizeof(lcp_farkas_sum))};
  for (int b = 0; b <= bodies; ++b) {
    s->dof_start[b] = s->weight_start[b] = b;
    s->weight[b] = 1;
  }
  for (int i = 0; i < (int)n; ++i) {
    s->row_start[i + 1] = s->jac_start[i + 1] = i + 1;
    s->body[2 * i] = i / 2;
    s->body[2 * i + 1] = -1;
    s->jac[i] = (i % 2) ? -1 : 1;
    s->q[i] = -1;
  }
  s->f = (lcp_factored){.n_body = bodies,
                        .dof_start = s->dof_start,
                        .weight_start = s->weight_start,
                        .weight = s->weight,
                        .n_group = (int)n,
                        .row_start = s->row_start,
                        .body = s->body,
                        .jac_start = s->jac_start,
                        .jac = s->jac};
  s->M = (lcp_matrix){.storage = LCP_FACTORED, .n = (int)n, .factored = &s->f};
}

static void let_go(squeezed *s) {
  free(s->dof_start);
  free(s->weight_start);
  free(s->row_start);
  free(s->jac_start);
  free(s->body);
  free(s->weight);
  free(s->jac);
  free(s->q);
  free(s->y);
  free(s->force);
}

static bool proves(squeezed *s, int first, double second) {
  for (int i = 0; i < s->M.n; ++i) {
    s->y[i] = 0;
  }
  s->y[first] = 1;
  s->y[first + 1] = second;
  return lcp_farkas_prove(&s->M, s->q, NULL, s->force, s->y);
}

/* Wherever the body stands that is squeezed; not when it would be moved, by one unit in the last place. */
static void any_body_counts(void **state) {
  (void)state;
  squeezed s;
  squeeze(&s, 100);
  for (int b = 0; b < 100; ++b) {
    assert_true(proves(&s, 2 * b, 1));
    assert_false(proves(&s, 2 * b, 0.5));
    assert_false(proves(&s, 2 * b, 0));
    s.jac[2 * b] = 1 + 0x1p-52;
    assert_false(proves(&s, 2 * b, 1));
    s.jac[2 * b] = 1;
  }
  let_go(&s);
}

static double seconds_of(int bodies) {
  squeezed s;
  double best = HUGE_VAL;
  squeeze(&s, bodies);
  for (int k = 0; k < 5; ++k) {
    const double started = base_cpu_seconds();
    assert_true(proves(&s, 2 * bodies - 2, 1));
    best = fmin(best, base_cpu_seconds() - started);
  }
  let_go(&s);
  return best;
}

/* Sixteen times the bodies take sixteen times as long, not 256 times: half way between, in the exponent. */
static void time_goes_with_the_bodies(void **state) {
  (void)state;
  const double small = seconds_of(1000);
  const double large = seconds_of(16000);
  if (large > 64 * small) {
    fail_msg("1000 bodies %g s, 16000 bodies %g s", small, large);
  }
}

/* test_farkas clock: what depends on the clock, which tests/cli/quiet.py runs. */
int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(any_body_counts),
  };
  const struct CMUnitTest clocked[] = {
      cmocka_unit_test(time_goes_with_the_bodies),
  };
  if (argc == 2 && strcmp(argv[1], "clock") == 0) {
    return cmocka_run_group_tests(clocked, NULL, NULL);
  }
  return cmocka_run_group_tests(tests, NULL, NULL);
}
