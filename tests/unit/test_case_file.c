/* The case format: every case of tests/cases, without loss; and what must be refused. */
#include "tests/support/check.h"

#include "problems/read/case_file.h"
#include "tests/support/files.h"

#include <stdio.h>
#include <string.h>

static const char *catalogue(void) {
  return tests_file("cases/cases.json");
}

static const scene_spec *find(const case_file *f, const char *id) {
  for (int i = 0; i < f->scenes.n_scene; i++) {
    if (strcmp(f->scenes.scene[i].id, id) == 0) {
      return &f->scenes.scene[i];
    }
  }
  fail_msg("scene %s is missing", id);
  return NULL;
}

static const lcp_case *find_lcp(const case_file *f, const char *id) {
  for (int i = 0; i < f->n_lcp; i++) {
    if (strcmp(f->lcp[i].id, id) == 0) {
      return &f->lcp[i];
    }
  }
  fail_msg("lcp %s is missing", id);
  return NULL;
}

static void catalogue_is_read_whole(void **state) {
  (void)state;
  case_file f;
  base_error err = {0};
  check_ok(case_file_read(catalogue(), &f, &err), &err);
  for (int i = 0; i < f.scenes.n_failed; i++) {
    print_error("%s: %s\n", f.scenes.failed[i].id, f.scenes.failed[i].err.text);
  }
  assert_int_equal(f.scenes.n_failed, 0);
  assert_int_equal(f.scenes.n_scene, 82 + 39);
  assert_int_equal(f.n_lcp, 92);
  assert_int_equal(f.n_equivalence, 8 + 2);
  assert_int_equal(f.n_painleve, 10);
  int n_check = 0, n_off = 0;
  for (int i = 0; i < f.scenes.n_scene; i++) {
    n_check += f.scenes.scene[i].n_check;
    n_off += f.scenes.scene[i].n_off;
  }
  assert_int_equal(n_check, 575 + 10); /* + isotropic x and y of five scenes */
  assert_int_equal(n_off, 36);
  case_file_free(&f);
}

static void scenes_keep_their_numbers(void **state) {
  (void)state;
  case_file f;
  base_error err = {0};
  check_ok(case_file_read(catalogue(), &f, &err), &err);
  const scene_spec *s = find(&f, "B03.a");
  check_close(s->fixed[0].normal[1], cos(20.0 * 3.14159265358979323846 / 180.0), 1e-15);
  check_close(s->gravity[1], -9.81, 0.0);
  assert_int_equal(s->effects,
                   EFFECT_GRAVITY | EFFECT_CONTACT | EFFECT_FRICTION); /* no rotation needed */
  assert_int_equal(s->present, s->effects | EFFECT_ROTATION);
  assert_int_equal(s->off[0].effect, EFFECT_FRICTION);
  check_close(s->off[0].check.value, 41.94022007531012, 0.0);
  check_close(s->check[0].tol.reg_v, 0.0, 0.0);
  check_close(s->check[1].tol.h2, 27.45378519737761, 0.0);
  check_close(s->check[1].tol.reg_v, 3.8216874597951245, 0.0);
  assert_true(spec_check_applies(&s->check[0], "velocity", "velocity", 8));
  assert_false(spec_check_applies(&s->check[0], "regularized", "regularized", 0));
  assert_false(spec_check_applies(&s->check[0], "penalty", "", 0));
  assert_true(spec_check_applies(&s->check[0], "boxed", "velocity", 0));
  s = find(&f, "B23.d");
  assert_int_equal(s->facets, 6);
  assert_int_equal(s->body[1].lock, SPEC_ROT | SPEC_Y | SPEC_Z);
  s = find(&f, "B30.a");
  assert_true(s->body[1].kinematic || s->body[0].kinematic);
  assert_true((s->effects & EFFECT_MOTION) != 0);
  s = find(&f, "B19.a");
  assert_string_equal(s->acceleration.regime, "inconsistent");
  assert_int_equal(find(&f, "C03.100")->contact_multiplicity, 100);
  assert_true(find(&f, "C12.c")->expect_unsolved);
  s = find(&f, "C07.3");
  check_close(s->contact_stiffness, 1e10, 0.0);
  check_close(s->check[0].value, 9.81e-10, 1e-24);
  s = find(&f, "B32.a");
  assert_true((s->effects & EFFECT_GYROSCOPIC) != 0 && (s->effects & EFFECT_GRAVITY) == 0);
  case_file_free(&f);
}

/* rho-free check: with the listed z, w = M z + q is nonnegative and complementary. */
static double defect(const lcp_case *c, const double *z) {
  double worst = 0.0;
  const lcp_matrix *M = &c->k.p.M;
  double *w = calloc((size_t)c->n + 1, sizeof *w), *size = calloc((size_t)c->n + 1, sizeof *w);
  assert_non_null(w);
  assert_non_null(size);
  for (int j = 0; j < c->n; j++) {
    const int lo = (M->storage == LCP_CSC) ? M->csc.colptr[j] : 0;
    const int hi = (M->storage == LCP_CSC) ? M->csc.colptr[j + 1] : c->n;
    for (int at = lo; at < hi; at++) {
      const int i = (M->storage == LCP_CSC) ? M->csc.rowind[at] : at;
      const double m =
          (M->storage == LCP_CSC) ? M->csc.val[at] : M->val[(size_t)j * (size_t)c->n + (size_t)at];
      w[i] += m * z[j];
      size[i] += fabs(m * z[j]);
    }
  }
  for (int i = 0; i < c->n; i++) {
    const double scale = size[i] + fabs(c->k.p.q[i]) + 1e-300;
    w[i] = (w[i] + c->k.p.q[i]) / scale;
    worst = fmax(worst, fmax(-w[i], (z[i] > 0.0) ? fabs(w[i]) : 0.0));
  }
  free(w);
  free(size);
  return worst;
}

/* y >= 0, M' y <= 0, q' y < 0: a proof, in doubles (the entries are small integers or dyadic). */
static void check_farkas(const lcp_case *c, const double *y) {
  const size_t n = (size_t)c->n;
  double *M = malloc(n * n * sizeof *M);
  assert_non_null(M);
  lcp_matrix_to_dense(&c->k.p.M, M);
  double qy = 0.0;
  for (size_t j = 0; j < n; j++) {
    double column = 0.0;
    for (size_t i = 0; i < n; i++) {
      column += M[j * n + i] * y[i];
    }
    assert_true(y[j] >= 0.0 && column <= 0.0);
    qy += c->k.p.q[j] * y[j];
  }
  assert_true(qy < 0.0);
  free(M);
}

static void listed_answers_solve_their_problems(void **state) {
  (void)state;
  case_file f;
  base_error err = {0};
  int judged = 0;
  int proved = 0;
  check_ok(case_file_read(catalogue(), &f, &err), &err);
  for (int i = 0; i < f.n_lcp; i++) {
    const lcp_case *c = &f.lcp[i];
    for (int s = 0; s < c->n_solution; s++, judged++) {
      check_close(defect(c, c->solution + (size_t)s * (size_t)c->n), 0.0, 1e-14);
    }
    if (c->example != NULL) {
      check_close(defect(c, c->example), 0.0, 1e-14);
      judged++;
    }
    if (c->k.z != NULL && c->n_solution > 0) { /* the generator's own answer is the listed one */
      for (int j = 0; j < c->n; j++) {
        check_close(c->k.z[j], c->solution[j], 1e-12 * fabs(c->solution[j]));
      }
    }
    if (c->k.farkas != NULL) {
      check_farkas(c, c->k.farkas);
      proved++;
    }
    if (c->k.lemke_pivots != 0 && c->lemke_pivots != 0) {
      assert_int_equal(c->k.lemke_pivots, c->lemke_pivots);
    }
    if (c->k.least_index_pivots != 0 && c->least_index_pivots != 0) {
      assert_int_equal(c->k.least_index_pivots, c->least_index_pivots);
    }
  }
  assert_true(judged > 80);
  assert_int_equal(proved, 12);
  assert_string_equal(find_lcp(&f, "A12.05")->shape_error, "M: row 1 has 2 entries, need 1");
  assert_string_equal(find_lcp(&f, "A12.06")->shape_error, "M has 2 rows, need n = 1");
  assert_true(isnan(find_lcp(&f, "A12.01")->k.p.M.val[3]));
  assert_int_equal(find_lcp(&f, "A15.07")->n_set, 3);
  assert_int_equal(find_lcp(&f, "A3.03")->invariants.n_row, 3);
  assert_int_equal(find_lcp(&f, "A14.02")->k.answer, KNOWN_UNSOLVABLE);
  assert_non_null(find_lcp(&f, "A4.05")->k.farkas);
  case_file_free(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(catalogue_is_read_whole),
      cmocka_unit_test(scenes_keep_their_numbers),
      cmocka_unit_test(listed_answers_solve_their_problems),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
