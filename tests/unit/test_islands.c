/* Problems that fall into parts: what is found, cut out, solved side by side and put together again. */
#include "tests/support/check.h"

#include "lcp/base/crew.h"
#include "lcp/base/rng.h"
#include "lcp/lcp_certificate.h"
#include "lcp/lcp_islands.h"
#include "lcp/lcp_judge.h"

#include <string.h>

enum { PARTS = 5, SIZE = 4, N = PARTS * SIZE };

/* PARTS positive definite problems of SIZE rows, whose rows are shuffled among each other. */
typedef struct mixed {
  double M[N * N], q[N];
  int part[N];
  lcp_problem p;
} mixed;

static void shuffle(base_rng *r, mixed *m) {
  for (int i = 0; i < N; i++) {
    m->part[i] = i % PARTS;
  }
  for (int i = N - 1; i > 0; i--) {
    const int k = (int)(base_rng_uniform(r) * (i + 1)), own = m->part[i];
    m->part[i] = m->part[k];
    m->part[k] = own;
  }
}

static void draw(mixed *m, uint64_t seed) {
  base_rng r = base_rng_seeded(seed);
  double G[N * N];
  memset(m, 0, sizeof *m);
  shuffle(&r, m);
  for (int i = 0; i < N * N; i++) {
    G[i] = base_rng_normal(&r);
  }
  for (int j = 0; j < N; j++) {
    m->q[j] = base_rng_normal(&r);
    for (int i = 0; i < N; i++) {
      for (int l = 0; l < N && m->part[i] == m->part[j]; l++) {
        m->M[i + j * N] += (m->part[l] == m->part[i]) ? G[i + l * N] * G[j + l * N] : 0;
      }
      m->M[i + j * N] += (i == j) ? 0.5 : 0;
    }
  }
  m->p = (lcp_problem){.M = {.storage = LCP_DENSE, .n = N, .val = m->M},
                       .q = m->q,
                       .traits = LCP_SYMMETRIC | LCP_PSD | LCP_PD};
}

/* With `threads`; the answer's word. */
static lcp_outcome solve(const lcp_problem *p, const char *name, int threads, int count, double *z,
                         lcp_islands **kept, lcp_result *res) {
  static _Alignas(16) unsigned char opt[2048];
  const lcp_solver *s = lcp_solver_find(name);
  base_error err = {0};
  assert_true(s->options_size <= sizeof opt);
  base_fields_default(s->fields, s->n_fields, opt);
  memset(z, 0, (size_t)p->M.n * sizeof *z);
  base_crew *crew;
  check_ok(base_crew_open(&crew, threads, &err), &err);
  assert_null(base_crew_take_up(crew));
  check_ok(lcp_islands_open(kept, s, opt, &err), &err);
  check_ok(lcp_islands_solve(*kept, p, z, res, &err), &err);
  assert_ptr_equal(base_crew_take_up(NULL), crew);
  base_crew_close(crew);
  assert_int_equal(lcp_islands_count(*kept), count);
  return res->outcome;
}

static void check_parts(const lcp_problem *p, const char *name, int threads, double *z) {
  lcp_islands *s;
  lcp_result res;
  lcp_verdict v;
  base_error err = {0};
  assert_int_equal(solve(p, name, threads, PARTS, z, &s, &res), LCP_SOLVED);
  assert_int_equal(lcp_islands_largest(s), SIZE);
  check_ok(lcp_judge(p, z, &v, &err), &err);
  assert_true(v.rho <= 1e-7);
  if (res.certificate.kind == LCP_CERT_BASIS) {
    lcp_certificate_verdict holds;
    check_ok(lcp_certificate_verify(p, &res.certificate, z, &holds, &err), &err);
    assert_true(holds.holds);
  }
  lcp_islands_close(s);
}

static void parts_are_found_and_put_together(void **state) {
  (void)state;
  static const char *const names[] = {"lemke", "ppm", "newton", "pgs"};
  for (uint64_t seed = 1; seed <= 20; seed++) {
    mixed m;
    lcp_csc csc;
    base_error err = {0};
    draw(&m, seed);
    check_ok(lcp_matrix_to_csc(&m.p.M, &csc, &err), &err);
    lcp_problem sparse = m.p;
    sparse.M = (lcp_matrix){.storage = LCP_CSC, .n = N, .csc = csc};
    for (int k = 0; k < BASE_COUNT(names); k++) {
      double z[2][N];
      check_parts(&m.p, names[k], 1, z[0]);
      check_parts(&sparse, names[k], 2, z[1]);
      for (int i = 0; i < N; i++) {
        check_close(z[0][i], z[1][i], 1e-6);
      }
    }
    lcp_csc_free(&csc);
  }
}

/* One part has no feasible point: the proof, made of that part alone, is one of the whole. */
static void a_part_without_an_answer_is_proved_for_the_whole(void **state) {
  (void)state;
  for (int bad = 0; bad < PARTS; bad++) {
    mixed m;
    lcp_islands *s;
    lcp_result res;
    lcp_certificate_verdict holds;
    base_error err = {0};
    double z[N];
    draw(&m, 77);
    int last = -1;
    for (int i = 0; i < N;
         i++) { /* rows of zeros but for neighbours that tie the part: w = -z_next + .. */
      if (m.part[i] != bad) {
        continue;
      }
      for (int j = 0; j < N; j++) {
        m.M[i + j * N] = m.M[j + i * N] = 0;
      }
      m.q[i] = -1;
      last = i;
    }
    for (int i = 0; i < N; i++) { /* coupled by entries that only take away */
      if (m.part[i] == bad && i != last) {
        m.M[i + last * N] = m.M[last + i * N] = -1;
      }
    }
    m.p.traits = 0;
    assert_int_equal(solve(&m.p, "lemke", 2, PARTS, z, &s, &res), LCP_INFEASIBLE);
    assert_int_equal(res.certificate.kind, LCP_CERT_FARKAS);
    check_ok(lcp_certificate_verify(&m.p, &res.certificate, z, &holds, &err), &err);
    assert_true(holds.holds && holds.exact);
    for (int i = 0; i < N; i++) {
      assert_true(m.part[i] == bad || res.certificate.vector[i] == 0);
    }
    lcp_islands_close(s);
  }
}

/* Blocks hold their rows together, whatever M says. */
static void a_block_is_never_cut(void **state) {
  (void)state;
  double M[36] = {0}, q[6] = {-1, 0.2, 0.1, -1, -0.3, 0.2}, z[6];
  const lcp_block block[] = {
      {.start = 0, .size = 3, .set = LCP_CONE, .n_part = 1, .part_dim = {2}, .part_mu = {0.5}},
      {.start = 3, .size = 3, .set = LCP_CONE, .n_part = 1, .part_dim = {2}, .part_mu = {0.5}}};
  for (int i = 0; i < 6; i++) {
    M[7 * i] = 1;
  }
  const lcp_problem p = {.M = {.storage = LCP_DENSE, .n = 6, .val = M},
                         .q = q,
                         .block = block,
                         .n_block = 2,
                         .traits = LCP_SYMMETRIC | LCP_PSD | LCP_PD};
  lcp_islands *s;
  lcp_result res;
  lcp_verdict v;
  base_error err = {0};
  assert_int_equal(solve(&p, "cone_newton", 4, 2, z, &s, &res), LCP_SOLVED);
  check_ok(lcp_judge(&p, z, &v, &err), &err);
  assert_true(v.rho <= 1e-9);
  lcp_islands_close(s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(parts_are_found_and_put_together),
      cmocka_unit_test(a_part_without_an_answer_is_proved_for_the_whole),
      cmocka_unit_test(a_block_is_never_cut),
  };
  return cmocka_run_group_tests_name("islands", tests, NULL, NULL);
}
