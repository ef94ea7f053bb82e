/* bench_cone.c - cone solvers on random frictional contact sets (random_cones.h), judged.
 *
 * usage: bench_cone COUNT FIRST_SEED TOL STORAGE SOLVER[:opt=val,...] [SOLVER...]      STORAGE: factored | csc | dense
 * A line per solver: share solved and verified, how many those are, claimed but not verified, given up; iterations and CPU seconds of the
 * solved ones. Problems that were not solved are named on stderr. Exit code 1 where a claim is false. */
#include "lcp/base/clock.h"
#include "lcp/lcp_instance.h"
#include "lcp/lcp_judge.h"
#include "tests/support/random_cones.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct tally {
  int verified, lies, given_up;
  long iterations, most, fallbacks;
  double seconds;
} tally;

static base_status set_options(const lcp_solver *s, char *text, void *opt, base_error *err) {
  base_fields_default(s->fields, s->n_fields, opt);
  for (char *o = strtok(text, ","); o != NULL; o = strtok(NULL, ",")) {
    char *eq = strchr(o, '=');
    if (eq == NULL) {
      return BASE_FAIL(err, BASE_EINVAL, "option %s: need name=value", o);
    }
    *eq = '\0';
    BASE_TRY(base_fields_set(s->fields, s->n_fields, opt, o, eq + 1, err));
  }
  return BASE_OK;
}

static base_status measure(const lcp_solver *s, const void *opt, const lcp_problem *p, int seed,
                           double tol, tally *t, base_error *err) {
  lcp_instance *k;
  lcp_result res;
  lcp_verdict v;
  const lcp_capacity cap = lcp_problem_capacity(p);
  double *z = calloc((size_t)p->M.n, sizeof *z);
  if (z == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "bench_cone: no memory");
  }
  const double started = base_cpu_seconds();
  base_status status = lcp_instance_open(&k, s, &cap, opt, err);
  status = (status == BASE_OK) ? lcp_instance_prepare(k, p, err) : status;
  status = (status == BASE_OK) ? lcp_instance_solve(k, NULL, z, &res, err) : status;
  t->seconds += base_cpu_seconds() - started;
  status = (status == BASE_OK) ? lcp_judge(p, z, &v, err) : status;
  if (status == BASE_OK) {
    const bool claimed = res.outcome == LCP_SOLVED, good = v.rho <= tol;
    t->verified += claimed && good;
    t->lies += claimed && !good;
    t->given_up += !claimed;
    t->iterations += claimed ? res.work.iterations : 0;
    t->most = (claimed && res.work.iterations > t->most) ? res.work.iterations : t->most;
    t->fallbacks += res.work.fallbacks;
    if (!(claimed && good)) {
      (void)fprintf(stderr, "%s, seed %d (n = %d): %s, rho %.2g\n", s->name, seed, p->M.n,
                    lcp_outcome_name(res.outcome), v.rho);
    }
  }
  lcp_instance_close(k);
  free(z);
  return status;
}

/* p in another storage; *owned is freed by the caller. */
static base_status store(lcp_problem *p, const char *storage, lcp_csc *csc, double **dense,
                         base_error *err) {
  if (strcmp(storage, "csc") == 0) {
    BASE_TRY(lcp_matrix_to_csc(&p->M, csc, err));
    p->M = (lcp_matrix){.storage = LCP_CSC, .n = p->M.n, .csc = *csc};
  } else if (strcmp(storage, "dense") == 0) {
    *dense = calloc((size_t)p->M.n * (size_t)p->M.n, sizeof **dense);
    if (*dense == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "bench_cone: no memory");
    }
    lcp_matrix_to_dense(&p->M, *dense);
    p->M = (lcp_matrix){.storage = LCP_DENSE, .n = p->M.n, .val = *dense};
  }
  return BASE_OK;
}

/* *lies grows by the false claims. */
static base_status run(char *name, int count, int first, const char *tol, const char *storage,
                       int *lies, base_error *err) {
  char *options = strchr(name, ':');
  char none[] = "";
  _Alignas(16) unsigned char opt[512] = {0};
  tally t = {0};
  char told[64];
  (void)snprintf(told, sizeof told, "%s", name);
  if (options != NULL) {
    *options++ = '\0';
  }
  const lcp_solver *s = lcp_solver_find(name);
  if (s == NULL || s->options_size > sizeof opt) {
    return BASE_FAIL(err, BASE_EINVAL, "no solver %s in this build", name);
  }
  BASE_TRY(set_options(s, (options != NULL) ? options : none, opt, err));
  BASE_TRY(base_fields_set(s->fields, s->n_fields, opt, "tol", tol, err));
  for (int i = first; i < first + count; i++) {
    known_lcp k;
    lcp_csc csc = {0};
    double *dense = NULL;
    base_status status = random_cones(&k, (uint64_t)i, err);
    lcp_problem p = k.p;
    status = (status == BASE_OK) ? store(&p, storage, &csc, &dense, err) : status;
    status = (status == BASE_OK) ? measure(s, opt, &p, i, atof(tol), &t, err) : status;
    lcp_csc_free(&csc);
    free(dense);
    known_lcp_free(&k);
    if (status == BASE_EUNSUPPORTED) {
      t.given_up++;
    } else if (status != BASE_OK) {
      return status;
    }
  }
  *lies += t.lies;
  (void)printf("%-28s %-8s %5.1f %% %5d %5d %5d %9.1f %7ld %7ld %9.3g\n", told, storage,
               100.0 * t.verified / count, t.verified, t.lies, t.given_up,
               (double)t.iterations / (t.verified > 0 ? t.verified : 1), t.most, t.fallbacks,
               t.seconds);
  return BASE_OK;
}

int main(int argc, char **argv) {
  if (argc < 6) {
    (void)fprintf(stderr, "usage: bench_cone COUNT FIRST_SEED TOL STORAGE SOLVER...\n");
    return 2;
  }
  int lies = 0;
  (void)printf("%-28s %-8s %7s %5s %5s %5s %9s %7s %7s %9s\n", "solver", "storage", "share", "good",
               "false", "open", "mean it", "most", "fallb", "CPU s");
  for (int i = 5; i < argc; i++) {
    base_error err = {0};
    if (run(argv[i], atoi(argv[1]), atoi(argv[2]), argv[3], argv[4], &lies, &err) != BASE_OK) {
      (void)fprintf(stderr, "bench_cone: %s\n", err.text);
      return 1;
    }
  }
  return lies > 0;
}
