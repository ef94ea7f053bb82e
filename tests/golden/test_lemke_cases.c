/* lemke, and on symmetric contact LCPs ppm and block_pivoting, on tests/cases and tests/data: the cases
 * with known answers, 25 contact LCPs without one, and the LCPs of another code. Everything is judged by lcp_judge, never by the solver's word. */
#include "tests/support/check.h"

#include "lcp/io/lcp_read.h"
#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"
#include "problems/read/case_file.h"
#include "tests/support/files.h"

#include <stdio.h>
#include <string.h>

static lcp_result run(const char *solver, const lcp_problem *p, double *z, lcp_verdict *v) {
  const lcp_solver *s = lcp_solver_find(solver);
  unsigned char opt[512];
  base_error err = {0};
  lcp_instance *k = NULL;
  lcp_result res;
  const lcp_capacity cap = lcp_problem_capacity(p);
  assert_true(s->options_size <= sizeof opt);
  base_fields_default(s->fields, s->n_fields, opt);
  check_ok(lcp_instance_open(&k, s, &cap, opt, &err), &err);
  check_ok(lcp_instance_prepare(k, p, &err), &err);
  check_ok(lcp_instance_solve(k, NULL, z, &res, &err), &err);
  check_ok(lcp_judge(p, z, v, &err), &err);
  lcp_instance_close(k);
  res.certificate = (lcp_certificate){.kind = res.certificate.kind}; /* its arrays are gone */
  return res;
}

static unsigned status_bit(lcp_outcome o) {
  switch (o) {
  case LCP_SOLVED:
    return CASE_SOLVED;
  case LCP_INFEASIBLE:
    return CASE_INFEASIBLE;
  case LCP_RAY:
    return CASE_UNSOLVED_RAY;
  case LCP_NUMERICAL:
    return CASE_NUMERICAL_FAILURE;
  default:
    return CASE_NOT_CONVERGED;
  }
}

static double forward_error(const lcp_case *c, const double *z) {
  double top = 0;
  double gap = 0;
  for (int i = 0; i < c->n; ++i) {
    top = fmax(top, fabs(c->solution[i]));
    gap = fmax(gap, fabs(c->solution[i] - z[i]));
  }
  return (top > 0) ? gap / top : gap;
}

/* True when the case came out right. */
static bool check_case(const lcp_case *c) {
  double *z = calloc((size_t)c->n + 1, sizeof *z);
  lcp_verdict v;
  assert_non_null(z);
  const lcp_result res = run("lemke", &c->k.p, z, &v);
  const unsigned bit = status_bit(res.outcome);
  bool right = (bit & (c->correct | c->honest_failure)) != 0 && (bit & c->false_claim) == 0;
  if (res.outcome == LCP_SOLVED) {
    right = right && v.rho <= LCP_VERIFY_EXACT && res.certificate.kind == LCP_CERT_BASIS;
  }
  if (res.outcome == LCP_SOLVED && c->forward_tol > 0) {
    right = right && forward_error(c, z) <= c->forward_tol;
  }
  if (c->lemke_pivots > 0) {
    right = right && res.work.pivots == c->lemke_pivots;
  }
  if (!right) {
    print_error("%s: %s, rho %.2g, %ld pivots\n", c->id, lcp_outcome_name(res.outcome), v.rho,
                res.work.pivots);
  }
  free(z);
  return right;
}

static void every_case_comes_out_right(void **state) {
  (void)state;
  base_error err = {0};
  case_file f;
  check_ok(case_file_read(tests_file("cases/cases.json"), &f, &err), &err);
  int wrong = 0;
  int solved = 0;
  for (int i = 0; i < f.n_lcp; ++i) {
    const lcp_case *c = &f.lcp[i];
    if (c->shape_error[0] == '\0' && lcp_problem_check(&c->k.p, NULL) == BASE_OK) {
      wrong += !check_case(c);
      ++solved;
    }
  }
  case_file_free(&f);
  assert_int_equal(wrong, 0);
  assert_true(solved >= 80);
}

static const char *const contact[] = {
    "boxstack_n12", "boxstack_n32", "boxstack_n100", "boxstack_n300", "boxstack_n1000",
    "column_n10",   "column_n30",   "column_n100",   "column_n300",   "column_n1000",
    "fbox4_p4",     "fbox4_p20",    "fbox4_p80",     "fbox4_p200",    "fbox8_p4",
    "fbox8_p20",    "frand4_p5",    "frand4_p20",    "frand4_p80",    "frand8_p5",
    "frand8_p20",   "pd_n10",       "pd_n30",        "pd_n100",       "pd_n300"};

static void check_contact(const char *solver, const char *name, const lcp_problem *p) {
  lcp_verdict v;
  double top = 0;
  double *z = calloc((size_t)p->M.n, sizeof *z);
  for (int k = 0; k < p->M.n; ++k) {
    top = fmax(top, fabs(p->q[k]));
  }
  const lcp_result res = run(solver, p, z, &v);
  if (res.outcome != LCP_SOLVED || !(v.min_map <= 1e-10 * (1 + top)) || !(v.rho <= 1e-9)) {
    fail_msg("%s on %s: %s, min map %.2g, rho %.2g", solver, name, lcp_outcome_name(res.outcome),
             v.min_map, v.rho);
  }
  assert_true(res.work.fallbacks == 0 || strcmp(solver, "lemke") != 0);
  free(z);
}

/* lemke on all of them, the symmetric methods where M is symmetric; the boxstacks are singular. */
static int check_contact_file(const char *name, const char *m_path, const char *q_path) {
  base_error err = {0};
  lcp_file_problem f;
  check_ok(lcp_read_mtx(m_path, q_path, &f, &err), &err);
  const bool symmetric = lcp_matrix_is_symmetric(&f.p.M);
  check_contact("lemke", name, &f.p);
  if (symmetric) {
    check_contact("ppm", name, &f.p);
    check_contact("block_pivoting", name, &f.p);
  }
  lcp_file_problem_free(&f);
  return symmetric;
}

static void contact_lcps_are_solved(void **state) {
  (void)state;
  int symmetric = 0;
  for (int i = 0; i < BASE_COUNT(contact); ++i) {
    char M[128];
    char q[128];
    (void)snprintf(M, sizeof M, "cases/contact_lcps/%s.M.mtx", contact[i]);
    (void)snprintf(q, sizeof q, "cases/contact_lcps/%s.q.mtx", contact[i]);
    symmetric += check_contact_file(contact[i], tests_file(M), tests_file(q));
  }
  assert_int_equal(symmetric, 14); /* boxstack, column, pd */
}

static const char *const files[] = {"lcp_CPS_1",     "lcp_CPS_2",
                                    "lcp_CPS_3",     "lcp_Pang_isolated_sol",
                                    "lcp_exp_murty", "lcp_inf_sol_perturbed",
                                    "lcp_mmc",       "lcp_ortiz",
                                    "lcp_tobenna",   "lcp_trivial"};

static void check_file(const char *name, const char *path) {
  base_error err = {0};
  lcp_file_problem f;
  lcp_verdict v;
  check_ok(lcp_read_siconos(path, &f, &err), &err);
  double *z = calloc((size_t)f.p.M.n, sizeof *z);
  const lcp_result res = run("lemke", &f.p, z, &v);
  if (res.outcome != LCP_SOLVED || !(v.rho <= 1e-9)) {
    fail_msg("%s: %s, rho %.2g", name, lcp_outcome_name(res.outcome), v.rho);
  }
  free(z);
  lcp_file_problem_free(&f);
}

static void files_of_another_code_are_solved(void **state) {
  (void)state;
  for (int i = 0; i < BASE_COUNT(files); ++i) {
    char name[128];
    (void)snprintf(name, sizeof name, "data/lcp/%s.dat", files[i]);
    check_file(files[i], tests_file(name));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_case_comes_out_right),
      cmocka_unit_test(contact_lcps_are_solved),
      cmocka_unit_test(files_of_another_code_are_solved),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
