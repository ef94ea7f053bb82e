/* Every registered formulation that poses problems, on a range of contact sets: shapes, declared
 * traits checked on the numbers, the meaning of a zero answer, work counted, same bits twice. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/lcp_instance.h"
#include "problems/world/contact_merit.h"
#include "tests/support/relax.h"
#include "tests/support/rig.h"
#include "tests/support/tableau.h"

#include <lapacke.h>
#include <string.h>

enum { SETS = 12 };

static rig *make(int which) {
  static const double twenty = 0.35;
  switch (which) {
  case 0:
    return rig_box(3, 0.01, 0.5, twenty);
  case 1:
    return rig_box(2, 0.01, 0.5, twenty);
  case 2:
    return rig_box(3, 0.01, 0, twenty); /* no friction: no friction unknown */
  case 3:
    return rig_stack(3, 0.01, 0.5);
  case 4: { /* rolling and torsion */
    rig *r = rig_box(3, 0.01, 0.5, twenty);
    r->contact[0].torsion = 0.01;
    r->contact[1].rolling = 0.02;
    r->contact[2].torsion = 0.03;
    r->contact[2].rolling = 0.04;
    return r;
  }
  case 5: { /* nothing touches */
    rig *r = rig_box(3, 0.01, 0.5, 0);
    r->x[0][2] = 5;
    return r;
  }
  default:
    return rig_random((uint64_t)which, 2 + which % 2, 0.6);
  }
}

static bool has_cone_or_box(const lcp_problem *p) {
  for (int k = 0; k < p->n_block; k++) {
    if (p->block[k].set == LCP_CONE || p->block[k].set == LCP_BOX) {
      return true;
    }
  }
  return false;
}

/* Cones of several parts are beyond the little solvers of the tests. */
static bool has_parts(const lcp_problem *p) {
  for (int k = 0; k < p->n_block; k++) {
    if (p->block[k].set == LCP_CONE && p->block[k].n_part > 1) {
      return true;
    }
  }
  return false;
}

static lcp_outcome solve_with(const char *name, const char *options, const lcp_problem *p,
                              double *z) {
  const lcp_solver *solver = lcp_solver_find(name);
  assert_non_null(solver);
  base_error err = {0};
  void *opt = calloc(1, solver->options_size);
  base_fields_default(solver->fields, solver->n_fields, opt);
  check_ok(base_fields_parse(solver->fields, solver->n_fields, opt, options, &err), &err);
  const lcp_capacity cap = lcp_problem_capacity(p);
  lcp_instance *instance;
  check_ok(lcp_instance_open(&instance, solver, &cap, opt, &err), &err);
  check_ok(lcp_instance_prepare(instance, p, &err), &err);
  lcp_result result = {0};
  check_ok(lcp_instance_solve(instance, NULL, z, &result, &err), &err);
  lcp_instance_close(instance);
  free(opt);
  return result.outcome;
}

static lcp_outcome solve(const lcp_problem *p, double *z) {
  if (has_parts(p)) {
    return solve_with("nsgs", "tol=1e-11,max_iter=100000", p, z);
  }
  return has_cone_or_box(p) ? relax_solve(p, z, 1e-12) : tableau_solve(p, z);
}

static unsigned posed; /* sets of the blocks of one formulation */

static void check_blocks(const formulation *f, const lcp_problem *p) {
  int at = 0;
  for (int k = 0; k < p->n_block; k++) {
    const unsigned set = 1u << p->block[k].set;
    assert_true((set & (f->sets | 1u << LCP_FREE)) != 0); /* free: joints kept as rows */
    posed |= set;
    assert_int_equal(p->block[k].start, at);
    assert_true(p->block[k].size > 0);
    at += p->block[k].size;
  }
  assert_int_equal(at, p->M.n);
}

static double smallest_eigenvalue(const double *M, int n) {
  double *S = calloc((size_t)n * (size_t)n, sizeof *S);
  double *w = calloc((size_t)n, sizeof *w);
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++) {
      S[i * n + j] = 0.5 * (M[i * n + j] + M[j * n + i]);
    }
  }
  assert_int_equal(LAPACKE_dsyev(LAPACK_COL_MAJOR, 'N', 'U', n, S, n, w), 0);
  const double least = w[0];
  free(S);
  free(w);
  return least;
}

/* Principal minors of all index sets, n <= 10. */
static bool is_p_matrix(const double *M, int n) {
  double sub[100];
  int pivots[10];
  for (int set = 1; set < (1 << n); set++) {
    int index[10];
    int m = 0;
    for (int i = 0; i < n; i++) {
      if (set & (1 << i)) {
        index[m++] = i;
      }
    }
    for (int i = 0; i < m; i++) {
      for (int j = 0; j < m; j++) {
        sub[j * m + i] = M[index[j] * n + index[i]];
      }
    }
    if (LAPACKE_dgetrf(LAPACK_COL_MAJOR, m, m, sub, m, pivots) != 0) {
      return false;
    }
    double det = 1;
    for (int i = 0; i < m; i++) {
      det *= sub[i * m + i] * ((pivots[i] == i + 1) ? 1 : -1);
    }
    if (!(det > 0)) {
      return false;
    }
  }
  return true;
}

static void check_traits(const lcp_problem *p) {
  const int n = p->M.n;
  double *M = calloc((size_t)n * (size_t)n + 1, sizeof *M);
  lcp_matrix_to_dense(&p->M, M);
  double scale = 0;
  bool zero_diagonal = false;
  for (int i = 0; i < n; i++) {
    zero_diagonal = zero_diagonal || M[i * n + i] == 0;
    scale = fmax(scale, fabs(M[i * n + i]));
    for (int j = 0; j < n && (p->traits & LCP_SYMMETRIC) != 0; j++) {
      assert_true(M[i * n + j] == M[j * n + i]);
    }
  }
  assert_int_equal(zero_diagonal, (p->traits & LCP_ZERO_DIAGONAL) != 0);
  if ((p->traits & (LCP_PSD | LCP_PD)) != 0) {
    assert_true(smallest_eigenvalue(M, n) >= -1e-12 * scale * n);
  }
  if ((p->traits & LCP_P_MATRIX) != 0 && n <= 10) {
    assert_true(is_p_matrix(M, n));
  }
  base_rng g = base_rng_seeded(7);
  for (int trial = 0; trial < 200 && (p->traits & LCP_COPOSITIVE) != 0; trial++) {
    double zMz = 0;
    double z[400];
    for (int i = 0; i < n; i++) {
      z[i] = (base_rng_uniform(&g) < 0.5) ? 0 : base_rng_uniform(&g);
    }
    for (int j = 0; j < n; j++) {
      for (int i = 0; i < n; i++) {
        zMz += z[i] * M[j * n + i] * z[j];
      }
    }
    assert_true(zMz >= -1e-12 * scale * n);
  }
  free(M);
}

/* Moments of friction that a contact asks for and that the formulation declares to lack are refused. */
static bool refused(const formulation *f, formulation_run *run, rig *r) {
  base_error err = {0};
  unsigned moments = 0;
  const contact_set *c = rig_set(r);
  for (int i = 0; i < c->n_contact; i++) {
    moments |= (c->rows[i].torsion > 0 ? EFFECT_TORSION : 0u) |
               (c->rows[i].rolling > 0 ? EFFECT_ROLLING : 0u);
  }
  if ((moments & f->lacks) == 0) {
    return false;
  }
  assert_int_equal(formulation_begin(run, c, FORM_COLD, &err), BASE_EUNSUPPORTED);
  assert_true(strstr(err.text, "rolling") != NULL || strstr(err.text, "torsion") != NULL);
  return true;
}

/* Runs one step; zero: answers every problem with z = 0 and "max_iter". */
static void run_step(const formulation *f, formulation_run *run, rig *r, bool zero,
                     const void *opt) {
  base_error err = {0};
  check_ok(formulation_begin(run, rig_set(r), FORM_COLD, &err), &err);
  int n_most = 0;
  long solves = 0;
  for (;;) {
    lcp_problem p;
    const double *z0;
    bool pending;
    check_ok(formulation_assemble(run, &p, &z0, &pending, &err), &err);
    if (!pending) {
      break;
    }
    solves++;
    n_most = (p.M.n > n_most) ? p.M.n : n_most;
    check_ok(lcp_problem_check(&p, &err), &err);
    check_blocks(f, &p);
    check_traits(&p);
    double *z = calloc((size_t)p.M.n, sizeof *z);
    for (int i = 0; i < p.M.n; i++) {
      assert_true(solves > 1 || z0[i] == 0); /* cold */
    }
    lcp_outcome out = LCP_MAX_ITER;
    if (!zero) {
      out = solve(&p, z);
      assert_int_equal(out, LCP_SOLVED);
    }
    check_ok(formulation_recover(run, z, out, &err), &err);
    free(z);
  }
  formulation_answer_of(run, &r->answer);
  assert_int_equal(r->answer.lcp_dim, n_most);
  assert_int_equal(r->answer.work.solves, solves);
  bool all_friction = true;
  for (int i = 0; i < r->n_contact; i++) {
    all_friction = all_friction && r->rows[i].tangent > 0 && r->rows[i].torsion == 0 &&
                   r->rows[i].rolling == 0;
  }
  if (all_friction) {
    const long n = f->dimension(r->dim, r->answer.n_active, opt);
    /* at acceleration level a sliding contact has only its normal force as an unknown */
    assert_true((f->model & FORM_ACCELERATION) != 0 ? n_most <= n : n_most == n);
  }
}

static void shapes_traits_and_zero(void **state) {
  (void)state;
  int count;
  const formulation *const *all = formulations(&count);
  for (int k = 0; k < count; k++) {
    const formulation *f = all[k];
    if ((f->model & FORM_NO_LCP) != 0) {
      continue;
    }
    void *opt = calloc(1, f->options_size);
    base_fields_default(f->fields, f->n_fields, opt);
    posed = 0;
    for (int which = 0; which < SETS; which++) {
      base_error err = {0};
      formulation_run *run;
      check_ok(formulation_open(&run, f, opt, &err), &err);
      rig *r = make(which);
      const bool none = refused(f, run, r);
      if (!none) {
        run_step(f, run, r, true, opt);
        assert_int_equal(r->answer.solved, r->answer.work.solves == 0);
      }
      for (int i = 0; i < r->set.n_dof && !none; i++) {
        check_close(r->answer.v_next[i], r->v_free[i], 1e-15);
      }
      formulation_close(run);
      free(r);
    }
    assert_int_equal(posed & ~(1u << LCP_FREE), f->sets); /* no more and no less than declared */
    free(opt);
  }
}

/* A real answer obeys the unilateral law, balances momentum and repeats to the last bit. */
static void answers_obey_the_contact_law(void **state) {
  (void)state;
  int count;
  const formulation *const *all = formulations(&count);
  for (int k = 0; k < count; k++) {
    const formulation *f = all[k];
    if ((f->model & (FORM_NO_LCP | FORM_ACCELERATION)) != 0) {
      continue;
    }
    void *opt = calloc(1, f->options_size);
    base_fields_default(f->fields, f->n_fields, opt);
    for (int which = 0; which < 6; which++) {
      double first[6 * RIG_BODIES];
      for (int again = 0; again < 2; again++) {
        base_error err = {0};
        formulation_run *run;
        check_ok(formulation_open(&run, f, opt, &err), &err);
        rig *r = make(which);
        run_step(f, run, r, false, opt);
        assert_true(r->answer.solved);
        contact_merit merit;
        check_ok(contact_merit_at(&r->set, r->answer.impulse, r->answer.v_next, r->answer.bias,
                                  &merit, &err),
                 &err);
        if (!(merit.normal <= 1e-7)) {
          print_message("# %s on set %d\n", f->name, which);
        }
        check_close(merit.momentum, 0, 1e-12);
        check_close(merit.normal, 0, 1e-7);
        if ((f->model & FORM_FRICTION) != 0 && (f->model & FORM_BOUNDS_LAGGED) == 0) {
          check_close(merit.cone_rel, 0, 1e-9);
        }
        if (strcmp(f->name, "coulomb") == 0) {
          check_close(merit.ncp, 0, 1e-9);
        }
        const size_t bytes = (size_t)r->set.n_dof * sizeof *first;
        if (again == 0) {
          memcpy(first, r->answer.v_next, bytes);
        } else {
          assert_memory_equal(first, r->answer.v_next, bytes);
        }
        formulation_close(run);
        free(r);
      }
    }
    free(opt);
  }
}

static bool has_option(const formulation *f, const char *name, size_t len) {
  for (int i = 0; i < f->n_fields; i++) {
    if (strlen(f->fields[i].name) == len && strncmp(f->fields[i].name, name, len) == 0) {
      return true;
    }
  }
  return false;
}

/* Words for a reader, options that exist, and FORM_NORMAL_ONLY exactly where the closed form of the
 * dimension is the number of contacts. */
static void says_what_it_is(void **state) {
  (void)state;
  int count;
  const formulation *const *all = formulations(&count);
  for (int k = 0; k < count; k++) {
    const formulation *f = all[k];
    check_sentence(f->name, f->words, NULL);
    check_sentence(f->name, f->when, NULL);
    for (int j = 0; j < k; j++) {
      check_sentence(f->name, f->words, all[j]->words);
    }
    for (const char *at = f->apart; at != NULL && *at != '\0';) {
      const size_t n = strcspn(at, " ");
      if (!has_option(f, at, n)) {
        fail_msg("%s: tells '%s' apart, which is no option of it", f->name, at);
      }
      at += n + strspn(at + n, " ");
    }
    if ((f->model & FORM_NO_LCP) == 0) {
      void *opt = calloc(1, f->options_size);
      base_fields_default(f->fields, f->n_fields, opt);
      const bool one_each = f->dimension(2, 7, opt) == 7 && f->dimension(3, 7, opt) == 7;
      free(opt);
      if (one_each != ((f->model & FORM_NORMAL_ONLY) != 0)) {
        fail_msg("%s: FORM_NORMAL_ONLY and its dimension disagree", f->name);
      }
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(shapes_traits_and_zero),
      cmocka_unit_test(answers_obey_the_contact_law),
      cmocka_unit_test(says_what_it_is),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
