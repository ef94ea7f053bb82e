/* lcpbench export: a problem as files of other codes. */
#include "harness/args.h"
#include "harness/cli.h"
#include "harness/problem_source.h"
#include "problems/import/import.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

typedef struct export_options {
  const char *format, *out, *q;
} export_options;

static base_status failed(const char *path, base_error *err) {
  return BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
}

static base_status only_orthant(const problem_source *s, const char *format, base_error *err) {
  return (lcp_problem_sets(s->p) == 1u << LCP_ORTHANT)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: %s holds plain LCPs only", s->name, format);
}

/* OUT.M.mtx and OUT.q.mtx */
static base_status export_mtx(const problem_source *s, const char *out, base_error *err) {
  char path[1100];
  lcp_csc m;
  BASE_TRY(only_orthant(s, "Matrix Market", err));
  BASE_TRY(lcp_matrix_to_csc(&s->p->M, &m, err));
  (void)snprintf(path, sizeof path, "%.1024s.M.mtx", out);
  FILE *to = fopen(path, "w");
  bool good = to != NULL;
  if (good) {
    (void)fprintf(to, "%%%%MatrixMarket matrix coordinate real general\n%d %d %d\n", m.n_row,
                  m.n_col, m.colptr[m.n_col]);
    for (int j = 0; j < m.n_col; j++) {
      for (int k = m.colptr[j]; k < m.colptr[j + 1]; k++) {
        (void)fprintf(to, "%d %d %.17g\n", m.rowind[k] + 1, j + 1, m.val[k]);
      }
    }
    good = ferror(to) == 0;
    good = fclose(to) == 0 && good;
  }
  lcp_csc_free(&m);
  if (!good) {
    return failed(path, err);
  }
  (void)snprintf(path, sizeof path, "%.1024s.q.mtx", out);
  return lcp_write_mtx_vector(path, s->p->M.n, s->p->q, err);
}

static base_status export_friction(const char *problem, const char *format, const char *out,
                                   base_error *err) {
  import_kind kind;
  friction_problem f;
  BASE_TRY(import_detect(problem, &kind, err));
  if (kind == IMPORT_FCLIB) {
    BASE_TRY(friction_read_fclib(problem, &f, err));
  } else if (kind == IMPORT_FRICTION) {
    BASE_TRY(friction_read_siconos(problem, &f, err));
  } else {
    return BASE_FAIL(err, BASE_EUNSUPPORTED,
                     "%s: --format %s needs a friction problem (FCLIB or"
                     " Siconos text)",
                     problem, format);
  }
  const base_status done = (strcmp(format, "fclib") == 0) ? friction_write_fclib(out, &f, err)
                                                          : friction_write_siconos(out, &f, err);
  friction_free(&f);
  return done;
}

static base_status export_problem(const char *problem, const export_options *o, base_error *err) {
  if (o->out == NULL || o->format == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%s is missing", o->out == NULL ? "--out" : "--format");
  }
  if (strcmp(o->format, "fclib") == 0 || strcmp(o->format, "siconos") == 0) {
    return export_friction(problem, o->format, o->out, err);
  }
  if (strcmp(o->format, "mtx") != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "--format %s: need mtx, siconos or fclib", o->format);
  }
  problem_source s;
  base_status done = problem_source_open(problem, o->q, 0, &s, err);
  if (done == BASE_OK) {
    done = export_mtx(&s, o->out, err);
  }
  problem_source_close(&s);
  return done;
}

static int run(int argc, char **argv) {
  export_options o = {0};
  const arg_option options[] = {
      {"--format", ARG_TEXT, &o.format}, {"--out", ARG_TEXT, &o.out}, {"--q", ARG_TEXT, &o.q}};
  const arg_table table = {options, BASE_COUNT(options), 1, 1, "PROBLEM"};
  const char *problem;
  int n;
  base_error err = {0};
  base_status done = args_parse(&table, argc, argv, &problem, &n, &err);
  if (done == BASE_OK) {
    done = export_problem(problem, &o, &err);
  }
  return (done == BASE_OK) ? CLI_OK : cli_report(&err);
}

extern const cli_verb verb_export;
const cli_verb verb_export = {
    .name = "export",
    .usage = "export PROBLEM --format mtx|siconos|fclib --out PATH [--q FILE]",
    .help = "writes a problem for other codes (mtx: PATH.M.mtx and PATH.q.mtx)",
    .run = run,
};
