/* lcpbench export: a problem as files of other codes. */
#include "harness/cli/cli.h"
#include "harness/measure/export_lcp.h"
#include "harness/measure/problem_source.h"
#include "harness/util/args.h"
#include "lcp/base/output.h"
#include "problems/import/import.h"

#include <string.h>
#include <sys/stat.h>

typedef struct export_options {
  const char *format, *out, *q;
} export_options;

static base_status export_friction(const char *problem, import_kind kind, const char *format,
                                   const char *out, base_error *err) {
  friction_problem f;
  BASE_TRY(kind == IMPORT_FCLIB ? friction_read_fclib(problem, &f, err)
                                : friction_read_siconos(problem, &f, err));
  const base_status done = (strcmp(format, "fclib") == 0) ? friction_write_fclib(out, &f, err)
                                                          : friction_write_siconos(out, &f, err);
  friction_free(&f);
  return done;
}

static base_status export_plain(const char *problem, const export_options *o, base_error *err) {
  problem_source s;
  base_status done = problem_source_open(problem, o->q, 0, &s, err);
  if (done == BASE_OK) {
    done = (strcmp(o->format, "mtx") == 0) ? export_lcp_mtx(s.p, o->out, err)
                                           : export_lcp_text(s.p, o->out, err);
  }
  problem_source_close(&s);
  return done;
}

/* mtx holds plain LCPs, fclib friction problems, siconos both. */
static base_status export_problem(const char *problem, const export_options *o, base_error *err) {
  const bool mtx = strcmp(o->format, "mtx") == 0;
  const bool fclib = strcmp(o->format, "fclib") == 0;
  if (!mtx && !fclib && strcmp(o->format, "siconos") != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "--format %s: need mtx, siconos or fclib", o->format);
  }
  struct stat st;
  if (mtx && (base_out_is_stdout(o->out) || (stat(o->out, &st) == 0 && !S_ISREG(st.st_mode)))) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "--out %s: mtx is two files, PATH.M.mtx and PATH.q.mtx; need a PATH for them",
                     o->out);
  }
  import_kind kind = IMPORT_UNKNOWN;
  if (!mtx && problem_is_import(problem)) {
    BASE_TRY(import_detect(problem, &kind, err));
  }
  if (kind == IMPORT_FCLIB || kind == IMPORT_FRICTION) {
    if (o->q != NULL) {
      return BASE_FAIL(err, BASE_EINVAL, "--q %s: %s has a q already", o->q, problem);
    }
    return export_friction(problem, kind, o->format, o->out, err);
  }
  if (fclib) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED,
                     "%s: --format fclib needs a file with a friction problem (FCLIB or Siconos "
                     "text)",
                     problem);
  }
  return export_plain(problem, o, err);
}

static const arg_option options[] = {
    ARG(export_options, format, "--format", ARG_TEXT, "mtx|siconos|fclib", "format of the files",
        .needed = true),
    ARG(export_options, out, "--out", ARG_OUTPUT, "PATH",
        "file to be written; of mtx PATH.M.mtx and PATH.q.mtx", .needed = true),
    ARG(export_options, q, "--q", ARG_TEXT, "FILE",
        "vector q of a Matrix Market problem; NAME.q.mtx beside NAME.M.mtx where none is given"),
};
static const arg_table args = {
    options, BASE_COUNT(options), 1, 1, "PROBLEM", "family with its parameters, or problem file"};

static int run(int argc, char **argv) {
  export_options o = {0};
  const char *problem;
  int n;
  base_error err = {0};
  base_status done = args_parse(&args, &o, argc, argv, &problem, &n, &err);
  if (done == BASE_OK) {
    done = export_problem(problem, &o, &err);
  }
  return (done == BASE_OK) ? CLI_OK : cli_report(&err);
}

extern const cli_verb verb_export;
const cli_verb verb_export = {
    .name = "export",
    .args = &args,
    .help = "writes a problem for other codes (mtx: PATH.M.mtx and PATH.q.mtx)",
    .run = run,
};
