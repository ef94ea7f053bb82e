/* ablate_lemke.c - what scripts/ablate_lemke runs: lemke on small problems (beside the plain tableau), on the contact LCPs,
 * on the problems that were hard once, and in four scenes.
 *
 * usage: ablate_lemke CASES [REPETITIONS [GROUP...]]
 * CASES is tests/cases; groups: small contact hard scenes, all by default. CSV on stdout, one row per item: CPU seconds are
 * the median of the repetitions, those of a scene count what its solver took. After every row ablate_mark() is called: there
 * callgrind dumps the instructions of lcp_instance_prepare, lcp_instance_solve and tableau_lemke. */
#include "harness/measure/registry.h"
#include "harness/measure/series.h"
#include "harness/measure/simulate.h"
#include "lcp/base/clock.h"
#include "lcp/io/lcp_read.h"
#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"
#include "problems/families/family.h"
#include "problems/read/scene_file.h"
#include "tests/support/tableau_lemke.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REPS_MAX = 101 };

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
  printf("%s,%s,%s,%d,%s,%ld,%ld,%ld,%ld,%s,%.1e,%.9f\n", group, name, method, right, outcome,
         w->pivots, w->factorizations, w->refinements, w->fallbacks, variant, rho,
         seconds[reps / 2]);
  (void)fflush(stdout);
  ablate_mark();
}

/* Cold, `reps` times, each from set-up on. Right is a verified solution or a proof of infeasibility. */
static base_status run_lemke(const char *group, const char *name, const lcp_problem *p, int reps,
                             base_error *err) {
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
    const bool right = (res.outcome == LCP_SOLVED && v.rho <= 1e-9) ||
                       (res.outcome == LCP_INFEASIBLE && res.certificate.kind == LCP_CERT_FARKAS);
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

static base_status run_pair(const char *cases, const char *folder, const char *group,
                            const char *name, bool tableau, int reps, base_error *err) {
  char m_path[1024];
  char q_path[1024];
  lcp_file_problem f;
  (void)snprintf(m_path, sizeof m_path, "%s/%s/%s.M.mtx", cases, folder, name);
  (void)snprintf(q_path, sizeof q_path, "%s/%s/%s.q.mtx", cases, folder, name);
  BASE_TRY(lcp_read_mtx(m_path, q_path, &f, err));
  base_status s = run_lemke(group, name, &f.p, reps, err);
  if (s == BASE_OK && tableau) {
    s = run_tableau(group, name, &f.p, reps, err);
  }
  lcp_file_problem_free(&f);
  return s;
}

static base_status run_family(const char *text, int reps, base_error *err) {
  known_lcp k;
  BASE_TRY(lcp_family_load(text, &k, err));
  base_status s = run_lemke("small", text, &k.p, reps, err);
  if (s == BASE_OK) {
    s = run_tableau("small", text, &k.p, reps, err);
  }
  known_lcp_free(&k);
  return s;
}

static base_status small(const char *cases, int reps, base_error *err) {
  static const char *const family[] = {"stack:n=6",     "stack:n=20",     "stack:n=60",
                                       "box_stack:n=2", "random_spd:n=6", "random_spd:n=40"};
  static const char *const file[] = {"column_n10", "column_n30", "boxstack_n12", "boxstack_n32",
                                     "fbox4_p4",   "fbox8_p4",   "frand4_p5",    "frand8_p5",
                                     "pd_n10",     "pd_n30"};
  for (int i = 0; i < BASE_COUNT(family); ++i) {
    BASE_TRY(run_family(family[i], reps, err));
  }
  for (int i = 0; i < BASE_COUNT(file); ++i) {
    BASE_TRY(run_pair(cases, "contact_lcps", "small", file[i], true, reps, err));
  }
  return BASE_OK;
}

static base_status contact(const char *cases, int reps, base_error *err) {
  static const char *const file[] = {
      "boxstack_n12", "boxstack_n32", "boxstack_n100", "boxstack_n300", "boxstack_n1000",
      "column_n10",   "column_n30",   "column_n100",   "column_n300",   "column_n1000",
      "fbox4_p4",     "fbox4_p20",    "fbox4_p80",     "fbox4_p200",    "fbox8_p4",
      "fbox8_p20",    "frand4_p5",    "frand4_p20",    "frand4_p80",    "frand8_p5",
      "frand8_p20",   "pd_n10",       "pd_n30",        "pd_n100",       "pd_n300"};
  for (int i = 0; i < BASE_COUNT(file); ++i) {
    BASE_TRY(run_pair(cases, "contact_lcps", "contact", file[i], false, reps, err));
  }
  return BASE_OK;
}

static base_status hard(const char *cases, int reps, base_error *err) {
  static const char *const file[] = {
      "infeasible_ray_1195", "scaled10_1616", "scaled10_4069", "scaled10_4410", "scaled10_4428",
      "scaled10_5400",       "scaled_1105",   "scaled_1864",   "scaled_1904",   "scaled_2038",
      "scaled_2388",         "scaled_2782",   "scaled_3099",   "scaled_3798",   "scaled_4420",
      "scaled_4578",         "scaled_4831",   "scaled_5145",   "scaled_5636",   "slider_step17"};
  static const char *const family[] = {
      "subset_sum:n=4,largest=9", "kostreva:variant=2", "murty:n=10", "fathi:n=10",
      "random_copositive:n=40",   "random_psd:n=60"};
  for (int i = 0; i < BASE_COUNT(file); ++i) {
    BASE_TRY(run_pair(cases, "regressions/lcp", "hard", file[i], false, reps, err));
  }
  for (int i = 0; i < BASE_COUNT(family); ++i) {
    known_lcp k;
    BASE_TRY(lcp_family_load(family[i], &k, err));
    const base_status s = run_lemke("hard", family[i], &k.p, reps, err);
    known_lcp_free(&k);
    BASE_TRY(s);
  }
  return BASE_OK;
}

static base_status run_scene(const char *text, int reps, base_error *err) {
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
                           .duration = spec.duration};
    s = simulate(&q, &record, &r, err);
    seconds[k] = r.time.setup + r.time.solve;
    series_close(&record);
  }
  if (s == BASE_OK) {
    r.work.fallbacks += r.n_fallbacks;
    print_row("scenes", text, "lemke", r.verified, run_status_name(r.status), &r.work, r.variant,
              r.rho_max, seconds, reps);
  }
  formulation_choice_free(&f);
  solver_choice_free(&c);
  spec_free(&spec);
  return s;
}

static base_status scenes_group(int reps, base_error *err) {
  static const char *const name[] = {"stack", "wall", "walking_foot", "gripper"};
  for (int i = 0; i < BASE_COUNT(name); ++i) {
    BASE_TRY(run_scene(name[i], reps, err));
  }
  return BASE_OK;
}

static bool asked(int argc, char **argv, const char *group) {
  bool found = argc <= 3;
  for (int i = 3; i < argc; ++i) {
    found = found || strcmp(argv[i], group) == 0;
  }
  return found;
}

int main(int argc, char **argv) {
  int reps = 1;
  base_error err = {0};
  if (argc < 2 || (argc > 2 && !base_parse_int(argv[2], &reps)) || reps < 1 || reps > REPS_MAX) {
    fprintf(stderr, "usage: ablate_lemke CASES [REPETITIONS, 1 to %d [GROUP...]]\n", (int)REPS_MAX);
    return 2;
  }
  printf("group,item,method,right,outcome,pivots,factorizations,refinements,fallbacks,variant,rho,"
         "cpu_s\n");
  base_status s = asked(argc, argv, "small") ? small(argv[1], reps, &err) : BASE_OK;
  s = (s == BASE_OK && asked(argc, argv, "contact")) ? contact(argv[1], reps, &err) : s;
  s = (s == BASE_OK && asked(argc, argv, "hard")) ? hard(argv[1], reps, &err) : s;
  s = (s == BASE_OK && asked(argc, argv, "scenes")) ? scenes_group(reps, &err) : s;
  if (s != BASE_OK) {
    fprintf(stderr, "ablate_lemke: %s\n", err.text);
  }
  return s != BASE_OK;
}
