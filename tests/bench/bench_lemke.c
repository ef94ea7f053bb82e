/* bench_lemke.c - lemke, and on symmetric problems ppm, block_pivoting and pgs_sm, against the plain
 * dense tableau, Dantzig's method where DART's library is installed and Siconos' Lemke where the build has it; lemke's
 * factored form against its own dense form and its path from the origin.
 *
 * usage: bench_lemke [REPETITIONS [grasp|small|large]]
 * With `grasp` only one problem of 12,000 unknowns, dense and factored: minutes, and 10 GB. With `small` only those
 * of up to 64 unknowns, which all methods read densely; a time is then the mean of as many solves as take a
 * millisecond, without readings of the clock inside one (lcp_instance_untimed). With `large` all but these.
 * CSV on stdout, one row per problem and method: CPU seconds of set-up and solve together, median and
 * quartiles; the methods take turns inside a repetition. `speedup` is the median of the problem's
 * first method (the tableau, where it runs) over this one's; forming a dense M is not charged. Comment lines give exponents in the number of
 * contacts. */
#include "lcp/base/clock.h"
#include "lcp/io/lcp_read.h"
#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"
#include "problems/families/family.h"
#include "tests/support/dart_dantzig.h"
#include "tests/support/few_bodies.h"
#include "tests/support/files.h"
#include "tests/support/tableau_lemke.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REPS_MAX = 51, METHODS_MAX = 8 };
enum { SMALL = 64 }; /* unknowns up to which one solve is too short for the clock */
static const double enough =
    1e-3; /* [s]: of so many solves the first, which find nothing in the caches, weigh little */
enum { TABLEAU_MAX = 2000 }; /* unknowns up to which few bodies are given to the tableau */
enum {
  ORIGIN_MAX = 400
}; /* contacts with friction up to which the path from the origin is timed */

typedef struct method {
  const char *name;
  const lcp_solver *solver; /* NULL: a peer of tests/support */
  bool dantzig;             /* this one; else the tableau */
  const lcp_problem *p;
  lcp_instance *instance;
  unsigned char options[512];
  double *work, *z;
  double seconds[REPS_MAX];
  int repeats; /* solves in a time; 0: as many as it takes */
  lcp_result res;
  lcp_verdict v;
} method;

static base_status method_open(method *m, const char *name, const lcp_problem *p, base_error *err) {
  *m = (method){.name = name, .p = p};
  m->z = calloc((size_t)p->M.n + 1, sizeof *m->z);
  if (strcmp(name, "tableau") == 0) {
    m->work = calloc(tableau_lemke_work(p->M.n), sizeof *m->work);
    return (m->work != NULL && m->z != NULL) ? BASE_OK : BASE_FAIL(err, BASE_ENOMEM, "tableau");
  }
  if (strcmp(name, "dantzig") == 0) {
    m->dantzig = true;
    m->work = calloc(dart_dantzig_work(p->M.n), sizeof *m->work);
    return (m->work != NULL && m->z != NULL) ? BASE_OK : BASE_FAIL(err, BASE_ENOMEM, "dantzig");
  }
  const lcp_capacity cap = lcp_problem_capacity(p);
  m->solver = lcp_solver_find((strncmp(name, "lemke", 5) == 0) ? "lemke" : name);
  base_fields_default(m->solver->fields, m->solver->n_fields, m->options);
  if (strcmp(name, "lemke_origin") == 0) {
    BASE_TRY(base_fields_set(m->solver->fields, m->solver->n_fields, m->options, "start", "origin",
                             err));
  }
  BASE_TRY(lcp_instance_open(&m->instance, m->solver, &cap, m->options, err));
  lcp_instance_untimed(m->instance); /* as the peers are */
  return BASE_OK;
}

static base_status solve_once(method *m, base_error *err) {
  const lcp_problem *p = m->p;
  memset(m->z, 0, sizeof *m->z * (size_t)p->M.n);
  if (m->solver == NULL && m->dantzig) {
    m->res.outcome = dart_dantzig(p->M.n, p->M.val, p->q, m->z, m->work) ? LCP_SOLVED : LCP_STALLED;
    return BASE_OK;
  }
  if (m->solver == NULL) {
    m->res.outcome = tableau_lemke(p->M.n, p->M.val, p->q, m->z, m->work, &m->res.work.pivots);
    return BASE_OK;
  }
  BASE_TRY(lcp_instance_prepare(m->instance, p, err));
  return lcp_instance_solve(m->instance, NULL, m->z, &m->res, err);
}

static base_status method_run(method *m, double *seconds, base_error *err) {
  const double least = (m->repeats == 0 && m->p->M.n <= SMALL) ? enough : 0;
  const double started = base_cpu_seconds();
  int count = 0;
  do {
    BASE_TRY(solve_once(m, err));
    ++count;
  } while (count < m->repeats || base_cpu_seconds() - started < least);
  *seconds = (base_cpu_seconds() - started) / count;
  m->repeats = count; /* counted in the warm-up */
  return BASE_OK;
}

static void method_close(method *m) {
  lcp_instance_close(m->instance);
  free(m->work);
  free(m->z);
}

static int compare(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Times all methods on one problem; returns the median of the last one [s], or -1. */
static double contest(const char *problem, method *m, int n_method, int reps, base_error *err) {
  double first = 0;
  double median = -1;
  for (int r = -1; r < reps; ++r) { /* -1: warm-up */
    for (int i = 0; i < n_method; ++i) {
      if (method_run(&m[i], &m[i].seconds[(r < 0) ? 0 : r], err) != BASE_OK) {
        return -1;
      }
    }
  }
  for (int i = 0; i < n_method; ++i) {
    if (lcp_judge(m[i].p, m[i].z, &m[i].v, err) != BASE_OK) {
      return -1;
    }
    qsort(m[i].seconds, (size_t)reps, sizeof *m[i].seconds, compare);
    median = m[i].seconds[reps / 2];
    first = (i == 0) ? median : first;
    printf("%s,%s,%d,%s,%ld,%.1e,%.9f,%.9f,%.9f,%.2f\n", problem, m[i].name, m[i].p->M.n,
           lcp_outcome_name(m[i].res.outcome), m[i].res.work.pivots, m[i].v.rho, median,
           m[i].seconds[reps / 4], m[i].seconds[3 * reps / 4], first / median);
  }
  (void)fflush(stdout);
  return median;
}

static base_status dense_copy(const lcp_problem *p, double **M, lcp_problem *out, base_error *err) {
  const size_t n = (size_t)p->M.n;
  *M = malloc(n * n * sizeof **M);
  if (*M == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "dense copy of n = %d", p->M.n);
  }
  lcp_matrix_to_dense(&p->M, *M);
  *out = *p;
  out->M = (lcp_matrix){.storage = LCP_DENSE, .n = p->M.n, .val = *M};
  return BASE_OK;
}

/* The peers on the dense form, ours on `own`. */
static base_status bench_both(const char *name, const lcp_problem *own, const lcp_problem *dense,
                              int reps, base_error *err) {
  static const char *const ours[] = {"lemke", "ppm", "block_pivoting", "pgs_sm"};
  const bool symmetric = lcp_matrix_is_symmetric(&dense->M);
  method m[METHODS_MAX] = {0};
  int n_method = 0;
  base_status s = method_open(&m[n_method++], "tableau", dense, err);
  if (s == BASE_OK && symmetric && dense->M.n <= SMALL && dart_dantzig_is_here()) {
    s = method_open(&m[n_method++], "dantzig", dense, err);
  }
  if (s == BASE_OK && lcp_solver_find("siconos_lemke") != NULL) {
    s = method_open(&m[n_method++], "siconos_lemke", dense, err);
  }
  for (int i = 0; s == BASE_OK && i < (symmetric ? BASE_COUNT(ours) : 1); ++i) {
    s = method_open(&m[n_method++], ours[i], own, err);
  }
  if (s == BASE_OK && contest(name, m, n_method, reps, err) < 0) {
    s = err->code;
  }
  for (int i = 0; i < n_method; ++i) {
    method_close(&m[i]);
  }
  return s;
}

static base_status bench_file(const char *name, int reps, base_error *err) {
  char m_name[128];
  char q_name[128];
  lcp_file_problem f;
  lcp_problem dense = {0};
  double *M = NULL;
  (void)snprintf(m_name, sizeof m_name, "cases/contact_lcps/%s.M.mtx", name);
  (void)snprintf(q_name, sizeof q_name, "cases/contact_lcps/%s.q.mtx", name);
  BASE_TRY(lcp_read_mtx(tests_file(m_name), tests_file(q_name), &f, err));
  base_status s = dense_copy(&f.p, &M, &dense, err);
  if (s == BASE_OK) {
    s = bench_both(name, (f.p.M.n <= SMALL) ? &dense : &f.p, &dense, reps, err);
  }
  free(M);
  lcp_file_problem_free(&f);
  return s;
}

/* A small problem, densely; k is freed. */
static base_status bench_known(const char *name, known_lcp *k, int reps, base_error *err) {
  lcp_problem dense = {0};
  double *M = NULL;
  base_status s = dense_copy(&k->p, &M, &dense, err);
  if (s == BASE_OK) {
    s = bench_both(name, &dense, &dense, reps, err);
  }
  free(M);
  known_lcp_free(k);
  return s;
}

static const struct contact_set {
  int bodies, contacts, facets;
} contact_sets[] = {{1, 1, 4},  {1, 4, 4}, {2, 2, 4},  {2, 5, 4},
                    {3, 10, 4}, {2, 4, 8}, {6, 20, 0}, {12, 40, 0}};

/* Columns, stacks and frictional sets of 6 to 60 unknowns. */
static base_status bench_small(int reps, base_error *err) {
  static const char *const families[] = {"stack:n=6",     "stack:n=10",    "stack:n=20",
                                         "stack:n=45",    "stack:n=60",    "box_stack:n=1",
                                         "box_stack:n=2", "box_stack:n=5", "box_stack:n=10"};
  static const char *const files[] = {"column_n10", "column_n30", "boxstack_n12", "boxstack_n32",
                                      "pd_n10",     "pd_n30",     "fbox4_p4",     "fbox8_p4",
                                      "frand4_p5",  "frand8_p5"};
  known_lcp k;
  if (getenv("ONLY")) {
    BASE_TRY(few_bodies(&k, 1, 1, 4, 7, err));
    return bench_known("only", &k, reps, err);
  }
  for (int i = 0; i < BASE_COUNT(families); ++i) {
    BASE_TRY(lcp_family_load(families[i], &k, err));
    BASE_TRY(bench_known(families[i], &k, reps, err));
  }
  for (int i = 0; i < BASE_COUNT(files); ++i) {
    BASE_TRY(bench_file(files[i], reps, err));
  }
  for (int i = 0; i < BASE_COUNT(contact_sets); ++i) {
    const struct contact_set *c = &contact_sets[i];
    char name[64];
    (void)snprintf(name, sizeof name, "set%d_contacts%d_facets%d", c->bodies, c->contacts,
                   c->facets);
    BASE_TRY(few_bodies(&k, c->bodies, c->contacts, c->facets, 7, err));
    BASE_TRY(bench_known(name, &k, reps, err));
  }
  return BASE_OK;
}

/* Dense and factored form of few bodies; *seconds is the median of the factored one. */
static base_status bench_bodies(int bodies, int contacts, int facets, bool with_dense, int reps,
                                double *seconds, base_error *err) {
  known_lcp k;
  lcp_problem dense = {0};
  double *M = NULL;
  char name[64];
  method m[METHODS_MAX] = {0};
  int n_method = 0;
  (void)snprintf(name, sizeof name, "bodies%d_contacts%d_facets%d", bodies, contacts, facets);
  base_status s = few_bodies(&k, bodies, contacts, facets, 7, err);
  if (s == BASE_OK && with_dense) {
    s = dense_copy(&k.p, &M, &dense, err);
    if (s == BASE_OK && dense.M.n <= TABLEAU_MAX) {
      s = method_open(&m[n_method++], "tableau", &dense, err);
    }
    if (s == BASE_OK) {
      s = method_open(&m[n_method++], "lemke_dense", &dense, err);
    }
  }
  if (s == BASE_OK && (facets == 0 || contacts <= ORIGIN_MAX)) {
    s = method_open(&m[n_method++], "lemke_origin", &k.p, err);
  }
  if (s == BASE_OK) {
    s = method_open(&m[n_method++], "lemke_factored", &k.p, err);
  }
  if (s == BASE_OK) {
    *seconds = contest(name, m, n_method, reps, err);
    s = (*seconds < 0) ? err->code : BASE_OK;
  }
  for (int i = 0; i < n_method; ++i) {
    method_close(&m[i]);
  }
  free(M);
  known_lcp_free(&k);
  return s;
}

/* Fixed bodies, growing contacts: prints the exponent fitted by least squares of logs. */
static base_status bench_growth(int bodies, int facets, int dense_at, int reps, base_error *err) {
  static const int contacts[] = {100, 200, 400, 800, 2000, 4000, 8000};
  const int first = (bodies > 1 && facets > 0) ? 2 : 0; /* few bodies need many contacts */
  const int last = (facets > 0) ? 5 : BASE_COUNT(contacts);
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int i = first; i < last; ++i) {
    double t = 0;
    BASE_TRY(bench_bodies(bodies, contacts[i], facets, contacts[i] == dense_at, reps, &t, err));
    const double x = log(contacts[i]);
    sx += x;
    sy += log(t);
    sxx += x * x;
    sxy += x * log(t);
  }
  const int count = last - first;
  printf("# %d bodies, %d facets: exponent %.2f in contacts, %d to %d\n", bodies, facets,
         (count * sxy - sx * sy) / (count * sxx - sx * sx), contacts[first], contacts[last - 1]);
  return BASE_OK;
}

static base_status bench_large(int reps, base_error *err) {
  static const char *const files[] = {"pd_n300",    "column_n300",  "boxstack_n300",
                                      "frand4_p80", "fbox4_p80",    "frand8_p20",
                                      "fbox4_p200", "column_n1000", "boxstack_n1000"};
  for (int i = 0; i < BASE_COUNT(files); ++i) {
    BASE_TRY(bench_file(files[i], reps, err));
  }
  BASE_TRY(bench_growth(1, 0, 400, reps, err));
  BASE_TRY(bench_growth(1, 4, 400, reps, err));
  BASE_TRY(bench_growth(20, 0, 2000, reps, err));
  return bench_growth(20, 4, 400, reps, err);
}

static base_status bench_all(int reps, base_error *err) {
  BASE_TRY(bench_small(reps, err));
  return bench_large(reps, err);
}

/* 2000 contacts with friction among 20 bodies, the dense form against the factored one. */
static base_status bench_grasp(int reps, base_error *err) {
  double seconds = 0;
  return bench_bodies(20, 2000, 4, true, reps, &seconds, err);
}

int main(int argc, char **argv) {
  int reps = 5;
  base_error err = {0};
  if ((argc > 1 && !base_parse_int(argv[1], &reps)) || reps < 1 || reps > REPS_MAX) {
    fprintf(stderr, "usage: bench_lemke [REPETITIONS, 1 to %d [grasp|small|large]]\n",
            (int)REPS_MAX);
    return 2;
  }
  const char *part = (argc > 2) ? argv[2] : "";
  printf("problem,method,n,outcome,pivots,rho,median_s,q1_s,q3_s,speedup\n");
  const base_status s = (strcmp(part, "grasp") == 0)   ? bench_grasp(reps, &err)
                        : (strcmp(part, "small") == 0) ? bench_small(reps, &err)
                        : (strcmp(part, "large") == 0) ? bench_large(reps, &err)
                                                       : bench_all(reps, &err);
  if (s != BASE_OK) {
    fprintf(stderr, "bench_lemke: %s\n", err.text);
    return 1;
  }
  return 0;
}
