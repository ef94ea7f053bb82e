/* lcpbench export: a problem as files of other codes. */
#include "harness/cli/cli.h"
#include "harness/measure/export_lcp.h"
#include "harness/measure/problem_source.h"
#include "harness/util/args.h"
#include "problems/import/import.h"

#include <string.h>

typedef struct export_options {
  const char *format, *out, *q;
} export_options;

static base_status export_friction(const char *problem, const char *format, const char *out,
                                   base_error *err) {
  import_kind kind;
  friction_problem f;
  if (strchr(problem, '.') == NULL) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%s: --format %s needs a file", problem, format);
  }
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
    done = export_lcp_mtx(s.p, o->out, err);
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
