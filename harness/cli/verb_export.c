/* lcpbench export: a problem as files of other codes, a scene as a scene file, the problems of its run as a folder. */
#include "harness/cli/cli.h"
#include "harness/measure/export_lcp.h"
#include "harness/measure/problem_source.h"
#include "harness/measure/registry.h"
#include "harness/measure/simulate.h"
#include "harness/sequence/sequence_file.h"
#include "harness/sequence/sequence_source.h"
#include "harness/util/args.h"
#include "lcp/base/fields.h"
#include "lcp/base/output.h"
#include "lcp/io/lcp_read.h"
#include "problems/import/import.h"
#include "problems/write/scene_write.h"

#include <string.h>
#include <sys/stat.h>

typedef struct export_options {
  const char *format, *out, *q;
  bool sequence;
  const char *formulation, *solver, *step;
  int count;
} export_options;

static base_status missing(const char *option, base_error *err) {
  return BASE_FAIL(err, BASE_EINVAL, "%s is missing; --sequence needs it", option);
}

/* The run that poses the sequence, from its options; step and count as the scene has them where not given. */
static base_status sequence_of(const char *problem, const export_options *o, sequence_text *t,
                               base_error *err) {
  char text[3 * SEQUENCE_TEXT + 64];
  scene_spec spec;
  BASE_TRY(scene_open(problem, &spec, err));
  char step[32];
  double h = spec.n_h > 0 ? spec.h[0] : 0.01;
  const double duration = spec.duration;
  spec_free(&spec);
  if (o->step != NULL && (!base_parse_real(o->step, &h) || !(h > 0.0))) {
    return BASE_FAIL(err, BASE_EINVAL, "--step %s: need a number above 0", o->step);
  }
  base_real_print(h, step, sizeof step);
  const double own = ceil(duration / h - SIM_LAST_STEP);
  if (o->count == 0 && !(own >= 1.0 && own < 1e9)) {
    return BASE_FAIL(err, BASE_EINVAL, "--step %s: the scene lasts %g s; need --count", step,
                     duration);
  }
  (void)snprintf(text, sizeof text, "%s@%s@%s@%s@%ld", problem, o->formulation, o->solver, step,
                 o->count > 0 ? (long)o->count : lround(own));
  return sequence_text_parse(text, t, err);
}

/* 3: some answer is not verified; the manifest says which. */
static base_status export_sequence(const char *problem, const export_options *o, int *code,
                                   base_error *err) {
  sequence_text t;
  sequence q = {0};
  if (o->formulation == NULL || o->solver == NULL) {
    return missing(o->formulation == NULL ? "--formulation" : "--solver", err);
  }
  if (o->format != NULL || o->q != NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: a sequence has its own files",
                     o->format != NULL ? "--format" : "--q");
  }
  BASE_TRY(sequence_of(problem, o, &t, err));
  base_status done = sequence_pose(&t, &q, err);
  if (done == BASE_OK) {
    done = sequence_write(&q, o->out, err);
  }
  int unverified = 0;
  for (int i = 0; i < q.n; i++) {
    unverified += !q.item[i].verified;
  }
  if (done == BASE_OK) {
    (void)printf("%d problems of %ld steps, %d without a verified answer, %s\n", q.n, q.steps,
                 unverified, run_status_name(q.status));
    *code = (unverified == 0 && q.steps == q.count) ? CLI_OK : CLI_HONEST;
  }
  sequence_free(&q);
  return done;
}

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
    done = (strcmp(o->format, "mtx") == 0)   ? export_lcp_mtx(s.p, o->out, err)
           : (strcmp(o->format, "npz") == 0) ? lcp_write_npz(o->out, s.p, err)
                                             : export_lcp_text(s.p, o->out, err);
  }
  problem_source_close(&s);
  return done;
}

static base_status export_scene(const char *text, const export_options *o, base_error *err) {
  scene_spec s;
  base_out file;
  if (o->q != NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "--q %s: a scene has none", o->q);
  }
  BASE_TRY(scene_open(text, &s, err));
  base_status done = base_out_open(&file, o->out, err);
  if (done == BASE_OK) {
    done = base_out_finish(&file, scene_write(file.to, &s, err), err);
  }
  spec_free(&s);
  return done;
}

/* What only a sequence takes. */
static base_status check_single(const export_options *o, base_error *err) {
  const char *only = (o->formulation != NULL) ? "--formulation"
                     : (o->solver != NULL)    ? "--solver"
                     : (o->step != NULL)      ? "--step"
                     : (o->count > 0)         ? "--count"
                                              : NULL;
  if (only != NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: goes with --sequence", only);
  }
  return (o->format != NULL)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL, "--format is missing; see lcpbench help export");
}

/* mtx holds plain LCPs, npz also boxes and free rows, fclib friction problems, siconos these and LCPs, scene scenes. */
static base_status export_problem(const char *problem, const export_options *o, base_error *err) {
  BASE_TRY(check_single(o, err));
  if (strcmp(o->format, "scene") == 0) {
    return export_scene(problem, o, err);
  }
  const bool mtx = strcmp(o->format, "mtx") == 0;
  const bool npz = strcmp(o->format, "npz") == 0;
  const bool fclib = strcmp(o->format, "fclib") == 0;
  if (!mtx && !npz && !fclib && strcmp(o->format, "siconos") != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "--format %s: need mtx, npz, siconos, fclib or scene",
                     o->format);
  }
  struct stat st;
  if (mtx && (base_out_is_stdout(o->out) || (stat(o->out, &st) == 0 && !S_ISREG(st.st_mode)))) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "--out %s: mtx is two files, PATH.M.mtx and PATH.q.mtx; need a PATH for them",
                     o->out);
  }
  import_kind kind = IMPORT_UNKNOWN;
  if (!mtx && !npz && problem_is_import(problem)) {
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
    ARG(export_options, format, "--format", ARG_TEXT, "mtx|npz|siconos|fclib|scene",
        "format of the files; a sequence has its own"),
    ARG(export_options, out, "--out", ARG_OUTPUT, "PATH",
        "file to be written; of mtx PATH.M.mtx and PATH.q.mtx, of a sequence the folder",
        .needed = true),
    ARG(export_options, sequence, "--sequence", ARG_FLAG, NULL,
        "the problems that a run of the scene poses, in their order, with its answers"),
    ARG(export_options, formulation, "--formulation", ARG_TEXT, "FORMULATION",
        "poses the problems of a sequence"),
    ARG(export_options, solver, "--solver", ARG_TEXT, "SOLVER",
        "gives the answers from which the run of a sequence goes on"),
    ARG(export_options, step, "--step", ARG_TEXT, "H", "step of a sequence instead of the scene's",
        .unit = "s", .above = true),
    ARG(export_options, count, "--count", ARG_INT, "N",
        "steps of a sequence; as many as the scene lasts where none is given", .unit = "1",
        .min = 1),
    ARG(export_options, q, "--q", ARG_TEXT, "FILE",
        "vector q of a Matrix Market problem; NAME.q.mtx beside NAME.M.mtx where none is given"),
};
static const arg_table args = {options,
                               BASE_COUNT(options),
                               1,
                               1,
                               "PROBLEM",
                               "family with its parameters, or problem file; with --format scene "
                               "or --sequence a scene, or scene file"};

static int run(int argc, char **argv) {
  export_options o = {0};
  const char *problem;
  int n;
  base_error err = {0};
  base_status done = args_parse(&args, &o, argc, argv, &problem, &n, &err);
  int code = CLI_OK;
  if (done == BASE_OK) {
    done =
        o.sequence ? export_sequence(problem, &o, &code, &err) : export_problem(problem, &o, &err);
  }
  return (done == BASE_OK) ? code : cli_report(&err);
}

extern const cli_verb verb_export;
const cli_verb verb_export = {
    .name = "export",
    .args = &args,
    .help = "writes a problem for other codes (mtx: PATH.M.mtx and PATH.q.mtx), a scene as a scene "
            "file, or the problems of its run as a sequence",
    .run = run,
};
