/* Sweeps in batches of four contacts with cones and with facets, against the plain sweep in the same order. */
#include "tests/support/check.h"

#include "lcp/base/crew.h"
#include "lcp/lcp_cone.h"
#include "lcp/solvers/cone_batches.h"
#include "lcp/solvers/cone_block.h"
#include "lcp/solvers/cone_sweep.h"
#include "lcp/solvers/facet_batches.h"
#include "tests/support/plain_sweep.h"
#include "tests/support/solve.h"

#include <stdio.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* The bed with a cone for every contact. */
typedef struct cones {
  contact_bed bed;
  lcp_problem p;
  lcp_block *block;
  lcp_cone_sweep plain;
  lcp_cone_batches fast;
  void *memory;
} cones;

static void carve_cones(cones *f, base_arena *a) {
  const lcp_capacity cap = lcp_problem_capacity(&f->p);
  lcp_cone_sweep_layout(&f->plain, &cap, a);
  lcp_cone_batches_layout(&f->fast, &cap, a);
}

static void cones_open(cones *f, int contacts) {
  base_error err = {0};
  f->bed = contact_bed_open(contacts, 3);
  f->block = calloc((size_t)contacts, sizeof *f->block);
  assert_non_null(f->bed.memory);
  assert_non_null(f->block);
  f->p = f->bed.p;
  f->p.lo = f->p.hi = NULL;
  f->p.block = f->block;
  f->p.n_block = contacts;
  for (int k = 0; k < contacts; k++) {
    f->block[k] = (lcp_block){.start = 3 * k,
                              .size = 3,
                              .set = LCP_CONE,
                              .n_part = 1,
                              .part_dim = {2},
                              .part_mu = {0.05 + 0.1 * (k % 11)}};
  }
  check_ok(lcp_problem_check(&f->p, &err), &err);
  base_arena a = base_arena_measuring();
  carve_cones(f, &a);
  f->memory = base_alloc(a.used);
  assert_non_null(f->memory);
  a = base_arena_over(f->memory, a.used);
  carve_cones(f, &a);
  check_ok(lcp_cone_sweep_prepare(&f->plain, &f->p, &err), &err);
}

static void cones_close(cones *f) {
  contact_bed_close(&f->bed);
  free(f->block);
  free(f->memory);
}

/* One sweep over the cones in the order of the batches, one by one. */
static void plain_cones(cones *f, double omega, double *z) {
  lcp_sweep *s = &f->plain.sweep;
  for (int k = 0; k < LCP_LANES * f->fast.in.n_batch; k++) {
    const int g = f->fast.in.order[k];
    double b[3], x[3];
    if (g < 0) {
      continue;
    }
    const double *A = f->plain.A + (ptrdiff_t)(3 * g) * LCP_CONE_MAX;
    for (int i = 0; i < 3; i++) {
      b[i] = lcp_sweep_row(s, &f->p, 3 * g + i);
      for (int j = 0; j < 3; j++) {
        b[i] -= A[i + 3 * j] * z[3 * g + j];
      }
    }
    lcp_cone_solve(&f->block[g], A, b, x);
    for (int i = 0; i < 3; i++) {
      const double dz = omega * (x[i] - z[3 * g + i]);
      lcp_sweep_add(s, &f->p, 3 * g + i, dz);
      z[3 * g + i] += dz;
    }
  }
}

/* Ten sweeps at once, and twice five, against ten plain ones; all three modes occur. */
static void cones_equal_plain_ones(int contacts, double omega) {
  cones f;
  lcp_work work = {0};
  cones_open(&f, contacts);
  assert_true(lcp_cone_batches_prepare(&f.fast, &f.p));
  double *z = calloc(3 * (size_t)contacts, sizeof *z), *y = calloc(3 * (size_t)contacts, sizeof *y);
  assert_non_null(z);
  assert_non_null(y);
  lcp_sweep_refresh(&f.plain.sweep, &f.p, y, &work);
  for (int k = 0; k < 10; k++) {
    plain_cones(&f, omega, y);
  }
  for (int way = 0; way < 2; way++) {
    memset(z, 0, 3 * (size_t)contacts * sizeof *z);
    lcp_cone_batches_run(&f.fast, &f.p, omega, (way == 0) ? 10 : 5, z);
    if (way == 1) {
      lcp_cone_batches_run(&f.fast, &f.p, omega, 5, z);
    }
    int modes[3] = {0};
    for (int g = 0; g < contacts; g++) {
      const double *r = z + 3 * (ptrdiff_t)g, size = 1.0 + fabs(r[0]);
      for (int i = 0; i < 3; i++) {
        check_close(r[i], y[3 * g + i], 1e-11 * size);
      }
      const double slack = f.block[g].part_mu[0] * r[0] - hypot(r[1], r[2]);
      assert_true(slack >= -1e-15 * size);
      modes[(r[0] == 0.0) ? 0 : ((slack > 1e-9 * r[0]) ? 1 : 2)]++;
    }
    assert_true(contacts < 100 || (modes[0] > 5 && modes[1] > 5 && modes[2] > 5));
  }
  free(z);
  free(y);
  cones_close(&f);
}

static void cones_in_batches_sweep_as_one_by_one(void **state) {
  (void)state;
  cones_equal_plain_ones(1, 1.0);
  cones_equal_plain_ones(7, 1.0);
  cones_equal_plain_ones(41, 0.7);
  cones_equal_plain_ones(1001, 1.0);
}

/* Sweeps one behind the other, by crews of one to four, taken up before the contacts are ordered. */
static void cones_sweep_the_same_by_any_crew(void **state) {
  (void)state;
  enum { CONTACTS = 3001 };
  static double kept[3 * CONTACTS], z[3 * CONTACTS];
  for (int threads = 1; threads <= 4; threads++) {
    base_error err = {0};
    base_crew *crew;
    cones f;
    check_ok(base_crew_open(&crew, threads, &err), &err);
    (void)base_crew_take_up(crew);
    cones_open(&f, CONTACTS);
    assert_true(lcp_cone_batches_prepare(&f.fast, &f.p));
    assert_int_equal(f.fast.in.shared, threads > 1);
    memset(z, 0, sizeof z);
    for (int run = 1; run <= 20; run++) { /* of 1, 2, .. sweeps */
      lcp_cone_batches_run(&f.fast, &f.p, 0.9, run, z);
    }
    (void)base_crew_take_up(NULL);
    base_crew_close(crew);
    assert_true(threads == 1 || memcmp(kept, z, sizeof z) == 0);
    memcpy(kept, z, sizeof z);
    cones_close(&f);
  }
}

static void cones_of_another_form_are_refused(void **state) {
  (void)state;
  cones f;
  cones_open(&f, 12);
  double *jac = f.bed.memory + 36 * f.bed.n_body;
  assert_true(lcp_cone_batches_prepare(&f.fast, &f.p));
  f.block[3].part_mu[0] = 0.0;
  assert_false(lcp_cone_batches_prepare(&f.fast, &f.p));
  f.block[3].part_mu[0] = 0.3;
  f.block[5].set = LCP_FREE;
  assert_false(lcp_cone_batches_prepare(&f.fast, &f.p));
  f.block[5].set = LCP_CONE;
  jac[3] += 1e-10;
  assert_false(lcp_cone_batches_prepare(&f.fast, &f.p));
  jac[3] -= 1e-10;
  assert_true(lcp_cone_batches_prepare(&f.fast, &f.p));
  const int *body = f.p.M.factored->body + 2 * 2; /* contact 2: what turns without inertia only */
  double *W = f.bed.memory + 36 * (ptrdiff_t)((body[0] >= 0) ? body[0] : body[1]);
  for (int j = 3; j < 6; j++) {
    for (int i = 3; i < 6; i++) {
      W[i + 6 * j] *= 1e14;
    }
  }
  assert_false(lcp_cone_batches_prepare(&f.fast, &f.p));
  cones_close(&f);
}

static base_status solve_from(const lcp_problem *p, const char *name, const char *options,
                              double *z, lcp_result *res) {
  base_error err = {0};
  return try_solve(name, options, p, z, res, &err);
}

/* By the solver: solved, the judge agrees, every sweep is counted. */
static void solve_and_judge(const lcp_problem *p, const char *name, const char *options,
                            const char *variant) {
  double *z = calloc((size_t)p->M.n, sizeof *z);
  base_error err = {0};
  lcp_result res = {.outcome = LCP_NUMERICAL};
  lcp_verdict verdict;
  assert_non_null(z);
  assert_int_equal(solve_from(p, name, options, z, &res), BASE_OK);
  assert_string_equal(lcp_outcome_name(res.outcome), "ok");
  assert_string_equal(res.variant, variant);
  assert_int_equal(res.work.iterations, res.work.sweeps);
  assert_int_equal(res.work.iterations % 10, 0);
  assert_int_equal(res.work.fallbacks, 0);
  check_ok(lcp_judge(p, z, &verdict, &err), &err);
  check_close(verdict.rho, 0.0, 1e-9);
  free(z);
}

/* What `budget` sweeps leave is what a limit of as many leaves, to the bit; no product is spent on a test. */
static void spend(const lcp_problem *p, const char *name, const char *more, int budget) {
  double *z = calloc(2 * (size_t)p->M.n, sizeof *z), *y = z + p->M.n;
  char options[64];
  lcp_result res = {.outcome = LCP_NUMERICAL};
  assert_non_null(z);
  (void)snprintf(options, sizeof options, "budget=%d%s", budget, more);
  assert_int_equal(solve_from(p, name, options, z, &res), BASE_OK);
  assert_string_equal(lcp_outcome_name(res.outcome), "budget");
  assert_int_equal(res.work.sweeps, budget);
  assert_int_equal(res.work.matvecs, 0);
  (void)snprintf(options, sizeof options, "max_iter=%d,check_every=1000%s", budget, more);
  assert_int_equal(solve_from(p, name, options, y, &res), BASE_OK);
  assert_string_equal(lcp_outcome_name(res.outcome), "max_iter");
  assert_memory_equal(z, y, (size_t)p->M.n * sizeof *z);
  free(z);
}

static void a_budget_is_spent_untested(void **state) {
  (void)state;
  cones f;
  lcp_result res = {.outcome = LCP_NUMERICAL};
  double z[36] = {0};
  cones_open(&f, 200);
  spend(&f.p, "nsgs", "", 1);
  spend(&f.p, "nsgs", "", 7);
  spend(&f.p, "nsgs", ",omega=0.7", 13);
  spend(&f.bed.p, "pgs", "", 7);
  f.block[5].part_mu[0] = 0.0; /* another form: one by one */
  spend(&f.p, "nsgs", "", 7);
  cones_close(&f);
  cones_open(&f, 12);
  assert_int_equal(solve_from(&f.p, "nsgs", "budget=3,polish=on", z, &res), BASE_EUNSUPPORTED);
  cones_close(&f);
}

/* In batches, and one by one where mixing wants every sweep. */
static void nsgs_solves_the_bed_in_batches(void **state) {
  (void)state;
  cones f;
  cones_open(&f, 300);
  solve_and_judge(&f.p, "nsgs", "tol=1e-9", "batches");
  solve_and_judge(&f.p, "nsgs", "tol=1e-9,accelerate=anderson", "");
  cones_close(&f);
}

/* ---- facets ----------------------------------------------------------------------------------- */

/* The bed with m = K + 2 unknowns a contact: normal, K facets of length `unit`, slip speed in units of alpha. */
typedef struct facets {
  contact_bed bed;
  lcp_problem p;
  lcp_factored f;
  lcp_csc shift;
  lcp_block *block;
  double *jac, *q, *val;
  int *row_start, *jac_start, *colptr, *rowind;
  lcp_gs gs;
  lcp_facet_batches fast;
  void *memory;
} facets;

static void carve_facets(facets *f, base_arena *a) {
  const lcp_capacity cap = lcp_problem_capacity(&f->p);
  lcp_gs_layout(&f->gs, &cap, a);
  lcp_facet_batches_layout(&f->fast, &cap, a);
}

/* Rows of one side: (n, t1, t2), 3 x 6, to normal, facets and the empty row of sigma. */
static double *put_side(const double *from, int K, double unit, double *out) {
  for (int k = -1; k <= K; k++, out += 6) {
    const double angle = 2 * pi * k / K + 0.3, c = unit * cos(angle), s = unit * sin(angle);
    for (int i = 0; i < 6; i++) {
      out[i] = (k < 0) ? from[i] : (k < K) ? c * from[6 + i] + s * from[12 + i] : 0.0;
    }
  }
  return out;
}

static void put_shift(facets *f, int g, int K, double alpha, double mu) {
  const int first = f->row_start[g], last = first + K + 1;
  for (int k = 0; k <= K; k++) {
    const int at = f->colptr[first + k];
    f->rowind[at] = last;
    f->val[at] = (k == 0) ? alpha * mu : -alpha;
    f->colptr[first + k + 1] = at + 1;
  }
  for (int k = 0; k < K; k++) {
    f->rowind[f->colptr[last] + k] = first + 1 + k;
    f->val[f->colptr[last] + k] = alpha;
  }
  f->colptr[last + 1] = f->colptr[last] + K;
}

static void allocate_facets(facets *f, size_t contacts, size_t m) {
  f->block = calloc(contacts, sizeof *f->block);
  f->jac = calloc(12 * contacts * m, sizeof *f->jac);
  f->q = calloc(contacts * m, sizeof *f->q);
  f->val = calloc(2 * contacts * m, sizeof *f->val);
  f->row_start = calloc(contacts + 1, sizeof *f->row_start);
  f->jac_start = calloc(contacts + 1, sizeof *f->jac_start);
  f->colptr = calloc(contacts * m + 1, sizeof *f->colptr);
  f->rowind = calloc(2 * contacts * m, sizeof *f->rowind);
  assert_non_null(f->block);
  assert_non_null(f->jac);
  assert_non_null(f->q);
  assert_non_null(f->val);
  assert_non_null(f->row_start);
  assert_non_null(f->jac_start);
  assert_non_null(f->colptr);
  assert_non_null(f->rowind);
}

static void facets_open(facets *f, int contacts, int K) {
  const double unit = 1.1;
  base_error err = {0};
  f->bed = contact_bed_open(contacts, 3);
  assert_non_null(f->bed.memory);
  allocate_facets(f, (size_t)contacts, (size_t)K + 2);
  const lcp_factored *from = f->bed.p.M.factored;
  double *out = f->jac;
  for (int g = 0; g < contacts; g++) {
    const double *side = from->jac + from->jac_start[g], *q = f->bed.p.q + 3 * (ptrdiff_t)g;
    f->row_start[g + 1] = f->row_start[g] + K + 2;
    f->block[g] = (lcp_block){.start = f->row_start[g], .size = K + 2, .set = LCP_ORTHANT};
    for (int s = 0; s < 2; s++) {
      if (from->body[2 * g + s] >= 0) {
        out = put_side(side, K, unit, out);
        side += 18;
      }
    }
    f->jac_start[g + 1] = (int)(out - f->jac);
    for (int k = -1; k < K; k++) {
      const double angle = 2 * pi * k / K + 0.3;
      f->q[f->row_start[g] + 1 + k] =
          (k < 0) ? q[0] : unit * cos(angle) * q[1] + unit * sin(angle) * q[2];
    }
    put_shift(f, g, K, 0.5 + 0.01 * (g % 7), 0.05 + 0.1 * (g % 11));
  }
  const int n = f->row_start[contacts];
  f->shift = (lcp_csc){n, n, f->colptr, f->rowind, f->val};
  f->f = *from;
  f->f.row_start = f->row_start;
  f->f.jac_start = f->jac_start;
  f->f.jac = f->jac;
  f->f.shift = &f->shift;
  f->p = (lcp_problem){.M = {.storage = LCP_FACTORED, .n = n, .factored = &f->f},
                       .q = f->q,
                       .block = f->block,
                       .n_block = contacts};
  check_ok(lcp_problem_check(&f->p, &err), &err);
  base_arena a = base_arena_measuring();
  carve_facets(f, &a);
  f->memory = base_alloc(a.used);
  assert_non_null(f->memory);
  a = base_arena_over(f->memory, a.used);
  carve_facets(f, &a);
  check_ok(lcp_gs_prepare(&f->gs, &f->p, &err), &err);
}

static void facets_close(facets *f) {
  contact_bed_close(&f->bed);
  free(f->block);
  free(f->jac);
  free(f->q);
  free(f->val);
  free(f->row_start);
  free(f->jac_start);
  free(f->colptr);
  free(f->rowind);
  free(f->memory);
}

/* One sweep over the blocks in the order of the batches, each by Lemke's path. */
static void plain_blocks(facets *f, int K, double *z) {
  lcp_sweep *s = &f->gs.sweep;
  const int m = K + 2;
  for (int k = 0; k < LCP_LANES * f->fast.in.n_batch; k++) {
    const int g = f->fast.in.order[k], first = m * g;
    double M[18 * 18], q[18], x[18];
    if (g < 0) {
      continue;
    }
    lcp_sweep_block(s, &f->p, first, m, M);
    for (int i = 0; i < m; i++) {
      q[i] = lcp_sweep_row(s, &f->p, first + i);
      for (int j = 0; j < m; j++) {
        q[i] -= M[i + m * j] * z[first + j];
      }
    }
    assert_true(lemke_block_solve(&f->gs.lemke, m, M, q, x));
    for (int i = 0; i < m; i++) {
      lcp_sweep_add(s, &f->p, first + i, x[i] - z[first + i]);
      z[first + i] = x[i];
    }
  }
}

/* Normal impulse, friction and slip speed, which are unique where the facets' shares are not. */
static void impulse_of(const double *z, int K, double out[4]) {
  out[0] = z[0];
  out[1] = out[2] = 0.0;
  out[3] = z[K + 1];
  for (int k = 0; k < K; k++) {
    out[1] += cos(2 * pi * k / K) * z[1 + k];
    out[2] += sin(2 * pi * k / K) * z[1 + k];
  }
}

/* Ten sweeps at once, and twice five, against ten plain ones; contacts are open, stick and slip. */
static void facets_equal_plain_blocks(int contacts, int K) {
  facets f;
  lcp_work work = {0};
  facets_open(&f, contacts, K);
  assert_true(lcp_facet_batches_prepare(&f.fast, &f.gs, &f.p));
  const size_t n = (size_t)f.p.M.n;
  double *z = calloc(n, sizeof *z), *y = calloc(n, sizeof *y);
  assert_non_null(z);
  assert_non_null(y);
  lcp_sweep_refresh(&f.gs.sweep, &f.p, y, &work);
  for (int k = 0; k < 10; k++) {
    plain_blocks(&f, K, y);
  }
  for (int way = 0; way < 2; way++) {
    int modes[3] = {0};
    memset(z, 0, n * sizeof *z);
    lcp_facet_batches_run(&f.fast, &f.p, (way == 0) ? 10 : 5, z);
    if (way == 1) {
      lcp_facet_batches_run(&f.fast, &f.p, 5, z);
    }
    assert_int_equal(f.fast.rays, 0);
    for (int g = 0; g < contacts; g++) {
      double got[4], want[4];
      impulse_of(z + (ptrdiff_t)(K + 2) * g, K, got);
      impulse_of(y + (ptrdiff_t)(K + 2) * g, K, want);
      for (int i = 0; i < 4; i++) {
        check_close(got[i], want[i], 1e-11 * (1.0 + fabs(want[0])));
      }
      for (int i = 0; i < K + 2; i++) {
        assert_true(z[(K + 2) * g + i] >= 0.0);
      }
      modes[(got[0] == 0.0) ? 0 : (got[3] == 0.0) ? 1 : 2]++;
    }
    assert_true(contacts < 100 || (modes[0] > 5 && modes[1] > 5 && modes[2] > 5));
  }
  free(z);
  free(y);
  facets_close(&f);
}

static void facets_in_batches_sweep_as_blocks_do(void **state) {
  (void)state;
  facets_equal_plain_blocks(1, 4);
  facets_equal_plain_blocks(41, 3);
  facets_equal_plain_blocks(41, 16);
  facets_equal_plain_blocks(301, 5);
  facets_equal_plain_blocks(1001, 4);
}

static void facets_of_another_form_are_refused(void **state) {
  (void)state;
  facets f;
  facets_open(&f, 12, 4);
  double *const changed[] = {&f.jac[3], &f.jac[6 * 3 + 1], &f.jac[6 * 5], &f.q[3],
                             &f.q[5],   &f.val[2],         &f.val[6]};
  assert_true(lcp_facet_batches_prepare(&f.fast, &f.gs, &f.p));
  for (int i = 0; i < BASE_COUNT(changed); i++) {
    const double before = *changed[i];
    *changed[i] += 1e-3;
    assert_false(lcp_facet_batches_prepare(&f.fast, &f.gs, &f.p));
    *changed[i] = before;
  }
  assert_true(lcp_facet_batches_prepare(&f.fast, &f.gs, &f.p));
  f.block[3].set = LCP_FREE;
  assert_false(lcp_facet_batches_prepare(&f.fast, &f.gs, &f.p));
  facets_close(&f);
}

/* In batches; relaxed, block by block. */
static void pgs_solves_facets_in_batches(void **state) {
  (void)state;
  facets f;
  facets_open(&f, 300, 4);
  solve_and_judge(&f.p, "pgs", "tol=1e-9", "batches");
  solve_and_judge(&f.p, "pgs", "tol=1e-9,omega=0.95", "block");
  facets_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cones_in_batches_sweep_as_one_by_one),
      cmocka_unit_test(cones_sweep_the_same_by_any_crew),
      cmocka_unit_test(cones_of_another_form_are_refused),
      cmocka_unit_test(nsgs_solves_the_bed_in_batches),
      cmocka_unit_test(a_budget_is_spent_untested),
      cmocka_unit_test(facets_in_batches_sweep_as_blocks_do),
      cmocka_unit_test(facets_of_another_form_are_refused),
      cmocka_unit_test(pgs_solves_facets_in_batches),
  };
  return cmocka_run_group_tests_name("batches", tests, NULL, NULL);
}
