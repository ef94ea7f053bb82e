/* Every registered solver against every golden problem it admits: what lcp_solver.h promises. A
 * new solver is covered without touching this file. */
#include "tests/support/check.h"

#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"
#include "tests/support/few_bodies.h"
#include "tests/support/golden.h"

#include <stdio.h>
#include <string.h>

enum { N_MAX = 128, OPT_MAX = 512, CASE_MAX = 4096 };

typedef struct pair {
  const lcp_solver *s;
  const golden *g;
  char name[128];
} pair;

/* One solve from z = 0 in an instance that stays open. */
typedef struct run {
  double z[N_MAX];
  lcp_result res;
} run;

/* From the z of *r. */
static void solve_from(lcp_instance *k, const lcp_solver *s, run *r) {
  base_error err = {0};
  const long heap_before = check_heap_calls;
  check_ok(lcp_instance_solve(k, NULL, r->z, &r->res, &err), &err);
  if (!s->allocates) {
    assert_int_equal(check_heap_calls, heap_before);
  }
}

static void solve_once(lcp_instance *k, const lcp_solver *s, run *r) {
  memset(r, 0, sizeof *r);
  solve_from(k, s, r);
}

/* y >= 0, M'y <= 0, q'y < 0; free rows: any sign, (M'y)_i = 0. */
static void check_farkas(const lcp_problem *p, const double *y) {
  const int n = p->M.n;
  static double dense[N_MAX * N_MAX];
  lcp_matrix_to_dense(&p->M, dense);
  long double gain = 0;
  for (int j = 0; j < n; j++) {
    long double column = 0;
    for (int i = 0; i < n; i++) {
      column += (long double)dense[j * n + i] * y[i];
    }
    assert_true(y[j] >= 0 && column <= 0);
    gain += (long double)p->q[j] * y[j];
  }
  assert_true(gain < 0);
}

static void check_claim(const pair *c, const run *r) {
  const lcp_problem *p = &c->g->p;
  base_error err = {0};
  lcp_verdict v;
  check_ok(lcp_judge(p, r->z, &v, &err), &err);
  const bool solvable = c->g->answer == KNOWN_UNIQUE || c->g->answer == KNOWN_SOLVABLE;
  const bool hopeless = c->g->answer == KNOWN_INFEASIBLE || c->g->answer == KNOWN_UNSOLVABLE;
  if (r->res.outcome == LCP_SOLVED) {
    assert_false(hopeless);
    check_close(v.rho, 0.0, c->s->exact ? LCP_VERIFY_EXACT : LCP_VERIFY_ITERATIVE);
  } else if (r->res.outcome == LCP_INFEASIBLE) {
    assert_false(solvable);
    assert_int_equal(c->g->answer, KNOWN_INFEASIBLE);
    assert_int_equal(r->res.certificate.kind, LCP_CERT_FARKAS);
    check_farkas(p, r->res.certificate.vector);
  }
  const bool definite = (p->traits & LCP_PD) != 0 && c->g->answer != KNOWN_UNSTATED;
  if (c->g->easy || (c->s->exact && definite)) {
    assert_string_equal(lcp_outcome_name(r->res.outcome), "ok");
  }
  double top = 0;
  for (int i = 0; c->g->z != NULL && i < p->M.n; i++) {
    top = fmax(top, fabs(c->g->z[i]));
  }
  for (int i = 0; c->s->exact && c->g->answer == KNOWN_UNIQUE && c->g->z != NULL &&
                  r->res.outcome == LCP_SOLVED && i < p->M.n;
       i++) {
    check_close(r->z[i], c->g->z[i], 1e-8 * top); /* rho 1e-10 times a condition below 100 */
  }
}

/* A solver that takes a start point stays at its own answer; a direct method also finds its way from
 * a support that is wrong, and does not pivot more from the answer than from nothing. */
static void check_warm(lcp_instance *k, const pair *c, const run *cold) {
  const lcp_problem *p = &c->g->p;
  base_error err = {0};
  lcp_verdict v;
  if (!c->s->warm || c->s->peer || cold->res.outcome != LCP_SOLVED) {
    return;
  }
  const double tol = c->s->exact ? LCP_VERIFY_EXACT : LCP_VERIFY_ITERATIVE;
  const bool definite = (p->traits & LCP_PD) != 0;
  static run r;
  for (int wrong = 0; wrong < (c->s->exact && definite ? 2 : 1); wrong++) {
    r = *cold;
    for (int i = 0; i < p->M.n && wrong; i++) {
      r.z[i] = (i % 3 == 0) ? 0 : 1;
    }
    solve_from(k, c->s, &r);
    assert_string_equal(lcp_outcome_name(r.res.outcome), "ok");
    check_ok(lcp_judge(p, r.z, &v, &err), &err);
    check_close(v.rho, 0.0, tol);
    assert_true(wrong || !c->s->exact || r.res.work.pivots <= cold->res.work.pivots);
  }
}

static void keeps_its_promises(void **state) {
  const pair *c = *state;
  const lcp_problem *p = &c->g->p;
  assert_true(p->M.n <= N_MAX && c->s->options_size <= OPT_MAX);
  base_error err = {0};
  _Alignas(16) unsigned char opt[OPT_MAX] = {0};
  _Alignas(16) unsigned char opt_before[OPT_MAX];
  base_fields_default(c->s->fields, c->s->n_fields, opt);
  if (base_fields_set(c->s->fields, c->s->n_fields, opt, "max_iter", "20000", &err) != BASE_OK) {
    fail_msg("%s", err.text);
  }
  memcpy(opt_before, opt, sizeof opt);
  double q[N_MAX];
  memcpy(q, p->q, (size_t)p->M.n * sizeof *q);

  lcp_instance *k;
  const lcp_capacity cap = lcp_problem_capacity(p);
  check_ok(lcp_instance_open(&k, c->s, &cap, opt, &err), &err);
  const base_status prepared = lcp_instance_prepare(k, p, &err);
  if (prepared == BASE_EUNSUPPORTED) { /* looked at the numbers and refused: must say why */
    assert_true(strlen(err.text) > 10);
    lcp_instance_close(k);
    return;
  }
  check_ok(prepared, &err);
  static run first;
  static run again;
  solve_once(k, c->s, &first);
  if (!c->s->peer) { /* what a peer claims is a measurement, not a promise */
    check_claim(c, &first);
  }
  solve_once(k, c->s, &again);
  assert_memory_equal(first.z, again.z, sizeof first.z);
  assert_int_equal(first.res.outcome, again.res.outcome);
  assert_memory_equal(&first.res.work, &again.res.work, sizeof first.res.work);
  check_warm(k, c, &first);
  assert_memory_equal(opt, opt_before, sizeof opt);
  assert_memory_equal(p->q, q, (size_t)p->M.n * sizeof *q);
  lcp_instance_close(k);
}

/* A solver that meets a problem with sets or traits it does not declare is refused by name. */
static void refuses_by_name(void **state) {
  (void)state;
  int ns;
  int ng;
  const lcp_solver *const *s = lcp_solvers(&ns);
  const golden *g = goldens(&ng);
  for (int i = 0; i < ns; i++) {
    for (int j = 0; j < ng; j++) {
      base_error err = {0};
      if (lcp_solver_admits(s[i], &g[j].p, &err) != BASE_OK) {
        assert_int_equal(err.code, BASE_EUNSUPPORTED);
        assert_non_null(strstr(err.text, s[i]->name));
      }
    }
  }
}

/* Opening fails cleanly when any of its allocations does. */
static void open_survives_every_failed_allocation(void **state) {
  (void)state;
  int ns;
  int ng;
  const lcp_solver *const *s = lcp_solvers(&ns);
  const golden *g = goldens(&ng);
  const lcp_capacity cap = lcp_problem_capacity(&g[1].p);
  for (int i = 0; i < ns; i++) {
    _Alignas(16) unsigned char opt[OPT_MAX] = {0};
    base_fields_default(s[i]->fields, s[i]->n_fields, opt);
    for (long k = 1;; k++) {
      base_error err = {0};
      lcp_instance *inst;
      check_heap_fail_at = k;
      const base_status status = lcp_instance_open(&inst, s[i], &cap, opt, &err);
      const bool reached = check_heap_fail_at == 0;
      check_heap_fail_at = 0;
      if (!reached) { /* fewer than k allocations: all of them have been failed in turn */
        check_ok(status, &err);
        lcp_instance_close(inst);
        break;
      }
      assert_int_equal(status, BASE_ENOMEM);
      assert_null(inst);
    }
  }
}

/* Prepare and solve with the k-th allocation failing, for every k: ENOMEM or no need of it, and the
 * instance can be used again afterwards. Opened for `small`, so that it has to grow. */
static void fail_in_turn(const lcp_solver *s, const lcp_problem *p, const lcp_capacity *small) {
  _Alignas(16) unsigned char opt[OPT_MAX] = {0};
  base_fields_default(s->fields, s->n_fields, opt);
  for (long k = 1, reached = 1; reached; k++) {
    base_error err = {0};
    lcp_instance *inst;
    double z[N_MAX] = {0};
    lcp_result res;
    check_ok(lcp_instance_open(&inst, s, small, opt, &err), &err);
    check_heap_fail_at = k;
    base_status status = lcp_instance_prepare(inst, p, &err);
    status = (status == BASE_OK) ? lcp_instance_solve(inst, NULL, z, &res, &err) : status;
    reached = check_heap_fail_at == 0;
    check_heap_fail_at = 0;
    if (status == BASE_EUNSUPPORTED) { /* by the numbers: nothing to solve */
      lcp_instance_close(inst);
      return;
    }
    assert_int_equal(status, reached ? BASE_ENOMEM : BASE_OK);
    check_ok(lcp_instance_prepare(inst, p, &err), &err);
    check_ok(lcp_instance_solve(inst, NULL, z, &res, &err), &err);
    lcp_instance_close(inst);
  }
}

/* Dense, sparse and factored: conversions between them allocate too. */
static void prepare_and_solve_survive_every_failed_allocation(void **state) {
  (void)state;
  int ns;
  int ng;
  const lcp_solver *const *s = lcp_solvers(&ns);
  const golden *g = goldens(&ng);
  base_error err = {0};
  lcp_csc csc;
  known_lcp bodies;
  check_ok(lcp_matrix_to_csc(&g[1].p.M, &csc, &err), &err);
  check_ok(few_bodies(&bodies, 1, 4, 0, 3, &err), &err);
  lcp_problem sparse = g[1].p;
  sparse.M = (lcp_matrix){.storage = LCP_CSC, .n = csc.n_row, .csc = csc};
  bodies.p.traits = LCP_SYMMETRIC | LCP_PSD | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  const lcp_problem *p[] = {&g[1].p, &sparse, &bodies.p};
  const lcp_capacity small = lcp_problem_capacity(&g[0].p);
  for (int i = 0; i < ns * BASE_COUNT(p); i++) {
    if (!s[i % ns]->peer && lcp_solver_admits(s[i % ns], p[i / ns], NULL) == BASE_OK) {
      fail_in_turn(s[i % ns], p[i / ns], &small);
    }
  }
  lcp_csc_free(&csc);
  known_lcp_free(&bodies);
}

/* A workspace opened for less grows when a larger problem is bound, and solve before prepare is an
 * error, not a crash. */
static void grows_and_refuses_misuse(void **state) {
  (void)state;
  int ns;
  int ng;
  const lcp_solver *const *s = lcp_solvers(&ns);
  const golden *g = goldens(&ng);
  for (int i = 0; i < ns; i++) {
    if (lcp_solver_admits(s[i], &g[1].p, NULL) != BASE_OK) {
      continue;
    }
    _Alignas(16) unsigned char opt[OPT_MAX] = {0};
    base_fields_default(s[i]->fields, s[i]->n_fields, opt);
    base_error err = {0};
    lcp_instance *k;
    const lcp_capacity cap = lcp_problem_capacity(&g[0].p);
    check_ok(lcp_instance_open(&k, s[i], &cap, opt, &err), &err);
    double z[N_MAX] = {0};
    lcp_result res;
    assert_int_equal(lcp_instance_solve(k, NULL, z, &res, &err), BASE_EINVAL);
    check_ok(lcp_instance_prepare(k, &g[1].p, &err), &err);
    check_ok(lcp_instance_solve(k, NULL, z, &res, &err), &err);
    check_close(z[1], g[1].z[1], 1e-4);
    assert_true(lcp_instance_bytes(k) > 0);
    lcp_instance_close(k);
  }
}

/* Rows with q = 0 that nothing else moves: their answer is zero, and what only comes nearer to zero never is small against the rows'
 * own terms. From zero, and from a start that is not. */
static void ends_where_q_is_zero(void **state) {
  (void)state;
  static const double M[] = {2, 0, 0, 0, 2, 1, 0, 1, 2}, q[] = {-1, 0, 0};
  static const double lo[] = {0, -1, -1}, hi[] = {HUGE_VAL, 1, 1};
  static const lcp_block boxes[] = {{.start = 0, .size = 1, .set = LCP_ORTHANT},
                                    {.start = 1, .size = 2, .set = LCP_BOX}};
  const lcp_problem all[] = {
      {.M = {.storage = LCP_DENSE, .n = 3, .val = M}, .q = q, .traits = LCP_SYMMETRIC | LCP_PD},
      {.M = {.storage = LCP_DENSE, .n = 3, .val = M},
       .q = q,
       .lo = lo,
       .hi = hi,
       .block = boxes,
       .n_block = 2,
       .traits = LCP_SYMMETRIC | LCP_PD}};
  int ns;
  const lcp_solver *const *s = lcp_solvers(&ns);
  for (int i = 0; i < ns; i++) {
    for (int j = 0; j < BASE_COUNT(all); j++) {
      base_error err = {0};
      if (s[i]->peer || lcp_solver_admits(s[i], &all[j], NULL) != BASE_OK) {
        continue;
      }
      _Alignas(16) unsigned char opt[OPT_MAX] = {0};
      base_fields_default(s[i]->fields, s[i]->n_fields, opt);
      const lcp_capacity cap = lcp_problem_capacity(&all[j]);
      lcp_instance *k;
      check_ok(lcp_instance_open(&k, s[i], &cap, opt, &err), &err);
      check_ok(lcp_instance_prepare(k, &all[j], &err), &err);
      const bool rough = strcmp(s[i]->name, "sqp") ==
                         0; /* ends where its objective is within rounding: at the root of that */
      for (int warm = 0; warm <= (s[i]->warm && !rough ? 1 : 0); warm++) {
        run r = {.z = {0.4 * warm, 0.3 * warm, 0.2 * warm}};
        lcp_verdict v;
        solve_from(k, s[i], &r);
        if (r.res.outcome != LCP_SOLVED) {
          fail_msg("%s, problem %d, %s: %s after %ld", s[i]->name, j, warm ? "warm" : "cold",
                   lcp_outcome_name(r.res.outcome), r.res.work.iterations);
        }
        check_ok(lcp_judge(&all[j], r.z, &v, &err), &err);
        check_close(v.rho, 0.0, s[i]->exact ? LCP_VERIFY_EXACT : LCP_VERIFY_ITERATIVE);
        check_close(r.z[0], 0.5, 1e-6);
        check_close(r.z[1], 0.0, 1e-12);
      }
      lcp_instance_close(k);
    }
  }
}

static void says_what_it_is(void **state) {
  (void)state;
  int n;
  const lcp_solver *const *s = lcp_solvers(&n);
  for (int i = 0; i < n; i++) {
    check_sentence(s[i]->name, s[i]->words, NULL);
    check_sentence(s[i]->name, s[i]->when, NULL);
    for (int j = 0; j < i; j++) {
      check_sentence(s[i]->name, s[i]->words, s[j]->words);
    }
  }
}

/* usage: test_solvers [STRIDE]: every solver on every STRIDE-th problem, a different share for each. */
int main(int argc, char **argv) {
  int stride = 1;
  if (argc > 1 && (!base_parse_int(argv[1], &stride) || stride < 1)) {
    (void)fprintf(stderr, "test_solvers: STRIDE %s: need a whole number from 1 on\n", argv[1]);
    return 2;
  }
  static pair pairs[CASE_MAX];
  static struct CMUnitTest tests[CASE_MAX + 6]; /* unused entries are skipped by cmocka */
  int ns;
  int ng;
  int nt = 0;
  const lcp_solver *const *s = lcp_solvers(&ns);
  const golden *g = goldens(&ng);
  for (int i = 0; i < ns; i++) {
    for (int j = 0; j < ng && nt < CASE_MAX; j++) {
      if (i % stride == j % stride && lcp_solver_admits(s[i], &g[j].p, NULL) == BASE_OK) {
        pair *c = &pairs[nt];
        c->s = s[i];
        c->g = &g[j];
        (void)snprintf(c->name, sizeof c->name, "%s on %s", s[i]->name, g[j].name);
        tests[nt++] = (struct CMUnitTest){c->name, keeps_its_promises, NULL, NULL, c};
      }
    }
  }
  tests[nt++] = (struct CMUnitTest)cmocka_unit_test(refuses_by_name);
  tests[nt++] = (struct CMUnitTest)cmocka_unit_test(open_survives_every_failed_allocation);
  tests[nt++] =
      (struct CMUnitTest)cmocka_unit_test(prepare_and_solve_survive_every_failed_allocation);
  tests[nt++] = (struct CMUnitTest)cmocka_unit_test(grows_and_refuses_misuse);
  tests[nt++] = (struct CMUnitTest)cmocka_unit_test(ends_where_q_is_zero);
  tests[nt++] = (struct CMUnitTest)cmocka_unit_test(says_what_it_is);
  return cmocka_run_group_tests_name("solvers", tests, NULL, NULL);
}
