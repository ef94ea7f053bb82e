/* ablate_lemke.c - what scripts/ablate_lemke runs: lemke on small problems (beside the plain tableau), on the contact LCPs,
 * on many contacts of few bodies, on the problems that were hard once, on random ones, on the cases with known answers, on the
 * LCPs of another code and in the first 40 steps of four scenes.
 *
 * usage: ablate_lemke [REPETITIONS [GROUP...]]
 * Groups: small contact large bodies parallel hard random cases data scenes, all by default, and ramp, which takes long; large are contact LCPs of
 * 1000 unknowns, dense matrices of 300 and more and a wall of 60 bricks. CSV on stdout, one row per item: CPU seconds are the median of the
 * repetitions, those of a scene count what its solver took. After every row ablate_mark() is called: there callgrind dumps the instructions of
 * lcp_instance_prepare, lcp_instance_solve and tableau_lemke. */
#include "harness/measure/registry.h"
#include "harness/measure/series.h"
#include "harness/measure/simulate.h"
#include "lcp/base/clock.h"
#include "lcp/base/rng.h"
#include "lcp/io/lcp_read.h"
#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"
#include "problems/families/family.h"
#include "problems/read/case_file.h"
#include "problems/read/scene_file.h"
#include "tests/support/few_bodies.h"
#include "tests/support/files.h"
#include "tests/support/tableau_lemke.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REPS_MAX = 101, N_MOST = 1000, STEPS = 40, LARGE_STEPS = 4, RAMP_STEPS = 2, ROWS = 64 };

void ablate_mark(void);
__attribute__((noinline)) void ablate_mark(void) {
  __asm__ volatile("");
}

static int compare(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static void print_row(const char *group, const char *name, const char *method, bool right,
                      const char *outcome, const lcp_work *w, const char *variant, double rho,
                      double *seconds, int reps) {
  qsort(seconds, (size_t)reps, sizeof *seconds, compare);
  printf("%s,\"%s\",%s,%d,%s,%ld,%ld,%ld,%ld,%s,%.1e,%.9f\n", group, name, method, right, outcome,
         w->pivots, w->factorizations, w->refinements, w->fallbacks, variant, rho,
         seconds[reps / 2]);
  (void)fflush(stdout);
  ablate_mark();
}

/* Right is a verified solution or a proof of infeasibility, as which a ray counts where M is semidefinite (Cottle, Pang & Stone
 * 1992, theorem 4.4.12); of a case without either, what it calls an honest end. */
static bool is_right(const lcp_problem *p, const lcp_case *c, lcp_outcome outcome,
                     lcp_certificate_kind proof, double rho) {
  switch (outcome) {
  case LCP_SOLVED:
    return rho <= LCP_VERIFY_EXACT;
  case LCP_INFEASIBLE:
    return proof == LCP_CERT_FARKAS;
  case LCP_RAY:
    return (c == NULL) ? (p->traits & LCP_PSD) != 0
                       : ((c->correct | c->honest_failure) & CASE_UNSOLVED_RAY) != 0;
  default:
    return c != NULL && ((c->correct | c->honest_failure) & CASE_NOT_CONVERGED) != 0;
  }
}

/* Cold, `reps` times, each from set-up on. known: what a case file knows of the problem, or NULL. */
static base_status run_lemke(const char *group, const char *name, const lcp_problem *p,
                             const lcp_case *known, int reps, base_error *err) {
  solver_choice c;
  lcp_instance *k = NULL;
  lcp_result res;
  lcp_verdict v;
  double seconds[REPS_MAX];
  const lcp_capacity cap = lcp_problem_capacity(p);
  double *z = calloc((size_t)p->M.n + 1, sizeof *z);
  if (z == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s", name);
  }
  base_status s = solver_choose("lemke", &c, err);
  if (s == BASE_OK) {
    s = lcp_instance_open(&k, c.solver, &cap, c.opt, err);
  }
  for (int r = 0; r < reps && s == BASE_OK; ++r) {
    const double started = base_cpu_seconds();
    memset(z, 0, sizeof *z * (size_t)p->M.n);
    s = lcp_instance_prepare(k, p, err);
    s = (s == BASE_OK) ? lcp_instance_solve(k, NULL, z, &res, err) : s;
    seconds[r] = base_cpu_seconds() - started;
  }
  s = (s == BASE_OK) ? lcp_judge(p, z, &v, err) : s;
  if (s == BASE_OK) {
    const bool right = is_right(p, known, res.outcome, res.certificate.kind, v.rho);
    print_row(group, name, "lemke", right, lcp_outcome_name(res.outcome), &res.work, res.variant,
              v.rho, seconds, reps);
  }
  lcp_instance_close(k);
  solver_choice_free(&c);
  free(z);
  return s;
}

static base_status run_tableau(const char *group, const char *name, const lcp_problem *p, int reps,
                               base_error *err) {
  const size_t n = (size_t)p->M.n;
  double seconds[REPS_MAX];
  double *M = calloc(n * n + 1, sizeof *M);
  double *work = calloc(tableau_lemke_work(p->M.n) + 1, sizeof *work);
  double *z = calloc(n + 1, sizeof *z);
  lcp_verdict v;
  lcp_work count = {0};
  lcp_outcome out = LCP_NUMERICAL;
  base_status s = BASE_OK;
  if (M == NULL || work == NULL || z == NULL) {
    s = BASE_FAIL(err, BASE_ENOMEM, "%s", name);
  } else {
    lcp_matrix_to_dense(&p->M, M);
    for (int r = 0; r < reps; ++r) {
      const double started = base_cpu_seconds();
      out = tableau_lemke(p->M.n, M, p->q, z, work, &count.pivots);
      seconds[r] = base_cpu_seconds() - started;
    }
    s = lcp_judge(p, z, &v, err);
  }
  if (s == BASE_OK) {
    print_row(group, name, "tableau", out == LCP_SOLVED && v.rho <= 1e-9, lcp_outcome_name(out),
              &count, "", v.rho, seconds, reps);
  }
  free(M);
  free(work);
  free(z);
  return s;
}

static base_status run_pair(const char *folder, const char *group, const char *name, bool tableau,
                            int reps, base_error *err) {
  char m_name[160];
  char q_name[160];
  lcp_file_problem f;
  (void)snprintf(m_name, sizeof m_name, "cases/%s/%s.M.mtx", folder, name);
  (void)snprintf(q_name, sizeof q_name, "cases/%s/%s.q.mtx", folder, name);
  BASE_TRY(lcp_read_mtx(tests_file(m_name), tests_file(q_name), &f, err));
  base_status s = run_lemke(group, name, &f.p, NULL, reps, err);
  if (s == BASE_OK && tableau) {
    s = run_tableau(group, name, &f.p, reps, err);
  }
  lcp_file_problem_free(&f);
  return s;
}

static base_status run_family(const char *group, const char *text, bool tableau, int reps,
                              base_error *err) {
  known_lcp k;
  BASE_TRY(lcp_family_load(text, &k, err));
  base_status s = run_lemke(group, text, &k.p, NULL, reps, err);
  if (s == BASE_OK && tableau) {
    s = run_tableau(group, text, &k.p, reps, err);
  }
  known_lcp_free(&k);
  return s;
}

static base_status run_scene(const char *group, const char *text, int steps, int reps,
                             base_error *err) {
  scene_spec spec;
  formulation_choice f;
  solver_choice c;
  sim_result r = {0};
  double seconds[REPS_MAX];
  BASE_TRY(scene_load(text, &spec, err));
  base_status s = formulation_choose("velocity", &f, err);
  s = (s == BASE_OK) ? solver_choose("lemke", &c, err) : s;
  for (int k = 0; k < reps && s == BASE_OK; ++k) {
    series record = {0};
    const sim_request q = {.spec = &spec,
                           .effects = spec.effects,
                           .form = &f,
                           .solver = &c,
                           .h = spec.h[0],
                           .duration = fmin(spec.duration, steps * spec.h[0])};
    s = simulate(&q, &record, &r, err);
    seconds[k] = r.time.setup + r.time.solve;
    series_close(&record);
  }
  if (s == BASE_OK) {
    r.work.fallbacks += r.n_fallbacks;
    print_row(group, text, "lemke", r.verified, run_status_name(r.status), &r.work, r.variant,
              r.rho_max, seconds, reps);
  }
  formulation_choice_free(&f);
  solver_choice_free(&c);
  spec_free(&spec);
  return s;
}

static base_status small(int reps, base_error *err) {
  static const char *const family[] = {"stack:n=6",     "stack:n=20",     "stack:n=60",
                                       "box_stack:n=2", "random_spd:n=6", "random_spd:n=40"};
  static const char *const file[] = {"column_n10", "column_n30", "boxstack_n12", "boxstack_n32",
                                     "fbox4_p4",   "fbox8_p4",   "frand4_p5",    "frand8_p5",
                                     "pd_n10",     "pd_n30"};
  for (int i = 0; i < BASE_COUNT(family); ++i) {
    BASE_TRY(run_family("small", family[i], true, reps, err));
  }
  for (int i = 0; i < BASE_COUNT(file); ++i) {
    BASE_TRY(run_pair("contact_lcps", "small", file[i], true, reps, err));
  }
  return BASE_OK;
}

static base_status contact(int reps, base_error *err) {
  static const char *const file[] = {
      "boxstack_n12", "boxstack_n32", "boxstack_n100", "boxstack_n300", "column_n10", "column_n30",
      "column_n100",  "column_n300",  "fbox4_p4",      "fbox4_p20",     "fbox4_p80",  "fbox8_p4",
      "fbox8_p20",    "frand4_p5",    "frand4_p20",    "frand4_p80",    "frand8_p5",  "frand8_p20",
      "pd_n10",       "pd_n30",       "pd_n100",       "pd_n300"};
  for (int i = 0; i < BASE_COUNT(file); ++i) {
    BASE_TRY(run_pair("contact_lcps", "contact", file[i], false, reps, err));
  }
  return BASE_OK;
}

static base_status large(int reps, base_error *err) {
  static const char *const file[] = {"boxstack_n1000", "column_n1000", "fbox4_p200"};
  static const char *const family[] = {"random_psd:n=400", "random_p:n=300"};
  for (int i = 0; i < BASE_COUNT(file); ++i) {
    BASE_TRY(run_pair("contact_lcps", "large", file[i], false, reps, err));
  }
  for (int i = 0; i < BASE_COUNT(family); ++i) {
    BASE_TRY(run_family("large", family[i], false, reps, err));
  }
  return run_scene("large", "wall:rows=8,columns=8", LARGE_STEPS, reps, err);
}

static base_status hard(int reps, base_error *err) {
  static const char *const file[] = {
      "infeasible_ray_1195", "scaled10_1616", "scaled10_4069", "scaled10_4410", "scaled10_4428",
      "scaled10_5400",       "scaled_1105",   "scaled_1864",   "scaled_1904",   "scaled_2038",
      "scaled_2388",         "scaled_2782",   "scaled_3099",   "scaled_3798",   "scaled_4420",
      "scaled_4578",         "scaled_4831",   "scaled_5145",   "scaled_5636",   "slider_step17"};
  static const char *const family[] = {
      "subset_sum:n=4,largest=9", "kostreva:variant=2", "murty:n=10", "fathi:n=10",
      "random_copositive:n=40",   "random_psd:n=60"};
  for (int i = 0; i < BASE_COUNT(file); ++i) {
    BASE_TRY(run_pair("regressions/lcp", "hard", file[i], false, reps, err));
  }
  for (int i = 0; i < BASE_COUNT(family); ++i) {
    BASE_TRY(run_family("hard", family[i], false, reps, err));
  }
  return BASE_OK;
}

/* Contacts parallel up to 1e-9 or 1e-12, of which some problem was lost to every pair of tolerances. */
static base_status parallel(int reps, base_error *err) {
  static const char *const file[] = {"masses_239", "parallel_89"};
  for (int i = 0; i < BASE_COUNT(file); ++i) {
    BASE_TRY(run_pair("regressions/lcp", "parallel", file[i], false, reps, err));
  }
  return BASE_OK;
}

/* ---- random problems --------------------------------------------------------------------------------------------- */

typedef enum kind { GENERAL, SPARSE, PSD, SKEW, PARALLEL, SCALED, N_KIND } kind;

/* M = A diag(d) A' of random rank, with one thing that makes it hard, or any matrix; integers where `whole`, so that ties and
 * singular bases are exact. q: any, or that of a degenerate solution. */
typedef struct random_lcp {
  double M[ROWS * ROWS], q[ROWS];
  lcp_block block[2];
  lcp_problem p;
} random_lcp;

static double drawn(base_rng *g, bool whole, double most) {
  const double v = base_rng_between(g, -most, most);
  return whole ? round(v) : v;
}

static void product(base_rng *g, kind of, bool whole, int n, double *M) {
  static double A[ROWS * ROWS];
  const int rank = 1 + (int)(base_rng_uniform(g) * n);
  const double apart = pow(10, base_rng_between(g, -15, -3));
  memset(M, 0, sizeof *M * (size_t)(n * n));
  for (int k = 0; k < rank; ++k) {
    const double d = (of == SCALED) ? pow(10, base_rng_between(g, -4, 4)) : 1;
    for (int i = 0; i < n; ++i) {
      const bool copy = of == PARALLEL && i % 2 == 1;
      A[i] = copy ? A[i - 1] + apart * base_rng_between(g, -1, 1) : drawn(g, whole, 2);
    }
    for (int i = 0; i < n * n; ++i) {
      M[i] += d * A[i % n] * A[i / n];
    }
  }
}

static void draw(uint64_t seed, random_lcp *r) {
  base_rng g = base_rng_seeded(seed);
  const kind of = (kind)(seed % N_KIND);
  const bool whole = seed / N_KIND % 2 == 0;
  const bool solvable = seed / (2 * N_KIND) % 3 != 0;
  const int n = 2 + (int)(base_rng_uniform(&g) * (ROWS - 2));
  const int free_rows = (seed / (6 * N_KIND) % 2 == 0) ? 0 : n / 3;
  double z[ROWS];
  product(&g, of, whole, n, r->M);
  for (int i = 0; i < n * n && (of == GENERAL || of == SPARSE); ++i) {
    const double v = drawn(&g, whole, 3);
    r->M[i] = (of == GENERAL || fabs(v) > 1.5) ? v : 0;
  }
  for (int i = 0; i < n * n && of == SKEW; ++i) {
    if (i % n < i / n) {
      const double v = drawn(&g, whole, 1);
      r->M[i] += v;
      r->M[i % n * n + i / n] -= v;
    }
  }
  for (int i = 0; i < n; ++i) {
    r->q[i] = drawn(&g, whole, 2);
    z[i] = drawn(&g, whole, 3);
    z[i] = (solvable && (z[i] > 0 || i < free_rows)) ? z[i] : 0;
    r->q[i] = (solvable && (z[i] > 0 || i < free_rows || r->q[i] < 0)) ? 0 : r->q[i];
  }
  for (int i = 0; i < n * n; ++i) {
    r->q[i % n] -= r->M[i] * z[i / n];
  }
  r->block[0] = (lcp_block){.start = 0, .size = free_rows, .set = LCP_FREE};
  r->block[1] = (lcp_block){.start = free_rows, .size = n - free_rows, .set = LCP_ORTHANT};
  r->p = (lcp_problem){.M = {.storage = LCP_DENSE, .n = n, .val = r->M},
                       .q = r->q,
                       .block = r->block + (free_rows == 0),
                       .n_block = 1 + (free_rows > 0),
                       .traits = (of == PSD || of == PARALLEL) ? LCP_SYMMETRIC | LCP_PSD : 0};
}

/* Found among 24,000 as those that some mechanism alone solves, or solves in less. */
static base_status random_ones(int reps, base_error *err) {
  static const int seed[] = {0,    7,    18,   49,   61,   110,   412,   619,   988,   1354, 2206,
                             3586, 4282, 5584, 5644, 6122, 13414, 16006, 19190, 19246, 21566};
  static random_lcp r;
  for (int i = 0; i < BASE_COUNT(seed); ++i) {
    char name[32];
    (void)snprintf(name, sizeof name, "seed %d", seed[i]);
    draw((uint64_t)seed[i], &r);
    BASE_TRY(lcp_problem_check(&r.p, err));
    BASE_TRY(run_lemke("random", name, &r.p, NULL, reps, err));
  }
  return BASE_OK;
}

/* In the factored form, which is where sifting is. */
static base_status bodies(int reps, base_error *err) {
  static const struct {
    const char *name;
    int bodies, contacts, facets;
  } item[] = {{"1 body, 400 contacts", 1, 400, 0},
              {"1 body, 100 contacts, 4 facets", 1, 100, 4},
              {"20 bodies, 500 contacts", 20, 500, 0},
              {"8 bodies, 80 contacts, 4 facets", 8, 80, 4}};
  for (int i = 0; i < BASE_COUNT(item); ++i) {
    known_lcp k;
    BASE_TRY(few_bodies(&k, item[i].bodies, item[i].contacts, item[i].facets, 1, err));
    const base_status s = run_lemke("bodies", item[i].name, &k.p, NULL, reps, err);
    known_lcp_free(&k);
    BASE_TRY(s);
  }
  return BASE_OK;
}

/* Group A of the case file, without the problems that are to be refused, and without the largest two: column_n1000 is of
 * their kind. */
static base_status cases(int reps, base_error *err) {
  case_file f;
  BASE_TRY(case_file_read(tests_file("cases/cases.json"), &f, err));
  base_status s = BASE_OK;
  for (int i = 0; i < f.n_lcp && s == BASE_OK; ++i) {
    const lcp_case *c = &f.lcp[i];
    if (c->id[0] == 'A' && c->shape_error[0] == '\0' && c->n <= N_MOST &&
        lcp_problem_check(&c->k.p, NULL) == BASE_OK) {
      s = run_lemke("cases", c->id, &c->k.p, c, reps, err);
    }
  }
  case_file_free(&f);
  return s;
}

/* LCPs of another code. */
static base_status data(int reps, base_error *err) {
  static const char *const file[] = {"lcp_CPS_1",     "lcp_CPS_2",
                                     "lcp_CPS_3",     "lcp_Pang_isolated_sol",
                                     "lcp_exp_murty", "lcp_inf_sol_perturbed",
                                     "lcp_mmc",       "lcp_ortiz",
                                     "lcp_tobenna",   "lcp_trivial"};
  for (int i = 0; i < BASE_COUNT(file); ++i) {
    char name[64];
    lcp_file_problem f;
    (void)snprintf(name, sizeof name, "data/lcp/%s.dat", file[i]);
    BASE_TRY(lcp_read_siconos(tests_file(name), &f, err));
    const base_status s = run_lemke("data", file[i], &f.p, NULL, reps, err);
    lcp_file_problem_free(&f);
    BASE_TRY(s);
  }
  return BASE_OK;
}

static base_status run_scenes(int reps, base_error *err) {
  static const char *const name[] = {"stack", "wall", "walking_foot", "gripper"};
  for (int i = 0; i < BASE_COUNT(name); ++i) {
    BASE_TRY(run_scene("scenes", name[i], STEPS, reps, err));
  }
  return BASE_OK;
}

/* 1600 contacts, in the step after a load came up. */
static base_status ramp(int reps, base_error *err) {
  return run_scene("ramp", tests_file("cases/regressions/scenes/pyramid_ramp.json"), RAMP_STEPS,
                   reps, err);
}

static bool asked(int argc, char **argv, const char *group) {
  bool found = argc <= 2 && strcmp(group, "ramp") != 0;
  for (int i = 2; i < argc; ++i) {
    found = found || strcmp(argv[i], group) == 0;
  }
  return found;
}

int main(int argc, char **argv) {
  static const struct {
    const char *name;
    base_status (*run)(int reps, base_error *err);
  } group[] = {{"small", small},        {"contact", contact},   {"large", large},
               {"bodies", bodies},      {"parallel", parallel}, {"hard", hard},
               {"random", random_ones}, {"cases", cases},       {"data", data},
               {"scenes", run_scenes},  {"ramp", ramp}};
  int reps = 1;
  base_error err = {0};
  if ((argc > 1 && !base_parse_int(argv[1], &reps)) || reps < 1 || reps > REPS_MAX) {
    fprintf(stderr, "usage: ablate_lemke [REPETITIONS, 1 to %d [GROUP...]]\n", (int)REPS_MAX);
    return 2;
  }
  printf("group,item,method,right,outcome,pivots,factorizations,refinements,fallbacks,variant,rho,"
         "cpu_s\n");
  base_status s = BASE_OK;
  for (int g = 0; g < BASE_COUNT(group) && s == BASE_OK; ++g) {
    s = asked(argc, argv, group[g].name) ? group[g].run(reps, &err) : BASE_OK;
  }
  if (s != BASE_OK) {
    fprintf(stderr, "ablate_lemke: %s\n", err.text);
  }
  return s != BASE_OK;
}
