/* Certificates: what solvers hand over survives the trip through a file and is checked exactly; a
 * file that was tampered with is not. */
#include "tests/support/check.h"

#include "lcp/lcp_certificate.h"
#include "lcp/lcp_instance.h"
#include "tests/support/golden.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { N_MAX = 128, OPT_MAX = 512 };

static char path[64];

static int make_path(void **state) {
  (void)state;
  (void)snprintf(path, sizeof path, "/tmp/lcp_certificate_%ld.txt", (long)getpid());
  return 0;
}

static int drop_path(void **state) {
  (void)state;
  (void)remove(path);
  return 0;
}

static lcp_certificate_verdict through_file(const lcp_problem *p, const lcp_certificate *c,
                                            const double *z) {
  base_error err = {0};
  lcp_certificate_file f;
  lcp_certificate_verdict v;
  check_ok(lcp_certificate_write(path, p->M.n, c, z, &err), &err);
  check_ok(lcp_certificate_read(path, &f, &err), &err);
  assert_int_equal(f.kind, c->kind);
  check_ok(lcp_certificate_file_verify(p, &f, &v, &err), &err);
  lcp_certificate_free(&f);
  return v;
}

/* Whatever a solver hands over with "ok" or "infeasible" holds. */
static void solvers_certify(void **state) {
  (void)state;
  static const char *const names[] = {"lemke", "ppm", "murty", "enumerate", "block_pivoting"};
  int ng;
  const golden *g = goldens(&ng);
  int checked = 0;
  int exact = 0;
  for (int i = 0; i < BASE_COUNT(names) * ng; i++) {
    const lcp_solver *s = lcp_solver_find(names[i / ng]);
    const golden *c = &g[i % ng];
    base_error err = {0};
    if (lcp_solver_admits(s, &c->p, NULL) != BASE_OK) {
      continue;
    }
    _Alignas(16) unsigned char opt[OPT_MAX] = {0};
    base_fields_default(s->fields, s->n_fields, opt);
    const lcp_capacity cap = lcp_problem_capacity(&c->p);
    lcp_instance *k;
    double z[N_MAX] = {0};
    lcp_result r;
    check_ok(lcp_instance_open(&k, s, &cap, opt, &err), &err);
    const base_status ready = lcp_instance_prepare(k, &c->p, &err);
    if (ready != BASE_EUNSUPPORTED) {
      check_ok(ready, &err);
      check_ok(lcp_instance_solve(k, NULL, z, &r, &err), &err);
      if (r.certificate.kind != LCP_CERT_NONE) {
        const lcp_certificate_verdict v = through_file(&c->p, &r.certificate, z);
        if (!v.holds) {
          fail_msg("%s on %s: %s", s->name, c->name, v.why);
        }
        checked++;
        exact += v.exact;
      }
    }
    lcp_instance_close(k);
  }
  print_message("# %d certificates hold, %d of them exactly\n", checked, exact);
  assert_true(checked > 60 && exact > 50);
}

static void tampering_shows(void **state) {
  (void)state;
  /* w = (z1 - z2 - 1, z2 - z1 - 3): y = (1, 1); the pair (4 1; 1 3), q = (-1, -2) */
  const double walls[] = {2, -2, -2, 2};
  const double q[] = {-1, -3};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = walls}, .q = q};
  const double good[] = {1, 1};
  const double tilted[] = {1, 1 + 0x1p-52};
  const double negative[] = {1, -1};
  const double nothing[] = {0, 0};
  lcp_certificate c = {.kind = LCP_CERT_FARKAS, .vector = good};
  assert_true(through_file(&p, &c, NULL).exact);
  check_close(through_file(&p, &c, NULL).residual, -1.0, 0.0);
  c.vector = tilted; /* one unit in the last place is already no proof */
  assert_false(through_file(&p, &c, NULL).holds);
  c.vector = negative;
  assert_false(through_file(&p, &c, NULL).holds);
  c.vector = nothing;
  assert_false(through_file(&p, &c, NULL).holds);

  const double M[] = {4, 1, 1, 3};
  const double r[] = {-1, -2};
  const lcp_problem spd = {.M = {.storage = LCP_DENSE, .n = 2, .val = M}, .q = r};
  const unsigned char both[] = {1, 1};
  const unsigned char one[] = {0, 1};
  const double z[] = {1.0 / 11, 7.0 / 11};
  c = (lcp_certificate){.kind = LCP_CERT_BASIS, .basis = both};
  assert_true(through_file(&spd, &c, z).exact);
  const double off[] = {1.0 / 11, 7.1 / 11};
  c.basis = one;
  assert_false(through_file(&spd, &c, off).holds);
  c = (lcp_certificate){.kind = LCP_CERT_RAY, .vector = good};
  assert_true(through_file(&p, &c, NULL).holds);
  assert_false(through_file(&p, &c, NULL).exact);
}

static void bad_files_are_refused(void **state) {
  (void)state;
  static const struct {
    const char *text, *says;
  } bad[] = {
      {"", "lcpbench"},
      {"lcpbench certificate 2\n", "need '1'"},
      {"lcpbench certificate 1\nkind guess\nn 1\n0 1\n", "need basis, farkas or ray"},
      {"lcpbench certificate 1\nkind farkas\nn 99999999\n0 1\n", "n"},
      {"lcpbench certificate 1\nkind farkas\nn 2\n0 1\n", "announces 4"},
      {"lcpbench certificate 1\nkind farkas\nn 2\n1 1\n0 1\n", ":4"},
      {"lcpbench certificate 1\nkind farkas\nn 1\n0 nan\n", ":4"},
      {"lcpbench certificate 1\nkind basis\nn 1\n0 2 1.5\n", ":4"},
      {"lcpbench certificate 1\nkind basis\n", "'n'"},
      {"lcpbench certificate 1\nn 1\nkind basis\n0 1 1.5\n", "'kind'"},
      {"lcpbench certificate 1\nkind ray\nn -1\n", "n"},
      {"lcpbench certificate 1\nkind basis\nn 1\n0 1 one\n", "one"},
  };
  for (int i = 0; i < BASE_COUNT(bad); i++) {
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    assert_true(fputs(bad[i].text, f) >= 0 && fclose(f) == 0);
    base_error err = {0};
    lcp_certificate_file c;
    assert_int_not_equal(lcp_certificate_read(path, &c, &err), BASE_OK);
    if (strstr(err.text, bad[i].says) == NULL) {
      fail_msg("'%s' does not say '%s'", err.text, bad[i].says);
    }
    assert_null(c.vector);
  }
  base_error err = {0};
  const lcp_certificate none = {.kind = LCP_CERT_NONE};
  assert_int_equal(lcp_certificate_write(path, 1, &none, NULL, &err), BASE_EINVAL);
  const double y = 1;
  const lcp_certificate c = {.kind = LCP_CERT_FARKAS, .vector = &y};
  assert_int_equal(lcp_certificate_write("/nowhere/at/all", 1, &c, NULL, &err), BASE_EIO);
  lcp_certificate_file f;
  assert_int_equal(lcp_certificate_read("/nowhere/at/all", &f, &err), BASE_EIO);
}

/* M = [1 -1; -1 1], q = (-1, -1) has no solution; z = (t, t) leaves w = q, and rho = 1/(4 t). */
static void large_points_prove_nothing(void **state) {
  (void)state;
  const double M[4] = {1, -1, -1, 1};
  double q[2] = {-1, -1};
  double z[2] = {1e15, 1e15};
  unsigned char basis[2] = {1, 1};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = M}, .q = q};
  const lcp_certificate_file f = {.kind = LCP_CERT_BASIS, .n = 2, .basis = basis, .vector = z};
  lcp_certificate_verdict v;
  base_error err = {0};
  check_ok(lcp_certificate_file_verify(&p, &f, &v, &err), &err);
  assert_true(v.residual <= 1e-9);
  assert_false(v.holds);
  q[0] = 1; /* z = (1, 2): M z = (-1, 1), w = 0 */
  z[0] = 1;
  z[1] = 2;
  check_ok(lcp_certificate_file_verify(&p, &f, &v, &err), &err);
  assert_true(v.holds);
}

/* The same with a third row a (z_0 + z_1) + q_2 without diagonal, whose unit comes from its column: q_2 = a says
 * that the data are of size 1, and w = (-1, -1) is not small against that however large a is. */
static void rows_without_diagonal_are_weighed(void **state) {
  (void)state;
  const double a = 1e10;
  const double M[9] = {1, -1, a, -1, 1, a, a, a, 0};
  const double q[3] = {-1, -1, a};
  double z[3] = {1e9, 1e9, 0};
  unsigned char basis[3] = {1, 1, 0};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 3, .val = M}, .q = q};
  const lcp_certificate_file f = {.kind = LCP_CERT_BASIS, .n = 3, .basis = basis, .vector = z};
  lcp_certificate_verdict v;
  base_error err = {0};
  check_ok(lcp_certificate_file_verify(&p, &f, &v, &err), &err);
  assert_true(v.residual <= 1e-9);
  assert_false(v.holds);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(solvers_certify, make_path, drop_path),
      cmocka_unit_test_setup_teardown(tampering_shows, make_path, drop_path),
      cmocka_unit_test_setup_teardown(bad_files_are_refused, make_path, drop_path),
      cmocka_unit_test(large_points_prove_nothing),
      cmocka_unit_test(rows_without_diagonal_are_weighed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
