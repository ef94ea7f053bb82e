#define _DEFAULT_SOURCE /* mkdtemp */
/* Sequences: the files give back the same problems, the arms start where they say, and a start that costs more is counted. */
#include "tests/support/check.h"

#include "harness/sequence/sequence_file.h"
#include "harness/sequence/sequence_solve.h"
#include "harness/sequence/sequence_source.h"
#include "lcp/lcp_solver.h"

#include <dirent.h>
#include <stdio.h>
#include <unistd.h>

/* ---- files ----------------------------------------------------------------------------------- */

static void same_bytes(const void *a, const void *b, size_t n) {
  if (n > 0) {
    assert_memory_equal(a, b, n);
  }
}

static void same_matrix(const lcp_matrix *a, const lcp_matrix *b) {
  assert_int_equal(a->storage, b->storage);
  assert_int_equal(a->n, b->n);
  const size_t n = (size_t)a->n;
  if (a->storage == LCP_DENSE) {
    same_bytes(a->val, b->val, n * n * sizeof *a->val);
    return;
  }
  const size_t nnz = (size_t)a->csc.colptr[n];
  same_bytes(a->csc.colptr, b->csc.colptr, (n + 1) * sizeof *a->csc.colptr);
  same_bytes(a->csc.rowind, b->csc.rowind, nnz * sizeof *a->csc.rowind);
  same_bytes(a->csc.val, b->csc.val, nnz * sizeof *a->csc.val);
}

static void same_item(const sequence_item *a, const sequence_item *b) {
  const size_t n = (size_t)a->p.M.n, k = (size_t)a->n_owner;
  same_matrix(&a->p.M, &b->p.M);
  same_bytes(a->q, b->q, n * sizeof *a->q);
  same_bytes(a->z, b->z, n * sizeof *a->z);
  same_bytes(a->active, b->active, n);
  assert_int_equal(a->p.traits, b->p.traits);
  assert_int_equal(a->p.n_block, b->p.n_block);
  for (int i = 0; i < a->p.n_block; i++) {
    const lcp_block *x = &a->block[i], *y = &b->block[i];
    assert_true(x->start == y->start && x->size == y->size && x->set == y->set &&
                x->n_part == y->n_part && x->soft == y->soft);
    same_bytes(x->part_dim, y->part_dim, (size_t)x->n_part * sizeof *x->part_dim);
    same_bytes(x->part_mu, y->part_mu, (size_t)x->n_part * sizeof *x->part_mu);
  }
  assert_int_equal(a->n_owner, b->n_owner);
  same_bytes(a->owner, b->owner, k * sizeof *a->owner);
  same_bytes(a->first, b->first, (k + 1) * sizeof *a->first);
  assert_true(a->step == b->step && a->solve == b->solve && a->status == b->status);
  assert_true(a->verified == b->verified && a->rho == b->rho);
  assert_true(a->n_active == b->n_active && a->n_changed == b->n_changed && a->change == b->change);
}

static void remove_folder(const char *dir) {
  char path[600];
  DIR *d = opendir(dir);
  assert_non_null(d);
  for (struct dirent *e = readdir(d); e != NULL; e = readdir(d)) {
    if (e->d_name[0] != '.') {
      (void)snprintf(path, sizeof path, "%s/%s", dir, e->d_name);
      assert_int_equal(remove(path), 0);
    }
  }
  (void)closedir(d);
  assert_int_equal(rmdir(dir), 0);
}

/* Of each kind of problem and storage that a file holds one, moving, with contacts that come and go. */
static void files_give_back_the_same_bits(void **state) {
  (void)state;
  static const char *const texts[] = {"clatter@regularized@lemke@0.01@40",
                                      "clatter@velocity:facets=4@lemke@0.01@40",
                                      "card_house@velocity:storage=csc@lemke@0.01@5",
                                      "stack:n=4@velocity:storage=factored@lemke@0.01@4",
                                      "slider_crank@velocity:joints=mixed@lemke@0.01@8",
                                      "slider_crank@velocity:joints=mixed,storage=csc@lemke@0.01@8",
                                      "clatter@coulomb@cone_newton@0.01@40",
                                      "spin@coulomb@nsgs@0.01@8",
                                      "arch@acceleration@lemke@0.01@4"};
  for (int i = 0; i < BASE_COUNT(texts); i++) {
    char dir[] = "/tmp/lcpbench_sequence_XXXXXX";
    base_error err = {0};
    sequence posed, read;
    assert_non_null(mkdtemp(dir));
    check_ok(sequence_open(texts[i], &posed, &err), &err);
    check_ok(sequence_write(&posed, dir, &err), &err);
    assert_true(sequence_is(dir));
    check_ok(sequence_open(dir, &read, &err), &err);
    assert_string_equal(posed.scene, read.scene);
    assert_true(posed.h == read.h && posed.steps == read.steps && posed.count == read.count);
    assert_int_equal(posed.n, read.n);
    for (int k = 0; k < posed.n; k++) {
      same_item(&posed.item[k], &read.item[k]);
    }
    sequence_free(&posed);
    sequence_free(&read);
    remove_folder(dir);
  }
}

/* ---- problems whose answers are known -------------------------------------------------------- */

/* M = diag(2, .., 2) on contacts with these names, one row each; answer z_i = max(0, -q_i / 2). */
static void put(sequence *s, long step, int n, const uint64_t *name, const double *q) {
  double M[16] = {0};
  double z[4];
  int first[5];
  lcp_block block[4];
  base_error err = {0};
  for (int i = 0; i < n; i++) {
    M[i * n + i] = 2.0;
    z[i] = fmax(0.0, -q[i] / 2.0);
    block[i] = (lcp_block){.start = i, .size = 1, .set = LCP_ORTHANT};
  }
  for (int i = 0; i <= n; i++) {
    first[i] = i;
  }
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = n, .val = M},
                         .q = q,
                         .block = block,
                         .n_block = n,
                         .traits = LCP_SYMMETRIC | LCP_PD};
  const sim_solved k = {
      .step = step, .p = &p, .z = z, .status = RUN_OK, .verified = true, .rho = 0.0};
  check_ok(sequence_put_named(s, &k, n, name, first, &err), &err);
}

static void rows_are_found_by_name(void **state) {
  (void)state;
  sequence s = {0};
  const uint64_t abc[] = {1, 2, 3}, bcd[] = {2, 3, 4}, wrong[] = {3, 2};
  int from[3];
  put(&s, 1, 3, abc, (const double[]){-2, 1, -2}); /* 1 and 3 carry */
  put(&s, 2, 3, bcd, (const double[]){-2, -2, 1}); /* 2 and 3 */
  put(&s, 2, 3, bcd, (const double[]){1, 1, 1});   /* nobody: the second problem of the step */
  sequence_match(&s.item[1], &s.item[0], from);
  assert_true(from[0] == 1 && from[1] == 2 && from[2] == -1);
  assert_true(s.item[0].n_active == 2 && s.item[0].n_changed == 2);
  assert_int_equal(s.item[1].n_changed, 2); /* 1 left, 2 came */
  check_close(s.item[1].change, 2.0 / 3.0, 0);
  assert_true(s.item[2].solve == 2 && s.item[2].n_changed == 2 && s.item[2].change == 1.0);
  check_close(sequence_change(&s), (2.0 / 3.0 + 1.0) / 2.0, 1e-16);
  const double zero[2] = {0};
  const int first[] = {0, 1, 2};
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 2, .val = (const double[]){2, 0, 0, 2}},
                         .q = zero};
  const sim_solved k = {.step = 3, .p = &p, .z = zero, .status = RUN_OK};
  assert_int_equal(sequence_put_named(&s, &k, 2, wrong, first, NULL), BASE_EINVAL);
  assert_int_equal(s.n, 3);
  sequence_free(&s);
}

/* ---- arms ------------------------------------------------------------------------------------ */

/* A solver that writes down where it is started, and answers right on diagonal problems. */
static double started[8][4];
static int n_started;

typedef struct options {
  lcp_stop stop;
} options;
static const base_field fields[] = {LCP_STOP_FIELDS(options, 1e-12, 10)};
typedef struct echo_state {
  unsigned char basis[4];
} echo_state;
static void layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)state;
  (void)cap;
  (void)opt;
  (void)a;
}
static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  (void)opt;
  (void)trace;
  echo_state *s = state;
  memset(s->basis, 0, sizeof s->basis);
  for (int i = 0; i < p->M.n; i++) {
    started[n_started][i] = z[i];
    z[i] = fmax(0.0, -p->q[i] / 2.0);
    s->basis[i] = p->q[i] <= 0.0; /* a row that carries nothing may be basic */
  }
  n_started++;
  *res = (lcp_result){.outcome = LCP_SOLVED, .variant = "", .work.iterations = 1};
  res->certificate = (lcp_certificate){.kind = LCP_CERT_BASIS, .basis = s->basis};
  return BASE_OK;
}
static const lcp_solver echo = {.name = "echo",
                                .sets = 1u << LCP_ORTHANT,
                                .storages = 1u << LCP_DENSE,
                                .exact = true,
                                .warm = true,
                                LCP_SOLVER_PARTS(echo_state)};

static void run_echo(const sequence *s, sequence_start start) {
  options opt;
  base_error err = {0};
  sequence_result r;
  base_fields_default(fields, BASE_COUNT(fields), &opt);
  const solver_choice choice = {.solver = &echo, .opt = &opt};
  const sequence_request q = {.sequence = s, .solver = &choice, .start = start};
  n_started = 0;
  check_ok(sequence_solve(&q, &r, NULL, &err), &err);
  assert_int_equal(r.status, RUN_OK);
  assert_true(r.verified && r.n == s->n && n_started == s->n);
}

static void starts_at(int k, double a, double b, double c) {
  assert_true(started[k][0] == a && started[k][1] == b && started[k][2] == c);
}

static void arms_start_where_they_say(void **state) {
  (void)state;
  sequence s = {0};
  const uint64_t abc[] = {1, 2, 3}, bcd[] = {2, 3, 4};
  put(&s, 1, 3, abc, (const double[]){-2, -4, 0}); /* z = 1 2 0, basis 1 1 1 */
  put(&s, 2, 3, abc, (const double[]){-6, -2, 2}); /* z = 3 1 0, basis 1 1 0 */
  put(&s, 3, 3, bcd, (const double[]){-2, 2, -2}); /* z = 1 0 1 of 2 3 4, basis 1 0 1 */
  put(&s, 4, 3, abc, (const double[]){-2, -2, -2});
  run_echo(&s, SEQUENCE_COLD);
  for (int k = 0; k < 4; k++) {
    starts_at(k, 0, 0, 0);
  }
  run_echo(&s, SEQUENCE_PREVIOUS);
  starts_at(0, 0, 0, 0);
  starts_at(1, 1, 2, 0);
  starts_at(2, 1, 0, 0); /* 2 and 3 had a past, 4 is new */
  starts_at(3, 0, 1, 0); /* 1 had none in the last problem */
  run_echo(&s, SEQUENCE_BASIS);
  starts_at(1, 2, 2, 2); /* all were basic: at the largest number of that answer */
  starts_at(2, 3, 0, 0);
  starts_at(3, 0, 1, 0);
  run_echo(&s, SEQUENCE_PREDICTED);
  starts_at(1, 1, 2, 0); /* one past */
  starts_at(2, 0, 0, 0); /* 2: 2 1 - 2 = 0; 3: 0; 4: new */
  starts_at(3, 0, 1, 0); /* 2: 2 1 - 1 */
  sequence_free(&s);
}

/* ---- regressions ----------------------------------------------------------------------------- */

static void compare(const sequence *s, const char *solver, sequence_start start,
                    sequence_regressions *out) {
  solver_choice choice;
  base_error err = {0};
  check_ok(solver_choose(solver, &choice, &err), &err);
  const sequence_request q = {.sequence = s, .solver = &choice, .start = start};
  check_ok(sequence_compare(&q, HUGE_VAL, out, &err), &err);
  solver_choice_free(&choice);
}

/* All carry, then nobody, in turns: cold needs no pivot for the second, and from the last answer as many as there are rows. */
static void a_planted_regression_is_counted(void **state) {
  (void)state;
  sequence turns = {0};
  sequence still = {0};
  const uint64_t abc[] = {1, 2, 3};
  sequence_regressions r;
  for (long step = 1; step <= 6; step++) {
    put(&turns, step, 3, abc,
        (step % 2 == 1) ? (const double[]){-1, -2, -3} : (const double[]){1, 2, 3});
    put(&still, step, 3, abc, (const double[]){-1, -2, -3});
  }
  static const char *const pivoting[] = {"lemke", "ppm"};
  for (int i = 0; i < BASE_COUNT(pivoting); i++) {
    compare(&turns, pivoting[i], SEQUENCE_PREVIOUS, &r);
    assert_int_equal(r.work, 3);
    compare(&turns, pivoting[i], SEQUENCE_BASIS, &r);
    assert_int_equal(r.work, 3);
    compare(&still, pivoting[i], SEQUENCE_PREVIOUS, &r);
    assert_int_equal(r.work, 0);
    compare(&turns, pivoting[i], SEQUENCE_COLD, &r);
    assert_true(r.work == 0 && r.time >= 0);
  }
  compare(&turns, "pgs", SEQUENCE_BASIS, &r);
  assert_true(r.work == SEQUENCE_UNCOUNTED && r.time == SEQUENCE_UNCOUNTED);
  solver_choice lemke;
  check_ok(solver_choose("lemke", &lemke, NULL), &(base_error){0});
  const sequence_request q = {.sequence = &turns, .solver = &lemke, .start = SEQUENCE_PREVIOUS};
  check_ok(sequence_compare(&q, 0.0, &r, NULL), &(base_error){0}); /* no time: work alone */
  assert_true(r.work == 3 && r.time == SEQUENCE_UNCOUNTED);
  solver_choice_free(&lemke);
  sequence_free(&turns);
  sequence_free(&still);
}

static void what_is_not_defined_says_so(void **state) {
  (void)state;
  sequence s = {0};
  const uint64_t abc[] = {1, 2, 3};
  put(&s, 1, 3, abc, (const double[]){-1, -2, -3});
  static const struct {
    const char *solver;
    sequence_start start;
    run_status word;
  } want[] = {{"interior_point", SEQUENCE_PREVIOUS, RUN_UNSUPPORTED},
              {"interior_point", SEQUENCE_COLD, RUN_OK},
              {"pgs", SEQUENCE_BASIS, RUN_UNSUPPORTED},
              {"nsgs", SEQUENCE_COLD, RUN_OK}};
  for (int i = 0; i < BASE_COUNT(want); i++) {
    solver_choice choice;
    sequence_result r;
    base_error err = {0};
    check_ok(solver_choose(want[i].solver, &choice, &err), &err);
    const sequence_request q = {.sequence = &s, .solver = &choice, .start = want[i].start};
    check_ok(sequence_solve(&q, &r, NULL, &err), &err);
    assert_int_equal(r.status, want[i].word);
    assert_true((r.note[0] != '\0') == (want[i].word != RUN_OK));
    solver_choice_free(&choice);
  }
  sequence_free(&s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(files_give_back_the_same_bits),
      cmocka_unit_test(rows_are_found_by_name),
      cmocka_unit_test(arms_start_where_they_say),
      cmocka_unit_test(a_planted_regression_is_counted),
      cmocka_unit_test(what_is_not_defined_says_so),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
