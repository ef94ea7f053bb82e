/* lemke on the factored form J W J' + S: against the formed matrix, sliding and sifted first bases. */
#include "tests/support/check.h"

#include "lcp/lcp_certificate.h"
#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"
#include "tests/support/few_bodies.h"
#include "tests/support/tableau_lemke.h"

#include <string.h>

static lcp_result run_few(const lcp_problem *p, const char *options, double *z, lcp_verdict *v) {
  const lcp_solver *solver = lcp_solver_find("lemke");
  const lcp_capacity cap = lcp_problem_capacity(p);
  unsigned char opt[512];
  lcp_instance *k = NULL;
  base_error err = {0};
  lcp_result res;
  base_fields_default(solver->fields, solver->n_fields, opt);
  check_ok(base_fields_parse(solver->fields, solver->n_fields, opt, options, &err), &err);
  check_ok(lcp_instance_open(&k, solver, &cap, opt, &err), &err);
  check_ok(lcp_instance_prepare(k, p, &err), &err);
  assert_int_equal(lcp_instance_storage(k), LCP_FACTORED);
  const long before = check_heap_calls;
  check_ok(lcp_instance_solve(k, NULL, z, &res, &err), &err);
  assert_int_equal(check_heap_calls, before);
  check_ok(lcp_judge(p, z, v, &err), &err);
  lcp_instance_close(k);
  return res;
}

/* max |M (z - other)| with M formed and `other` from the plain tableau. */
static double velocity_gap(const lcp_problem *p, const double *z) {
  const int n = p->M.n;
  double *dense = calloc((size_t)n * (size_t)n, sizeof *dense);
  double *work = calloc(tableau_lemke_work(n), sizeof *work);
  double *other = calloc((size_t)n, sizeof *other);
  long pivots = 0;
  double top = 0;
  lcp_matrix_to_dense(&p->M, dense);
  assert_int_equal(tableau_lemke(n, dense, p->q, other, work, &pivots), LCP_SOLVED);
  for (int r = 0; r < n; ++r) {
    double gap = 0;
    for (int c = 0; c < n; ++c) {
      gap += dense[(ptrdiff_t)c * n + r] * (z[c] - other[c]);
    }
    top = fmax(top, fabs(gap));
  }
  free(dense);
  free(work);
  free(other);
  return top;
}

static void check_few(int bodies, int contacts, int facets) {
  known_lcp k;
  base_error err = {0};
  lcp_verdict v;
  check_ok(few_bodies(&k, bodies, contacts, facets, 3, &err), &err);
  double *z = calloc((size_t)k.p.M.n, sizeof *z);
  const lcp_result res = run_few(&k.p, "", z, &v);
  assert_int_equal(res.outcome, LCP_SOLVED);
  assert_true(v.rho <= 1e-12);
  assert_true(v.rho <= res.residual + 1e-16); /* the bound is a bound */
  if (facets == 0) {                          /* M is PSD: w is unique */
    check_close(velocity_gap(&k.p, z), 0, 1e-11);
  }
  free(z);
  known_lcp_free(&k);
}

/* Few bodies, many contacts: what the factored form gives is right for the formed matrix. */
static void factored_form_agrees_with_dense(void **state) {
  (void)state;
  check_few(1, 40, 0);
  check_few(1, 20, 4);
  check_few(5, 60, 0);
  check_few(6, 15, 4);
  check_few(3, 9, 6);
}

/* Few contacts that slide: the sliding start gets there in fewer pivots. */
static void sliding_start_saves_pivots(void **state) {
  (void)state;
  known_lcp k;
  base_error err = {0};
  lcp_verdict v;
  double z[60] = {0};
  double slid[60] = {0};
  check_ok(few_bodies(&k, 10, 10, 4, 3, &err), &err);
  assert_int_equal(k.p.M.n, BASE_COUNT(z));
  const lcp_result cold = run_few(&k.p, "", z, &v);
  assert_int_equal(cold.outcome, LCP_SOLVED);
  const lcp_result start = run_few(&k.p, "start=sliding", slid, &v);
  assert_int_equal(start.outcome, LCP_SOLVED);
  assert_true(v.rho <= 1e-12);
  assert_true(start.work.pivots < cold.work.pivots);
  known_lcp_free(&k);
}

/* One body: a basic solution has at most as many normal impulses as the body has velocities, so the
 * pivots of a sifted path do not grow with the contacts; from the origin each contact costs one. */
static void sifting_takes_pivots_by_bodies(void **state) {
  (void)state;
  for (int contacts = 50; contacts <= 200; contacts *= 2) {
    known_lcp k;
    base_error err = {0};
    lcp_verdict v;
    check_ok(few_bodies(&k, 1, contacts, 4, 7, &err), &err);
    double *z = calloc((size_t)k.p.M.n, sizeof *z);
    const lcp_result sifted = run_few(&k.p, "", z, &v);
    assert_int_equal(sifted.outcome, LCP_SOLVED);
    assert_string_equal(sifted.variant, "sifted_basis");
    assert_int_equal(sifted.work.fallbacks, 0);
    assert_true(sifted.work.pivots <= 36); /* 6 rows for each of 6 contacts */
    assert_true(v.rho <= 1e-12);
    const lcp_result again = run_few(&k.p, "", z, &v); /* z holds the solution */
    assert_int_equal(again.work.pivots, 0);
    assert_true(v.rho <= 1e-12);
    if (contacts == 50) {
      memset(z, 0, sizeof *z * (size_t)k.p.M.n);
      const lcp_result origin = run_few(&k.p, "start=origin", z, &v);
      assert_int_equal(origin.outcome, LCP_SOLVED);
      assert_true(origin.work.pivots > contacts);
    }
    free(z);
    known_lcp_free(&k);
  }
}

/* Several bodies, with friction: paths from advanced bases end on rays here and begin again. */
static void sifting_solves_grasps(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    known_lcp k;
    base_error err = {0};
    lcp_verdict v;
    check_ok(few_bodies(&k, 4, 100, (seed % 2) ? 4 : 6, seed, &err), &err);
    double *z = calloc((size_t)k.p.M.n, sizeof *z);
    const lcp_result res = run_few(&k.p, "", z, &v);
    assert_int_equal(res.outcome, LCP_SOLVED);
    assert_string_equal(res.variant, "sifted_basis");
    assert_true(v.rho <= 1e-12);
    free(z);
    known_lcp_free(&k);
  }
}

/* Bilateral rows are in the set from the beginning. */
static void sifting_keeps_joints(void **state) {
  (void)state;
  enum { CONTACTS = 60, JOINTS = 3 };
  known_lcp k;
  base_error err = {0};
  lcp_verdict v;
  double z[CONTACTS] = {0};
  check_ok(few_bodies(&k, 2, CONTACTS, 0, 5, &err), &err);
  const lcp_block block[2] = {{.start = 0, .size = JOINTS, .set = LCP_FREE},
                              {.start = JOINTS, .size = CONTACTS - JOINTS, .set = LCP_ORTHANT}};
  lcp_problem p = k.p;
  p.block = block;
  p.n_block = 2;
  const lcp_result res = run_few(&p, "", z, &v);
  assert_int_equal(res.outcome, LCP_SOLVED);
  assert_string_equal(res.variant, "sifted_basis");
  assert_true(v.rho <= 1e-12);
  bool pulls = false;
  for (int i = 0; i < JOINTS; ++i) {
    pulls = pulls || z[i] < 0;
  }
  assert_true(pulls); /* the joints matter: a contact could not */
  known_lcp_free(&k);
}

/* Without friction the rounds run on a tableau: nothing is factored, not even by a warm start. */
static void sifting_without_friction_factors_nothing(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    known_lcp k;
    base_error err = {0};
    lcp_verdict v;
    check_ok(few_bodies(&k, 4, 100, 0, seed, &err), &err);
    double *z = calloc((size_t)k.p.M.n, sizeof *z);
    const lcp_result res = run_few(&k.p, "", z, &v);
    assert_int_equal(res.outcome, LCP_SOLVED);
    assert_string_equal(res.variant, "sifted_table");
    assert_int_equal(res.work.factorizations, 0);
    assert_true(res.work.pivots > 0);
    assert_true(v.rho <= 1e-14);
    check_close(velocity_gap(&k.p, z), 0, 1e-11);
    const lcp_result again = run_few(&k.p, "", z, &v);
    assert_int_equal(again.outcome, LCP_SOLVED);
    assert_int_equal(again.work.pivots, 0);
    assert_int_equal(again.work.factorizations, 0);
    assert_true(v.rho <= 1e-14);
    free(z);
    known_lcp_free(&k);
  }
}

/* A set that outgrows the tableau goes on with a factored basis, along the same path. */
static void sifting_outgrows_the_tableau(void **state) {
  (void)state;
  static const char *const tables[] = {"table=0", "table=10", "table=25"};
  known_lcp k;
  base_error err = {0};
  lcp_verdict v;
  double z[150] = {0};
  check_ok(few_bodies(&k, 6, BASE_COUNT(z), 0, 2, &err), &err);
  const lcp_result whole = run_few(&k.p, "", z, &v);
  assert_int_equal(whole.work.factorizations, 0);
  for (int i = 0; i < BASE_COUNT(tables); ++i) {
    memset(z, 0, sizeof z);
    const lcp_result res = run_few(&k.p, tables[i], z, &v);
    assert_int_equal(res.outcome, LCP_SOLVED);
    assert_string_equal(res.variant, "sifted_basis");
    assert_true(res.work.factorizations > 0);
    assert_int_equal(res.work.fallbacks, i > 0); /* leaving a tableau that was begun is counted */
    assert_int_equal(res.work.pivots, whole.work.pivots);
    assert_true(v.rho <= 1e-12);
  }
  known_lcp_free(&k);
}

/* Contacts of two rows, joined by a compliance that is not symmetric; rows in units far apart. */
static void sifting_sees_compliance(void **state) {
  (void)state;
  enum { ROWS = 120, PAIRS = ROWS / 2, DOF = 6 };
  known_lcp k;
  base_error err = {0};
  lcp_verdict v;
  int row_start[PAIRS + 1], jac_start[PAIRS + 1], body[2 * PAIRS], colptr[ROWS + 1],
      rowind[2 * ROWS];
  double val[2 * ROWS], jac[ROWS * DOF], q[ROWS], z[ROWS] = {0};
  check_ok(few_bodies(&k, 1, ROWS, 0, 5, &err), &err);
  for (int g = 0; g <= PAIRS; ++g) {
    row_start[g] = 2 * g;
    jac_start[g] = 2 * g * DOF;
  }
  for (int i = 0; i < ROWS; ++i) {
    const int unit = (i % 7) * 6; /* up to 2^36 */
    body[i] = (i % 2) ? -1 : 0;
    colptr[i] = 2 * i;
    for (int e = 0; e < 2; ++e) {
      rowind[2 * i + e] = i - i % 2 + e;
      val[2 * i + e] =
          ldexp((e == i % 2) ? 0x1p-6 : (e ? 0x1p-7 : -0x1p-8), unit + ((i - i % 2 + e) % 7) * 6);
    }
    q[i] = ldexp(k.p.q[i] + 0.5 * (i / 2 * 17 % PAIRS) / PAIRS, unit); /* gaps: few touch */
    for (int c = 0; c < DOF; ++c) {
      jac[DOF * i + c] = ldexp(k.p.M.factored->jac[DOF * i + c], unit);
    }
  }
  colptr[ROWS] = 2 * ROWS;
  const lcp_csc S = {ROWS, ROWS, colptr, rowind, val};
  lcp_factored f = *k.p.M.factored;
  f.n_group = PAIRS;
  f.row_start = row_start;
  f.body = body;
  f.jac_start = jac_start;
  f.jac = jac;
  f.shift = &S;
  const lcp_problem p = {.M = {.storage = LCP_FACTORED, .n = ROWS, .factored = &f}, .q = q};
  const lcp_result res = run_few(&p, "", z, &v);
  assert_int_equal(res.outcome, LCP_SOLVED);
  assert_string_equal(res.variant, "sifted_table");
  assert_int_equal(res.work.factorizations, 0);
  assert_true(v.rho <= 1e-14);
  known_lcp_free(&k);
}

/* A contact outside the set that the others leave 5e-13 below zero, too little for the usual tie
 * tolerance, is brought in by polishing. */
static void sifted_answers_are_polished(void **state) {
  (void)state;
  enum { CONTACTS = 60 };
  known_lcp k;
  base_error err = {0};
  lcp_verdict v;
  double M[CONTACTS * CONTACTS], q[CONTACTS], z[CONTACTS] = {0}, other[CONTACTS];
  int polished = 0;
  check_ok(few_bodies(&k, 1, CONTACTS, 0, 11, &err), &err);
  assert_int_equal(run_few(&k.p, "", z, &v).outcome, LCP_SOLVED);
  lcp_matrix_to_dense(&k.p.M, M);
  for (int j = 0; j < CONTACTS; ++j) {
    double w = k.p.q[j];
    for (int i = 0; i < CONTACTS; ++i) {
      w += M[CONTACTS * i + j] * z[i];
    }
    if (z[j] > 0) {
      continue;
    }
    memcpy(q, k.p.q, sizeof q);
    memset(other, 0, sizeof other);
    q[j] -= w + 5e-14;
    lcp_problem p = k.p;
    p.q = q;
    const lcp_result res = run_few(&p, "", other, &v);
    assert_int_equal(res.outcome, LCP_SOLVED);
    assert_string_equal(res.variant, (res.work.refinements > 0) ? "polished" : "sifted_table");
    assert_int_equal(res.work.fallbacks, 0);
    assert_true(v.rho <= 1e-14);
    polished += res.work.refinements > 0;
  }
  assert_true(polished > 0);
  known_lcp_free(&k);
}

/* A body of one velocity that two walls approach: no solution, and y >= 0 with J'y = 0 shows it. */
static void squeezed_body_is_proved_infeasible(void **state) {
  (void)state;
  enum { CONTACTS = 8 };
  static const int dof_start[] = {0, 1}, weight_start[] = {0, 1};
  static const double weight[] = {1};
  int row_start[CONTACTS + 1], jac_start[CONTACTS + 1], body[2 * CONTACTS];
  double jac[CONTACTS], q[CONTACTS], z[CONTACTS] = {0};
  for (int c = 0; c <= CONTACTS; ++c) {
    row_start[c] = jac_start[c] = c;
  }
  for (int c = 0; c < CONTACTS; ++c) {
    body[2 * c] = 0;
    body[2 * c + 1] = -1;
    jac[c] = (c % 2) ? 1 : -1;
    q[c] = -1 - 0.125 * c;
  }
  const lcp_factored f = {.n_body = 1,
                          .dof_start = dof_start,
                          .weight_start = weight_start,
                          .weight = weight,
                          .n_group = CONTACTS,
                          .row_start = row_start,
                          .body = body,
                          .jac_start = jac_start,
                          .jac = jac};
  const lcp_problem p = {.M = {.storage = LCP_FACTORED, .n = CONTACTS, .factored = &f},
                         .q = q,
                         .traits = LCP_SYMMETRIC | LCP_PSD};
  lcp_verdict v;
  const lcp_result res = run_few(&p, "", z, &v);
  assert_int_equal(res.outcome, LCP_INFEASIBLE);
  assert_int_equal(res.certificate.kind, LCP_CERT_FARKAS);
  assert_true(res.work.fallbacks > 0); /* sifting gave way to the path on all contacts */
  double y[CONTACTS] = {0};
  lcp_certificate_file c = {.kind = LCP_CERT_FARKAS, .n = CONTACTS, .vector = y};
  lcp_certificate_verdict proof;
  base_error err = {0};
  y[0] = y[3] = 1; /* one wall each */
  check_ok(lcp_certificate_file_verify(&p, &c, &proof, &err), &err);
  assert_true(proof.holds && proof.exact);
  y[3] = 1 + 0x1p-52;
  check_ok(lcp_certificate_file_verify(&p, &c, &proof, &err), &err);
  assert_false(proof.holds);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(factored_form_agrees_with_dense),
      cmocka_unit_test(sliding_start_saves_pivots),
      cmocka_unit_test(sifting_takes_pivots_by_bodies),
      cmocka_unit_test(sifting_solves_grasps),
      cmocka_unit_test(sifting_keeps_joints),
      cmocka_unit_test(sifting_without_friction_factors_nothing),
      cmocka_unit_test(sifting_outgrows_the_tableau),
      cmocka_unit_test(sifting_sees_compliance),
      cmocka_unit_test(sifted_answers_are_polished),
      cmocka_unit_test(squeezed_body_is_proved_infeasible),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
