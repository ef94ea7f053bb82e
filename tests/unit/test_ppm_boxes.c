/* ppm on redundant impulses between two bounds: of many answers it takes the one that its start is at, or near. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"

#include <string.h>

enum { DOF = 6, CONTACTS = 16, N = 2 * CONTACTS, OPT_MAX = 512, SEEDS = 40 };

/* A normal and a friction row of each contact of one body, M = J J', and an answer z with w = 0 of which all but DOF of the
 * rows are a matter of choice. */
typedef struct redundant {
  double M[N * N], q[N], lo[N], hi[N], z[N];
  lcp_block block[2 * CONTACTS];
  lcp_problem p;
} redundant;

static void move(const redundant *b, const double *z, double *w) {
  for (int i = 0; i < N; i++) {
    w[i] = 0;
    for (int j = 0; j < N; j++) {
      w[i] += b->M[j * N + i] * z[j];
    }
  }
}

static void fill(redundant *b, uint64_t seed) {
  base_rng rng = base_rng_seeded(seed);
  double J[N][DOF];
  for (int i = 0; i < N; i++) {
    const int contact = i / 2;
    const bool normal = i % 2 == 0;
    for (int k = 0; k < DOF; k++) {
      J[i][k] = base_rng_between(&rng, -1, 1);
    }
    b->z[i] = normal ? base_rng_between(&rng, 0.5, 1.5) : base_rng_between(&rng, -0.2, 0.2);
    b->lo[i] = normal ? 0 : -0.25;
    b->hi[i] = normal ? HUGE_VAL : 0.25;
    b->block[i] = (lcp_block){
        .start = 2 * contact + !normal, .size = 1, .set = normal ? LCP_ORTHANT : LCP_BOX};
  }
  for (int i = 0; i < N; i++) {
    for (int j = 0; j < N; j++) {
      double sum = 0;
      for (int k = 0; k < DOF; k++) {
        sum += J[i][k] * J[j][k];
      }
      b->M[j * N + i] = sum;
    }
  }
  move(b, b->z, b->q);
  for (int i = 0; i < N; i++) {
    b->q[i] = -b->q[i];
  }
  b->p = (lcp_problem){.M = {.storage = LCP_DENSE, .n = N, .val = b->M},
                       .q = b->q,
                       .lo = b->lo,
                       .hi = b->hi,
                       .block = b->block,
                       .n_block = N,
                       .traits = LCP_SYMMETRIC | LCP_PSD};
}

static void solve(const lcp_problem *p, double *z, lcp_result *res) {
  const lcp_solver *s = lcp_solver_find("ppm");
  const lcp_capacity cap = lcp_problem_capacity(p);
  _Alignas(16) unsigned char opt[OPT_MAX] = {0};
  base_error err = {0};
  lcp_instance *k;
  lcp_verdict v;
  base_fields_default(s->fields, s->n_fields, opt);
  check_ok(lcp_instance_open(&k, s, &cap, opt, &err), &err);
  check_ok(lcp_instance_prepare(k, p, &err), &err);
  check_ok(lcp_instance_solve(k, NULL, z, res, &err), &err);
  assert_int_equal(res->outcome, LCP_SOLVED);
  check_ok(lcp_judge(p, z, &v, &err), &err);
  check_close(v.rho, 0, 1e-10);
  lcp_instance_close(k);
}

/* All of the problem's data is that of the last step: nothing is to be done. */
static void an_answer_comes_back_to_the_bit(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    redundant b;
    double z[N];
    lcp_result res;
    fill(&b, seed);
    memcpy(z, b.z, sizeof z);
    solve(&b.p, z, &res);
    assert_memory_equal(z, b.z, sizeof z);
    assert_int_equal(res.work.pivots, 0);
  }
}

/* Loads that change by a millionth change impulses by as much, times what the rows of F are conditioned by; rows that go to
 * their bounds change by a quarter. */
static void a_small_change_moves_little(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    redundant b;
    double z[N], push[N], by[N];
    lcp_result res;
    fill(&b, seed);
    base_rng rng = base_rng_seeded(seed + 1000);
    for (int i = 0; i < N; i++) {
      push[i] = base_rng_between(&rng, -1e-6, 1e-6);
    }
    move(&b, push, by);
    for (int i = 0; i < N; i++) {
      b.q[i] += by[i];
    }
    memcpy(z, b.z, sizeof z);
    solve(&b.p, z, &res);
    for (int i = 0; i < N; i++) {
      check_close(z[i], b.z[i], 1e-3);
    }
  }
}

/* From zero friction is at zero, and what needs none ends without: rows whose w is zero all along take no part. */
static void what_needs_no_friction_has_none(void **state) {
  (void)state;
  redundant b;
  double z[N] = {0};
  lcp_result res;
  fill(&b, 7);
  for (int i = 0; i < N; i++) { /* friction acts on a body of its own that nothing moves */
    for (int j = 0; j < N; j++) {
      b.M[j * N + i] = (i % 2 == j % 2) ? b.M[j * N + i] : 0;
    }
    b.z[i] = (i % 2 == 0) ? b.z[i] : 0;
  }
  move(&b, b.z, b.q);
  for (int i = 0; i < N; i++) {
    b.q[i] = -b.q[i];
  }
  solve(&b.p, z, &res);
  for (int i = 1; i < N; i += 2) {
    assert_true(z[i] == 0);
  }
}

/* Impulses of a jam grow from step to step: what redundant rows keep of them would drown the answer. */
static void a_far_start_is_given_up(void **state) {
  (void)state;
  int from_zero = 0;
  for (uint64_t seed = 1; seed <= SEEDS; seed++) {
    redundant b;
    double z[N];
    lcp_result res;
    fill(&b, seed);
    for (int i = 0; i < N; i++) {
      z[i] = (i % 2 == 0) ? 1e12 * b.z[i] : b.z[i];
    }
    solve(&b.p, z, &res);
    for (int i = 0; i < N && res.work.fallbacks > 0; i++) {
      assert_true(fabs(z[i]) < 1e3);
    }
    from_zero += res.work.fallbacks > 0;
  }
  assert_true(from_zero > 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_answer_comes_back_to_the_bit),
      cmocka_unit_test(a_small_change_moves_little),
      cmocka_unit_test(what_needs_no_friction_has_none),
      cmocka_unit_test(a_far_start_is_given_up),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
