#define _DEFAULT_SOURCE /* mkstemps */
/* Parts of the harness whose mistakes would be believed: rows, keys, statistics, verdicts. */
#include "tests/support/check.h"

#include "harness/campaign/runner_state.h"
#include "harness/cell/stats.h"
#include "harness/measure/answers.h"
#include "harness/measure/registry.h"
#include "harness/measure/verdict.h"
#include "harness/plan/plan.h"
#include "harness/util/args.h"
#include "harness/util/folder.h"
#include "harness/util/sha256.h"
#include "harness/util/versions.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void rows_read_back(void **state) {
  (void)state;
  record a;
  record b;
  char line[RECORD_ROW];
  base_error err;
  record_clear(&a);
  record_clear(&b);
  const size_t empty = record_row(&a, line, sizeof line);
  assert_int_equal(empty, record_columns()); /* commas and the newline: nothing was measured */
  (void)snprintf(a.note, sizeof a.note, "says \"no\", twice\nand more");
  a.t_total_s = 0.1 + 0.2;
  a.rho = (double)NAN;
  a.n_iter = -7;
  a.verified = 0;
  (void)snprintf(a.status, sizeof a.status, "ok");
  const size_t n = record_row(&a, line, sizeof line);
  assert_int_equal(line[n - 1], '\n');
  assert_ptr_equal(strchr(line, '\n'), line + n - 1); /* a row is a line */
  line[n - 1] = '\0';
  check_ok(record_parse(line, &b, &err), &err);
  assert_string_equal(b.note, "says \"no\", twice and more");
  assert_true(a.t_total_s == b.t_total_s && isnan(b.rho) && b.n_iter == -7 && b.verified == 0);
  for (size_t cut = n - 2; cut > 0; cut -= 1 + cut / 50) { /* a torn row is never taken for whole */
    line[cut] = '\0';
    assert_int_equal(record_parse(line, &b, &err), BASE_EINVAL);
  }
}

static void sha256_of_the_standard(void **state) {
  (void)state;
  char hex[SHA256_HEX];
  sha256 s;
  sha256_begin(&s);
  sha256_add(&s, "abc", 3);
  sha256_end(&s, hex);
  assert_string_equal(hex, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  sha256_begin(&s);
  for (int i = 0; i < 1000000; i++) {
    sha256_add(&s, "a", 1);
  }
  sha256_end(&s, hex);
  assert_string_equal(hex, "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

static void medians_and_intervals(void **state) {
  (void)state;
  double x[] = {5, 1, 4, 2, 3};
  double lo;
  double hi;
  stats_sort(x, 5);
  check_close(stats_median(x, 5), 3.0, 0);
  check_close(stats_median(x, 4), 2.5, 0);
  stats_median_interval(x, 5, &lo, &hi); /* too few: the extremes */
  assert_true(lo == 1 && hi == 5);
  double many[100];
  for (int i = 0; i < 100; i++) {
    many[i] = i + 1;
  }
  stats_median_interval(many, 100, &lo, &hi); /* ranks 40 and 61 (binomial, 95 %) */
  assert_true(lo == 40 && hi == 61);
  check_close(stats_quantile(many, 100, 0.95), 95.05, 1e-12);
  double one = 1.0;
  assert_true(isinf(stats_half_width(&one, 1)));
  assert_true(isnan(stats_median(&one, 0)));
}

static void braces_expand(void **state) {
  (void)state;
  text_list l = {0};
  base_error err;
  check_ok(brace_expand("a:n={1,2},m={x,yz}", &l, &err), &err);
  const char *want[] = {"a:n=1,m=x", "a:n=1,m=yz", "a:n=2,m=x", "a:n=2,m=yz"};
  assert_int_equal(l.n, 4);
  for (int i = 0; i < 4; i++) {
    assert_string_equal(l.item[i], want[i]);
  }
  assert_int_equal(brace_expand("a{1", &l, &err), BASE_EINVAL);
  text_list_free(&l);
}

static void units_of_time_and_memory(void **state) {
  (void)state;
  double x;
  assert_true(args_seconds("90", &x) && x == 90);
  assert_true(args_seconds("1.5m", &x) && x == 90);
  assert_true(args_seconds("2h", &x) && x == 7200);
  assert_true(args_bytes("2G", &x) && x == 2147483648.0);
  assert_false(args_seconds("-1", &x) || args_seconds("", &x) || args_seconds("soon", &x));
}

/* M = (-1), q = (-1): infeasible, y = 1 proves it. */
static void claims_are_judged(void **state) {
  (void)state;
  const double m = -1.0;
  const double q = -1.0;
  const double y = 1.0;
  const double wrong = -1.0;
  const double z = 0.0;
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 1, .val = &m}, .q = &q};
  solver_choice s;
  lcp_verdict v;
  base_error err;
  bool verified;
  check_ok(solver_choose("lemke", &s, &err), &err);
  check_ok(lcp_judge(&p, &z, &v, &err), &err);
  lcp_result claim = {.outcome = LCP_SOLVED};
  assert_int_equal(verdict_of(s.solver, s.opt, &p, &claim, &v, &verified), RUN_UNVERIFIED);
  assert_false(verified);
  claim = (lcp_result){.outcome = LCP_INFEASIBLE};
  assert_int_equal(verdict_of(s.solver, s.opt, &p, &claim, &v, &verified), RUN_UNVERIFIED);
  claim.certificate = (lcp_certificate){.kind = LCP_CERT_FARKAS, .vector = &y};
  assert_int_equal(verdict_of(s.solver, s.opt, &p, &claim, &v, &verified), RUN_INFEASIBLE);
  claim.certificate.vector = &wrong;
  assert_int_equal(verdict_of(s.solver, s.opt, &p, &claim, &v, &verified), RUN_UNVERIFIED);
  claim = (lcp_result){.outcome = LCP_RAY};
  assert_int_equal(verdict_of(s.solver, s.opt, &p, &claim, &v, &verified), RUN_RAY);
  claim = (lcp_result){.outcome = LCP_SOLVED};
  v.finite = false;
  assert_int_equal(verdict_of(s.solver, s.opt, &p, &claim, &v, &verified), RUN_NUMERICAL);
  solver_choice_free(&s);
}

/* Any z that is large enough has a small rho; M = [1 -1; -1 1] with q = (-1, -1) has no solution. With q = 0 all of (a, a) are. */
static void a_runaway_is_no_answer(void **state) {
  (void)state;
  const double M[] = {1, -1, -1, 1}, q[] = {-1, -1}, none[] = {0, 0};
  const double far[] = {1e12, 1e12}, near[] = {1, 1};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = M}, .q = q};
  const lcp_problem still = {.M = p.M, .q = none};
  const lcp_result claim = {.outcome = LCP_SOLVED};
  solver_choice s;
  lcp_verdict v;
  base_error err;
  bool verified;
  check_ok(solver_choose("pgs", &s, &err), &err);
  check_ok(lcp_judge(&p, far, &v, &err), &err);
  assert_true(v.rho < 1e-12 && v.defect > 0.5);
  assert_int_equal(verdict_of(s.solver, s.opt, &p, &claim, &v, &verified), RUN_UNVERIFIED);
  assert_false(verified);
  check_ok(lcp_judge(&still, near, &v, &err), &err);
  assert_int_equal(verdict_of(s.solver, s.opt, &still, &claim, &v, &verified), RUN_OK);
  assert_true(verified);
  solver_choice_free(&s);
}

/* Iterative: 1e-6 verifies; asked for less, less is ok but not verified. */
static void asked_tolerance_decides_ok(void **state) {
  (void)state;
  solver_choice s;
  base_error err;
  bool verified;
  const double m = 1.0;
  const double q = -1.0;
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 1, .val = &m}, .q = &q};
  const lcp_result claim = {.outcome = LCP_SOLVED};
  check_ok(solver_choose("pgs", &s, &err), &err);
  lcp_verdict v = {.rho = 5e-4, .finite = true};
  assert_int_equal(verdict_of(s.solver, s.opt, &p, &claim, &v, &verified), RUN_UNVERIFIED);
  check_ok(solver_choice_set(&s, "tol", "1e-3", &err), &err);
  assert_int_equal(verdict_of(s.solver, s.opt, &p, &claim, &v, &verified), RUN_OK);
  assert_false(verified);
  v.rho = 5e-3;
  assert_int_equal(verdict_of(s.solver, s.opt, &p, &claim, &v, &verified), RUN_NEAR);
  v.rho = 5e-7;
  assert_int_equal(verdict_of(s.solver, s.opt, &p, &claim, &v, &verified), RUN_OK);
  assert_true(verified);
  solver_choice_free(&s);
}

/* The linker puts this in the place of version_of_solver: a solver whose source has changed. */
static const char *changed_solver = "";
const char *__real_version_of_solver(const char *name);
const char *__wrap_version_of_solver(const char *name);
const char *__wrap_version_of_solver(const char *name) {
  return (strcmp(name, changed_solver) == 0) ? "0123456789abcdef" : __real_version_of_solver(name);
}

static void read_plan(const char *path, campaign *c, plan *p) {
  base_error err;
  const plan_filter all = {.n_shard = 0};
  check_ok(campaign_read(path, false, c, &err), &err);
  check_ok(plan_make(c, &all, p, &err), &err);
}

/* And this in the place of sha256_file: how often a file is read. */
static int files_hashed;
base_status __real_sha256_file(const char *path, char hex[SHA256_HEX], base_error *err);
base_status __wrap_sha256_file(const char *path, char hex[SHA256_HEX], base_error *err);
base_status __wrap_sha256_file(const char *path, char hex[SHA256_HEX], base_error *err) {
  files_hashed++;
  return __real_sha256_file(path, hex, err);
}

static void write_text(const char *path, const char *text) {
  FILE *to = fopen(path, "w");
  assert_non_null(to);
  (void)fputs(text, to);
  (void)fclose(to);
}

/* Two parts with three solvers of one problem in two files: each is read once. */
static void problems_are_hashed_once(void **state) {
  (void)state;
  static const char *const names[] = {"once_harness.M.mtx", "once_harness.q.mtx",
                                      "once_harness.yaml"};
  write_text(names[0], "%%MatrixMarket matrix coordinate real general\n1 1 1\n1 1 2\n");
  write_text(names[1], "%%MatrixMarket matrix array real general\n1 1\n-1\n");
  write_text(names[2], "name: once\nparts:\n"
                       "  - {name: a, problems: [once_harness.M.mtx, \"murty:n=3\"], solvers: "
                       "[lemke, pgs, ppm]}\n"
                       "  - {name: b, problems: [once_harness.M.mtx], solvers: [lemke, pgs, "
                       "\"pgs:omega=1.2\"]}\n");
  campaign c;
  plan p;
  files_hashed = 0;
  read_plan(names[2], &c, &p);
  assert_int_equal(p.n_cell, 9);
  assert_int_equal(files_hashed, 2);
  char whole[SHA256_HEX];
  base_error err;
  check_ok(__real_sha256_file(names[0], whole, &err), &err);
  for (int i = 0; i < 9; i++) {
    const bool is_file = strchr(p.cell[i].problem, ':') == NULL;
    assert_int_equal(strcmp(p.cell[i].problem_sha256, p.cell[0].problem_sha256) == 0, is_file);
    assert_string_not_equal(p.cell[i].problem_sha256, whole); /* M and q together */
  }
  plan_free(&p);
  campaign_free(&c);
  for (int i = 0; i < 3; i++) {
    (void)unlink(names[i]);
  }
}

static void g6_a_changed_solver_invalidates_its_cells(void **state) {
  (void)state;
  char path[] = "keys_XXXXXX.yaml";
  const int fd = mkstemps(path, 5);
  FILE *to = fdopen(fd, "w");
  assert_non_null(to);
  (void)fputs("name: keys\nparts:\n  - name: a\n    problems: [\"murty:n={3,4}\"]\n"
              "    solvers: [lemke, pgs, \"pgs:omega=1.2\"]\n",
              to);
  (void)fclose(to);
  campaign c[2];
  plan p[2];
  read_plan(path, &c[0], &p[0]);
  changed_solver = "pgs";
  read_plan(path, &c[1], &p[1]);
  changed_solver = "";
  (void)unlink(path);
  assert_int_equal(p[0].n_cell, 6);
  assert_int_equal(p[1].n_cell, 6);
  for (int i = 0; i < 6; i++) {
    const bool is_pgs = strncmp(p[0].cell[i].solver, "pgs", 3) == 0;
    assert_string_equal(p[0].cell[i].solver, p[1].cell[i].solver);
    assert_true((strcmp(p[0].cell[i].id, p[1].cell[i].id) != 0) == is_pgs);
  }
  for (int k = 0; k < 2; k++) {
    plan_free(&p[k]);
    campaign_free(&c[k]);
  }
}

/* Canaries 5, 5.1 and 6 ms, 6 ms at the end: what was measured between 5.1 and 6 is flagged. */
static void drifting_canaries_flag_rows(void **state) {
  (void)state;
  char dir[] = "drift_XXXXXX";
  assert_non_null(mkdtemp(dir));
  const double canary[] = {5e-3, 5.1e-3, 5.1e-3, 6e-3};
  record row[4];
  record_table t = {.row = row, .n = 4};
  base_error err;
  for (int i = 0; i < 4; i++) {
    record_clear(&row[i]);
    row[i].schema = RECORD_SCHEMA;
    row[i].canary_s = canary[i];
    (void)snprintf(row[i].status, sizeof row[i].status, "ok");
  }
  check_ok(runner_write_rows(dir, &t, &err), &err);
  runner_summary sum = {.measured = 4};
  const runner_options o = {.out = dir};
  runner r = {.o = &o, .sum = &sum, .canary = 6e-3};
  check_ok(runner_close_rows(&r, &err), &err);
  record_table back;
  check_ok(runner_read_rows(dir, &back, &err), &err);
  const bool want[] = {false, true, true, false};
  for (int i = 0; i < 4; i++) {
    assert_int_equal(record_has_flag(&back.row[i], "canary_drift"), want[i]);
  }
  record_table_free(&back);
  char path[64];
  folder_file(dir, "results.csv", path, sizeof path);
  (void)unlink(path);
  (void)rmdir(dir);
}

static void answers_read_back(void **state) {
  (void)state;
  const double z[] = {0, 1.5, -0.0, (double)NAN, 0, 0, 0, 1e-300, 0, -2};
  const double proof[10] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  const lcp_result solved = {.outcome = LCP_SOLVED};
  const lcp_result none = {.outcome = LCP_INFEASIBLE,
                           .certificate = {.kind = LCP_CERT_FARKAS, .vector = proof}};
  char path[] = "answers_XXXXXX";
  (void)close(mkstemp(path));
  base_error err;
  answers a;
  double back[10];
  lcp_result claim;
  check_ok(answers_create(&a, path, &err), &err);
  check_ok(answers_put(&a, 10, z, &solved, &err), &err);
  check_ok(answers_put(&a, 10, z, &none, &err), &err);
  check_ok(answers_put_failure(&a, 3, BASE_EUNSUPPORTED, &err), &err);
  check_ok(answers_close(&a, true, &err), &err);

  check_ok(answers_open(&a, path, &err), &err);
  check_ok(answers_take(&a, 10, back, &claim, &err), &err);
  assert_int_equal(claim.outcome, LCP_SOLVED);
  for (int i = 0; i < 10; i++) {
    assert_true(back[i] == z[i] || (isnan(back[i]) && isnan(z[i])));
  }
  check_ok(answers_take(&a, 10, back, &claim, &err), &err);
  assert_int_equal(claim.outcome, LCP_INFEASIBLE);
  assert_memory_equal(claim.certificate.vector, proof, sizeof proof);
  assert_int_equal(answers_finish(&a, &err),
                   BASE_EINVAL); /* one is left (its first byte is gone) */
  check_ok(answers_close(&a, false, &err), &err);

  check_ok(answers_open(&a, path, &err), &err);
  assert_int_equal(answers_take(&a, 9, back, &claim, &err), BASE_EINVAL); /* another size */
  check_ok(answers_close(&a, false, &err), &err);
  (void)unlink(path);
}

/* What cpufreq says in kHz; nothing said, nothing known. */
static void frequencies_are_read(void **state) {
  (void)state;
  assert_int_equal(system("mkdir -p freq_harness/cpu3/cpufreq freq_harness/cpu4/cpufreq"), 0);
  write_text("freq_harness/cpu3/cpufreq/scaling_cur_freq", "2345678\n");
  write_text("freq_harness/cpu4/cpufreq/scaling_cur_freq", "<unknown>\n");
  check_close(machine_frequency_in("freq_harness", 3), 2345.678, 1e-9);
  assert_true(isnan(machine_frequency_in("freq_harness", 4)));
  assert_true(isnan(machine_frequency_in("freq_harness", 5)));
  assert_int_equal(system("rm -r freq_harness"), 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(rows_read_back),
      cmocka_unit_test(sha256_of_the_standard),
      cmocka_unit_test(medians_and_intervals),
      cmocka_unit_test(braces_expand),
      cmocka_unit_test(units_of_time_and_memory),
      cmocka_unit_test(claims_are_judged),
      cmocka_unit_test(a_runaway_is_no_answer),
      cmocka_unit_test(asked_tolerance_decides_ok),
      cmocka_unit_test(g6_a_changed_solver_invalidates_its_cells),
      cmocka_unit_test(problems_are_hashed_once),
      cmocka_unit_test(frequencies_are_read),
      cmocka_unit_test(answers_read_back),
      cmocka_unit_test(drifting_canaries_flag_rows),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
