#include "tests/support/check.h"

#include "tests/support/solve.h"

enum { OPT_MAX = 512 };

base_status try_solve(const char *solver, const char *options, const lcp_problem *p, double *z,
                      lcp_result *res, base_error *err) {
  _Alignas(16) unsigned char opt[OPT_MAX] = {0};
  const lcp_solver *s = lcp_solver_find(solver);
  const lcp_capacity cap = lcp_problem_capacity(p);
  lcp_instance *k;
  assert_true(s != NULL && s->options_size <= OPT_MAX);
  base_fields_default(s->fields, s->n_fields, opt);
  check_ok(base_fields_parse(s->fields, s->n_fields, opt, options, err), err);
  check_ok(lcp_instance_open(&k, s, &cap, opt, err), err);
  const base_status ready = lcp_instance_prepare(k, p, err);
  if (ready == BASE_OK) {
    const long before = check_heap_calls;
    check_ok(lcp_instance_solve(k, NULL, z, res, err), err);
    assert_true(s->allocates || check_heap_calls == before);
  }
  lcp_instance_close(k);
  return ready;
}

lcp_result solve_by(const char *solver, const char *options, const lcp_problem *p, double *z) {
  base_error err = {0};
  lcp_result res = {.outcome = LCP_NUMERICAL};
  check_ok(try_solve(solver, options, p, z, &res, &err), &err);
  return res;
}

lcp_verdict verdict_on(const lcp_problem *p, const double *z) {
  base_error err = {0};
  lcp_verdict v;
  check_ok(lcp_judge(p, z, &v, &err), &err);
  return v;
}
