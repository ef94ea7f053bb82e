/* lemke on problems whose rows and columns are in units of their own, by powers of two up to 2^40, which changes no digit, and
 * of ten up to 10^12, which rounds: copositive, positive semidefinite and P-matrices, and contacts with friction. Every answer
 * is checked in rational arithmetic. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/io/lcp_read.h"
#include "lcp/lcp_certificate.h"
#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"
#include "problems/families/family.h"
#include "tests/support/files.h"

#include <stdio.h>
#include <string.h>

enum { ROWS = 64 };

static double unit(base_rng *random, int base, int most) {
  const int e = (int)lround(base_rng_between(random, -most, most));
  return (base == 2) ? ldexp(1, e) : pow(10, e);
}

/* M <- R M C, q <- R q with random R and C. The arrays are the problem's own. */
static void scale(lcp_problem *p, base_rng *random, int base) {
  const int n = p->M.n;
  const int most = (base == 2) ? 40 : 12;
  double row[ROWS];
  for (int i = 0; i < n; ++i) {
    row[i] = unit(random, base, most);
    ((double *)(uintptr_t)p->q)[i] *= row[i];
  }
  for (int j = 0; j < n; ++j) {
    const double column = unit(random, base, most);
    const bool dense = p->M.storage == LCP_DENSE;
    const int first = dense ? j * n : p->M.csc.colptr[j];
    const int end = dense ? first + n : p->M.csc.colptr[j + 1];
    double *val = (double *)(uintptr_t)(dense ? p->M.val : p->M.csc.val);
    for (int k = first; k < end; ++k) {
      val[k] *= row[dense ? k - first : p->M.csc.rowind[k]] * column;
    }
  }
  p->traits = 0;
}

/* Solved, and the basis holds; exactly, unless M is singular and its data rounded. */
static void check_solved(const char *name, const lcp_problem *p, bool singular) {
  const lcp_solver *s = lcp_solver_find("lemke");
  _Alignas(16) unsigned char opt[512];
  base_error err = {0};
  lcp_instance *k = NULL;
  lcp_result res;
  lcp_verdict v;
  lcp_certificate_verdict proof;
  double z[ROWS] = {0};
  const lcp_capacity cap = lcp_problem_capacity(p);
  assert_true(p->M.n <= ROWS && s->options_size <= sizeof opt);
  base_fields_default(s->fields, s->n_fields, opt);
  check_ok(lcp_instance_open(&k, s, &cap, opt, &err), &err);
  check_ok(lcp_instance_prepare(k, p, &err), &err);
  check_ok(lcp_instance_solve(k, NULL, z, &res, &err), &err);
  check_ok(lcp_judge(p, z, &v, &err), &err);
  if (res.outcome != LCP_SOLVED || !(v.rho <= 1e-14)) {
    fail_msg("%s: %s, rho %.2g", name, lcp_outcome_name(res.outcome), v.rho);
  }
  check_ok(lcp_certificate_verify(p, &res.certificate, z, &proof, &err), &err);
  if (!proof.holds || (!proof.exact && !singular)) {
    fail_msg("%s: %s", name, proof.why);
  }
  lcp_instance_close(k);
}

static void units_do_not_matter(void **state) {
  (void)state;
  static const struct {
    const char *name;
    bool singular;
  } family[] = {{"random_copositive:density=0.3,", false},
                {"random_copositive:density=0.8,", false},
                {"random_psd:repeat=2,", true},
                {"random_psd:repeat=4,", true},
                {"random_spd:", false},
                {"random_p:", false}};
  base_rng random = base_rng_seeded(11);
  for (int trial = 0; trial < 600; ++trial) {
    const int f = trial / 2 % BASE_COUNT(family);
    char name[96];
    known_lcp k;
    base_error err = {0};
    (void)snprintf(name, sizeof name, "%sn=%d,seed=%d", family[f].name, 2 + trial % 23, trial);
    check_ok(lcp_family_load(name, &k, &err), &err);
    scale(&k.p, &random, (trial % 2 == 0) ? 2 : 10);
    check_solved(name, &k.p, family[f].singular);
    known_lcp_free(&k);
  }
}

static void nor_those_of_contacts(void **state) {
  (void)state;
  static const char *const file[] = {"boxstack_n12", "boxstack_n32", "column_n10", "column_n30",
                                     "fbox4_p4",     "fbox8_p4",     "frand4_p5",  "frand8_p5"};
  base_rng random = base_rng_seeded(13);
  for (int trial = 0; trial < 10 * BASE_COUNT(file); ++trial) {
    const char *name = file[trial % BASE_COUNT(file)];
    char m_name[96];
    char q_name[96];
    lcp_file_problem f;
    base_error err = {0};
    (void)snprintf(m_name, sizeof m_name, "cases/contact_lcps/%s.M.mtx", name);
    (void)snprintf(q_name, sizeof q_name, "cases/contact_lcps/%s.q.mtx", name);
    check_ok(lcp_read_mtx(tests_file(m_name), tests_file(q_name), &f, &err), &err);
    scale(&f.p, &random, 2);
    check_solved(name, &f.p, true);
    lcp_file_problem_free(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(units_do_not_matter),
      cmocka_unit_test(nor_those_of_contacts),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
