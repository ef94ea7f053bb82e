/* Friction over facets, folded: the polygon, the products, the answers. */
#include "tests/support/check.h"

#include "lcp/base/rng.h"
#include "lcp/lcp_instance.h"
#include "lcp/solvers/facet_fold.h"
#include "tests/support/random_cones.h"
#include "tests/support/solve.h"

#include <string.h>

static const double pi = 3.14159265358979323846;

static double distance(const double *a, const double *b) {
  return hypot(a[0] - b[0], a[1] - b[1]);
}

/* The nearest point of the polygon by its edges, one after the other. */
static double nearest_on_edges(int f, double radius, const double *v) {
  double least = HUGE_VAL;
  for (int k = 0; k < f; k++) {
    const double a[2] = {radius * cos(2 * pi * k / f), radius * sin(2 * pi * k / f)};
    const double b[2] = {radius * cos(2 * pi * (k + 1) / f), radius * sin(2 * pi * (k + 1) / f)};
    const double e[2] = {b[0] - a[0], b[1] - a[1]};
    const double t = ((v[0] - a[0]) * e[0] + (v[1] - a[1]) * e[1]) / (e[0] * e[0] + e[1] * e[1]);
    const double on = fmin(fmax(t, 0.0), 1.0);
    const double point[2] = {a[0] + on * e[0], a[1] + on * e[1]};
    least = fmin(least, distance(v, point));
  }
  return least;
}

static bool is_inside(int f, double radius, const double *v) {
  for (int k = 0; k < f; k++) {
    const double n[2] = {cos((2 * k + 1) * pi / f), sin((2 * k + 1) * pi / f)};
    if (n[0] * v[0] + n[1] * v[1] > radius * cos(pi / f)) {
      return false;
    }
  }
  return true;
}

/* by[i]: central difference of the projection of (v, radius) by its j-th number. */
static void difference(int f, const double *at, int j, double *by) {
  const double h = 1e-6;
  double moved[3], to[2][2], unused[6];
  for (int side = 0; side < 2; side++) {
    memcpy(moved, at, sizeof moved);
    moved[j] += (side == 0) ? h : -h;
    (void)lcp_polygon_project(f, moved[2], moved, to[side], unused, unused + 4);
  }
  for (int i = 0; i < 2; i++) {
    by[i] = (to[0][i] - to[1][i]) / (2 * h);
  }
}

static void the_nearest_point_of_a_polygon(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(5);
  for (int trial = 0; trial < 3000; trial++) {
    const int f = 3 + trial % 14;
    const double at[3] = {base_rng_normal(&r), base_rng_normal(&r), 0.2 + base_rng_uniform(&r)};
    double to[2], by[6], is[2];
    const bool inside = lcp_polygon_project(f, at[2], at, to, by, by + 4);
    assert_int_equal(inside, is_inside(f, at[2], at));
    check_close(distance(at, to), inside ? 0.0 : nearest_on_edges(f, at[2], at), 1e-12);
    for (int j = 0; j < 3; j++) {
      difference(f, at, j, is);
      check_close(by[2 * j], is[0], 1e-6);
      check_close(by[2 * j + 1], is[1], 1e-6);
    }
  }
}

/* ---- problems -------------------------------------------------------------------------------- */

/* A set of cones with facets in their place: part of k of dimension d has f facets, or two. */
typedef struct faceted {
  lcp_problem p;
  lcp_factored f;
  lcp_csc shift;
  lcp_block *block;
  int *row_start, *jac_start, *colptr, *rowind;
  double *jac, *q, *val;
} faceted;

static int facets_of(const lcp_block *b, int part, int f) {
  return (b->part_dim[part] == 2) ? f : 2;
}

static int width_of(const lcp_block *b, int f) {
  int width = 1;
  for (int k = 0; k < b->n_part; k++) {
    width += facets_of(b, k, f) + 1;
  }
  return width;
}

/* Rows n, facets and sigmas (zero) of `b` from its cone rows, each `dof` long. */
static double *put_rows(const lcp_block *b, int f, int dof, const double *from, double *out) {
  memcpy(out, from, (size_t)dof * sizeof *out);
  out += dof;
  from += dof;
  for (int k = 0; k < b->n_part; k++) {
    const int count = facets_of(b, k, f), dim = b->part_dim[k];
    for (int m = 0; m < count; m++) {
      for (int i = 0; i < dof; i++) {
        *out++ = cos(2 * pi * m / count) * from[i] +
                 ((dim == 2) ? sin(2 * pi * m / count) * from[dof + i] : 0);
      }
    }
    from += dim * dof;
  }
  memset(out, 0, (size_t)(b->n_part * dof) * sizeof *out);
  return out + (ptrdiff_t)b->n_part * dof;
}

static void put_shift(faceted *t, const lcp_block *b, const lcp_block *to, int f, double a,
                      int *at) {
  const int sigma = to->start + to->size - b->n_part;
  t->colptr[to->start] = *at;
  for (int k = 0; k < b->n_part; k++) {
    t->rowind[*at] = sigma + k;
    t->val[(*at)++] = a * b->part_mu[k];
  }
  for (int k = 0, column = to->start + 1; k < b->n_part; k++) {
    for (int m = 0; m < facets_of(b, k, f); m++) {
      t->colptr[column++] = *at;
      t->rowind[*at] = sigma + k;
      t->val[(*at)++] = -a;
    }
  }
  for (int k = 0, row = to->start + 1; k < b->n_part; row += facets_of(b, k++, f)) {
    t->colptr[sigma + k] = *at;
    for (int m = 0; m < facets_of(b, k, f); m++) {
      t->rowind[*at] = row + m;
      t->val[(*at)++] = a;
    }
  }
}

static void *room(size_t count, size_t size) {
  void *mem = calloc(count + 1, size);
  assert_non_null(mem);
  return mem;
}

/* Every block of k is one cone, which is one group. */
static void facet(faceted *t, const lcp_problem *p, int f) {
  const lcp_factored *of = p->M.factored;
  const size_t most = (size_t)p->n_block * (size_t)(1 + 3 * (f + 1));
  assert_int_equal(p->n_block, of->n_group);
  *t = (faceted){.block = room((size_t)p->n_block, sizeof *t->block),
                 .row_start = room((size_t)p->n_block, sizeof(int)),
                 .jac_start = room((size_t)p->n_block, sizeof(int)),
                 .colptr = room(most, sizeof(int)),
                 .rowind = room(3 * most, sizeof(int)),
                 .val = room(3 * most, sizeof(double)),
                 .q = room(most, sizeof(double)),
                 .jac = room(12 * most, sizeof(double))};
  double *out = t->jac;
  int n = 0, at = 0;
  for (int g = 0; g < of->n_group; g++) {
    const lcp_block *b = &p->block[g];
    const double *jac = of->jac + of->jac_start[g];
    t->row_start[g] = n;
    t->jac_start[g] = (int)(out - t->jac);
    for (int side = 0; side < 2; side++) {
      const int body = of->body[2 * g + side];
      const int dof = (body >= 0) ? of->dof_start[body + 1] - of->dof_start[body] : 0;
      out = put_rows(b, f, dof, jac, out);
      jac += (ptrdiff_t)b->size * dof;
    }
    (void)put_rows(b, f, 1, p->q + b->start, t->q + n);
    t->block[g] =
        (lcp_block){.start = n, .size = width_of(b, f), .set = LCP_ORTHANT, .n_part = b->n_part};
    for (int k = 0; k < b->n_part; k++) {
      t->block[g].part_dim[k] = facets_of(b, k, f);
    }
    put_shift(t, b, &t->block[g], f, 0.5 + g % 3, &at);
    n += t->block[g].size;
  }
  t->row_start[of->n_group] = n;
  t->jac_start[of->n_group] = (int)(out - t->jac);
  t->colptr[n] = at;
  t->shift = (lcp_csc){n, n, t->colptr, t->rowind, t->val};
  t->f = *of;
  t->f.row_start = t->row_start;
  t->f.jac_start = t->jac_start;
  t->f.jac = t->jac;
  t->f.shift = &t->shift;
  t->p = (lcp_problem){.M = {.storage = LCP_FACTORED, .n = n, .factored = &t->f},
                       .q = t->q,
                       .block = t->block,
                       .n_block = p->n_block,
                       .traits = LCP_ZERO_DIAGONAL | LCP_COPOSITIVE};
}

static void facet_free(faceted *t) {
  void *const mem[] = {t->block,  t->row_start, t->jac_start, t->colptr,
                       t->rowind, t->jac,       t->q,         t->val};
  for (int i = 0; i < BASE_COUNT(mem); i++) {
    free(mem[i]);
  }
}

static void *open_fold(lcp_fold *s, const lcp_problem *p) {
  const lcp_capacity cap = lcp_problem_capacity(p);
  base_arena measure = base_arena_measuring();
  lcp_fold_layout(s, &cap, &measure);
  void *mem = base_alloc(measure.used);
  assert_non_null(mem);
  base_arena real = base_arena_over(mem, measure.used);
  lcp_fold_layout(s, &cap, &real);
  lcp_fold_begin(s, p);
  return mem;
}

/* Sigma leaves no facet's row below zero, and one at it. */
static void check_sigmas(const lcp_problem *p, const double *w, double top) {
  for (int g = 0; g < p->n_block; g++) {
    const lcp_block *b = &p->block[g];
    for (int part = 0, row = b->start + 1; part < b->n_part; row += b->part_dim[part++]) {
      double least = HUGE_VAL;
      for (int m = 0; m < b->part_dim[part]; m++) {
        least = fmin(least, w[row + m]);
      }
      assert_true(fabs(least) <= 1e-12 * top);
    }
  }
}

/* The folded rows at x are those of the cones that the facets were made of; unfolded, x comes back and nothing is below zero. */
static void check_fold(const lcp_fold *s, const lcp_problem *cones, const lcp_problem *p,
                       base_rng *r) {
  const size_t n = (size_t)cones->M.n, m = (size_t)p->M.n;
  double *x = room(5 * n + 2 * m + lcp_matrix_scratch(&p->M), sizeof *x);
  double *w = x + n, *back = w + n, *cone = back + n, *unit = cone + n;
  double *z = unit + n, *wz = z + m, *own = wz + m;
  double top = 0;
  for (size_t i = 0; i < n; i++) {
    x[i] = base_rng_normal(r);
    unit[i] = 1e8; /* any speed leaves the polygon */
  }
  for (int g = 0; g < cones->n_block; g++) {
    x[cones->block[g].start] = fabs(x[cones->block[g].start]);
  }
  lcp_matrix_apply(&s->p.M, x, s->p.q, w, own);
  lcp_matrix_apply(&cones->M, x, cones->q, cone, own);
  lcp_fold_out(s, x, w, unit, z);
  lcp_fold_in(s, z, back);
  lcp_matrix_apply(&p->M, z, p->q, wz, own);
  for (size_t i = 0; i < n; i++) {
    top = fmax(top, fabs(cone[i]));
  }
  for (size_t i = 0; i < n; i++) {
    check_close(back[i], x[i], 1e-13);
    assert_true(fabs(w[i] - cone[i]) <= 1e-12 * top);
  }
  for (size_t i = 0; i < m; i++) {
    assert_true(z[i] >= 0);
  }
  check_sigmas(p, wz, top);
  free(x);
}

/* Friction inside its polygon by half, and speeds that are its rounding: the contact sticks, and sigma is zero to the last bit.
 * At a corner a speed that pushes on is a slip speed. */
static void a_contact_that_sticks_has_no_slip_speed(void **state) {
  (void)state;
  int told = 0;
  for (int facets = 2; facets < 9; facets++) {
    known_lcp k;
    faceted t;
    lcp_fold s;
    base_error err = {0};
    check_ok(random_cones(&k, (uint64_t)facets, &err), &err);
    facet(&t, &k.p, facets);
    void *mem = open_fold(&s, &t.p);
    assert_true(s.done);
    const size_t n = (size_t)s.p.M.n;
    double *x = room(3 * n + (size_t)t.p.M.n, sizeof *x), *w = x + n, *unit = w + n, *z = unit + n;
    for (size_t i = 0; i < n; i++) {
      unit[i] = 1;
    }
    for (int corner = 0; corner < 2; corner++) {
      for (int g = 0; g < s.p.n_block; g++) {
        const lcp_block *b = &s.p.block[g];
        x[b->start] = 1;
        for (int part = 0, row = b->start + 1; part < b->n_part; row += b->part_dim[part++]) {
          x[row] = b->part_mu[part] * ((corner == 1) ? 1 : 0.25);
          w[row] = (corner == 1) ? -1e-6 : -1e-17;
        }
      }
      lcp_fold_out(&s, x, w, unit, z);
      for (int g = 0; g < t.p.n_block; g++) {
        const lcp_block *b = &t.p.block[g];
        for (int part = 0; part < b->n_part; part++) {
          const double sigma = z[b->start + b->size - b->n_part + part];
          if (s.p.block[g].part_mu[part] > 0) {
            assert_true((corner == 1) ? sigma > 0 : sigma == 0);
            told++;
          }
        }
      }
    }
    free(x);
    free(mem);
    facet_free(&t);
    known_lcp_free(&k);
  }
  assert_true(told > 100);
}

/* Facets that are mixed of the rows of their cones: these are what is folded to, not a copy, and the rows are those of the copy. Where one
 * contact has friction that is no mixture, or another mixture, they are copied or not folded. */
static void mixed_facets_are_not_copied(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(7);
  int shared = 0;
  for (int seed = 1; seed <= 40; seed++) {
    known_lcp k;
    faceted t;
    lcp_fold s;
    base_error err = {0};
    const int f = 3 + seed % 7;
    double c[(7 + 9) * 3] = {1};
    const lcp_mixture facets = {f + 2, 3, c};
    check_ok(random_cones(&k, (uint64_t)seed, &err), &err);
    facet(&t, &k.p, f);
    const lcp_mixture **mixture = room((size_t)t.p.n_block, sizeof(void *));
    bool all = true;
    for (int m = 0; m < f; m++) {
      c[3 * (1 + m) + 1] = cos(2 * pi * m / f);
      c[3 * (1 + m) + 2] = sin(2 * pi * m / f);
    }
    for (int g = 0; g < t.p.n_block; g++) {
      mixture[g] = (k.p.block[g].n_part == 1) ? &facets : NULL;
      all = all && k.p.block[g].n_part == 1;
    }
    lcp_factored mixed = t.f;
    mixed.jac = k.p.M.factored->jac;
    mixed.stored_start = k.p.M.factored->jac_start;
    mixed.mixture = mixture;
    lcp_problem p = t.p;
    p.M.factored = &mixed;
    if (all) {
      check_ok(lcp_problem_check(&p, &err), &err);
      void *mem = open_fold(&s, &p);
      assert_true(s.done && s.factored.jac == mixed.jac && s.factored.mixture == NULL);
      check_fold(&s, &k.p, &p, &r);
      c[4] += 1e-3; /* a facet that is none of the regular ones */
      lcp_fold_begin(&s, &p);
      assert_false(s.done);
      c[4] -= 1e-3;
      free(mem);
      shared++;
    }
    free((void *)mixture);
    facet_free(&t);
    known_lcp_free(&k);
  }
  assert_true(shared > 10);
}

static void products_are_those_of_the_facets(void **state) {
  (void)state;
  base_rng r = base_rng_seeded(6);
  for (int seed = 1; seed <= 20; seed++) {
    known_lcp k;
    faceted t;
    lcp_fold s;
    base_error err = {0};
    check_ok(random_cones(&k, (uint64_t)seed, &err), &err);
    facet(&t, &k.p, 3 + seed % 9);
    void *mem = open_fold(&s, &t.p);
    assert_true(s.done);
    assert_int_equal(s.p.M.n, k.p.M.n);
    check_fold(&s, &k.p, &t.p, &r);
    t.jac[t.jac_start[0] + 6] += 1e-3; /* a facet that is none of the regular ones */
    lcp_fold_begin(&s, &t.p);
    assert_false(s.done);
    t.jac[t.jac_start[0] + 6] -= 1e-3;
    t.val[0] = -1; /* a bound below zero */
    lcp_fold_begin(&s, &t.p);
    assert_false(s.done);
    free(mem);
    facet_free(&t);
    known_lcp_free(&k);
  }
}

static lcp_outcome run(const lcp_problem *p, double *z, lcp_result *res) {
  *res = solve_by("cone_newton", "max_iter=300", p, z);
  return res->outcome;
}

/* Random sets with 4, 6 or 8 facets: of those that the stored matrix, which is not folded, is solved with, the folded one misses
 * few; no claim is false; and an answer is its own warm start. */
static void faceted_sets_are_solved_folded(void **state) {
  (void)state;
  enum { SETS = CHECK_FEWER(30) };
  int folded = 0, stored = 0;
  long steps[2] = {0};
  for (int seed = 1; seed <= SETS; seed++) {
    known_lcp k;
    faceted t;
    lcp_csc csc;
    lcp_result res;
    lcp_verdict v;
    base_error err = {0};
    check_ok(random_cones(&k, (uint64_t)seed, &err), &err);
    facet(&t, &k.p, 4 + 2 * (seed % 3));
    double *z = room((size_t)t.p.M.n, sizeof *z);
    const bool here = run(&t.p, z, &res) == LCP_SOLVED;
    check_ok(lcp_judge(&t.p, z, &v, &err), &err);
    assert_true(v.rho <= (here ? 1e-9 : 1.01 * res.residual + 1e-12));
    steps[0] += res.work.iterations;
    if (here) {
      assert_int_equal(run(&t.p, z, &res), LCP_SOLVED);
      assert_true(res.work.factorizations <= 4);
    }
    check_ok(lcp_matrix_to_csc(&t.p.M, &csc, &err), &err);
    lcp_problem p = t.p;
    p.M = (lcp_matrix){.storage = LCP_CSC, .n = p.M.n, .csc = csc};
    memset(z, 0, (size_t)p.M.n * sizeof *z);
    const bool there = run(&p, z, &res) == LCP_SOLVED;
    steps[1] += res.work.iterations;
    folded += here;
    stored += there;
    lcp_csc_free(&csc);
    free(z);
    facet_free(&t);
    known_lcp_free(&k);
  }
  print_message("folded %d of %d in %ld steps, stored %d in %ld\n", folded, SETS, steps[0], stored,
                steps[1]);
  assert_true(folded >= stored - 1 && folded >= SETS - 3);
}

static lcp_instance *open_newton(const lcp_problem *p, void *opt) {
  const lcp_solver *s = lcp_solver_find("cone_newton");
  const lcp_capacity cap = lcp_problem_capacity(p);
  base_error err = {0};
  lcp_instance *k;
  base_fields_default(s->fields, s->n_fields, opt);
  check_ok(lcp_instance_open(&k, s, &cap, opt, &err), &err);
  return k;
}

/* Capacities tell what is left of a problem once its facets are folded, and what is solved folded has no room for more: beside the same
 * cones an unknown that folds away costs the test of answers, with its row of W J', and no part of the Newton system. */
static void what_folds_away_takes_no_room(void **state) {
  (void)state;
  for (int seed = 1; seed <= 10; seed++) {
    known_lcp k;
    faceted t;
    lcp_fold s;
    _Alignas(16) unsigned char opt[512] = {0};
    base_error err = {0};
    check_ok(random_cones(&k, (uint64_t)seed, &err), &err);
    facet(&t, &k.p, 4 + 2 * (seed % 3));
    void *mem = open_fold(&s, &t.p);
    assert_true(s.done);
    const lcp_capacity cap = lcp_problem_capacity(&t.p);
    assert_int_equal(cap.n_folded, s.p.M.n);
    assert_int_equal(cap.n_jac_folded, s.factored.jac_start[s.factored.n_group]);
    const lcp_capacity cones = lcp_problem_capacity(&k.p);
    assert_int_equal(cones.n_folded, cones.n);
    assert_int_equal(cones.n_jac_folded, cones.n_jac);
    lcp_instance *faceted_one = open_newton(&t.p, opt), *cone = open_newton(&k.p, opt);
    const size_t more = lcp_instance_bytes(faceted_one) - lcp_instance_bytes(cone);
    const size_t folded = (size_t)(cap.n - cap.n_folded);
    const size_t facets = (size_t)(cap.n_jac - cap.n_jac_folded), padding = 64 * 50;
    assert_true(more <= 96 * folded + 8 * facets + 12 * (size_t)cap.nnz + padding);
    lcp_instance_close(faceted_one);
    lcp_instance_close(cone);
    free(mem);
    facet_free(&t);
    known_lcp_free(&k);
  }
}

/* One facet's row that is not where it belongs: all unknowns stay, with room for them, and the instance folds the next problem to the
 * same bits as a fresh one. */
static void facets_that_do_not_fold_have_room(void **state) {
  (void)state;
  known_lcp k;
  faceted t;
  lcp_result res;
  lcp_verdict v;
  _Alignas(16) unsigned char opt[512] = {0};
  base_error err = {0};
  check_ok(random_cones(&k, 1, &err), &err);
  facet(&t, &k.p, 6);
  const size_t n = (size_t)t.p.M.n;
  double *z = room(n, sizeof *z), *again = room(n, sizeof *again);
  lcp_instance *one = open_newton(&t.p, opt);
  assert_int_equal(run(&t.p, z, &res), LCP_SOLVED);
  for (int pass = 0; pass < 2; pass++) {
    double *entry = &t.jac[t.jac_start[0] + 6];
    const double was = *entry;
    *entry -= 1e-3;
    memset(again, 0, n * sizeof *again);
    check_ok(lcp_instance_prepare(one, &t.p, &err), &err);
    check_ok(lcp_instance_solve(one, NULL, again, &res, &err), &err);
    check_ok(lcp_judge(&t.p, again, &v, &err), &err);
    assert_true(v.rho <= ((res.outcome == LCP_SOLVED) ? 1e-9 : 1.01 * res.residual + 1e-12));
    *entry = was;
    memset(again, 0, n * sizeof *again);
    check_ok(lcp_instance_prepare(one, &t.p, &err), &err);
    check_ok(lcp_instance_solve(one, NULL, again, &res, &err), &err);
    assert_int_equal(res.outcome, LCP_SOLVED);
    assert_memory_equal(again, z, n * sizeof *again);
  }
  lcp_instance_close(one);
  free(z);
  free(again);
  facet_free(&t);
  known_lcp_free(&k);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_nearest_point_of_a_polygon),
      cmocka_unit_test(a_contact_that_sticks_has_no_slip_speed),
      cmocka_unit_test(products_are_those_of_the_facets),
      cmocka_unit_test(mixed_facets_are_not_copied),
      cmocka_unit_test(faceted_sets_are_solved_folded),
      cmocka_unit_test(what_folds_away_takes_no_room),
      cmocka_unit_test(facets_that_do_not_fold_have_room),
  };
  return cmocka_run_group_tests_name("facet_fold", tests, NULL, NULL);
}
