/* lcpbench solve: one complementarity problem, one solver, one JSON object. */
#include "harness/cli/cli.h"
#include "harness/cli/solve_all.h"
#include "harness/cli/solve_sequence.h"
#include "harness/measure/problem_source.h"
#include "harness/measure/solve_once.h"
#include "harness/measure/trace.h"
#include "harness/util/args.h"
#include "harness/util/json_out.h"
#include "harness/util/table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct solve_options {
  arg_list solver;
  const char *q, *tol, *max_iter, *z, *certificate, *formulation, *trace, *format, *start;
  int facets;
  double time_limit; /* NAN: not given */
  FILE *report;      /* where the JSON object goes */
} solve_options;

static base_status choose(const solve_options *o, const char *text, solver_choice *s,
                          base_error *err) {
  BASE_TRY(solver_choose(text, s, err));
  if (o->tol != NULL) {
    BASE_TRY(solver_choice_set(s, "tol", o->tol, err));
  }
  if (o->max_iter != NULL) {
    BASE_TRY(solver_choice_set(s, "max_iter", o->max_iter, err));
  }
  return BASE_OK;
}

/* The solvers that are asked for, with their options. */
typedef struct solver_choices {
  solver_choice *item;
  int n;
} solver_choices;

static base_status choose_all(const solve_options *o, solver_choices *c, base_error *err) {
  int built = 0;
  while (registry_solver(built) != NULL) {
    built++;
  }
  const bool all = o->solver.count == 1 && strcmp(o->solver.item[0], "all") == 0;
  const int n = all ? built : o->solver.count;
  c->item = calloc((size_t)n + 1, sizeof *c->item);
  if (c->item == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d solvers", n);
  }
  while (c->n < n) {
    const char *text = all ? registry_solver(c->n)->name : o->solver.item[c->n];
    BASE_TRY(choose(o, text, &c->item[c->n++], err)); /* counted first: what failed is freed too */
  }
  return BASE_OK;
}

static void free_all(solver_choices *c) {
  for (int i = 0; i < c->n; i++) {
    solver_choice_free(&c->item[i]);
  }
  free(c->item);
}

/* One solver is told as an object, several as a table. */
static bool is_table(const solve_options *o) {
  return o->solver.count > 1 || o->format != NULL || strcmp(o->solver.item[0], "all") == 0;
}

static base_status check_table(const solve_options *o, base_error *err) {
  if (!is_table(o)) {
    return isnan(o->time_limit) ? BASE_OK
                                : BASE_FAIL(err, BASE_EINVAL,
                                            "--time-limit: is of a table; one solver has its "
                                            "option max_seconds");
  }
  const char *file = (o->z != NULL)             ? "--z"
                     : (o->certificate != NULL) ? "--certificate"
                     : (o->trace != NULL)       ? "--trace"
                                                : NULL;
  if (file != NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: is of one solver, not of a table", file);
  }
  return (o->format != NULL) ? table_format(o->format, err) : BASE_OK;
}

/* Friction problems are posed on the exact cone, or as the polyhedral LCP with facets. */
static base_status choose_pose(solve_options *o, base_error *err) {
  const bool polyhedral = o->formulation != NULL && strcmp(o->formulation, "velocity") == 0;
  if (o->formulation != NULL && !polyhedral && strcmp(o->formulation, "coulomb") != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "--formulation %s: need coulomb or velocity",
                     o->formulation);
  }
  if (!polyhedral && o->formulation != NULL && o->facets != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "--facets: the exact cone has none");
  }
  o->facets = (polyhedral && o->facets == 0) ? 4 : o->facets;
  return BASE_OK;
}

/* Solves, with the history written where one is asked for. */
static base_status solve_traced(const problem_source *src, const solver_choice *s,
                                const solve_options *o, double *z, solve_record *r,
                                base_error *err) {
  if (o->trace == NULL) {
    return solve_certified(src->p, s, z, o->certificate, NULL, r, err);
  }
  trace_file t;
  BASE_TRY(trace_open(&t, o->trace, err));
  base_status done = solve_certified(src->p, s, z, o->certificate, trace_begin(&t), r, err);
  if (done == BASE_OK) {
    done = trace_end(&t, err);
  }
  return trace_finish(&t, done, err);
}

/* The answer stands without a proof, which is told behind it. */
static void tell_unproved(const solver_choice *s, const char *certificate) {
  base_error err = {0};
  (void)BASE_FAIL(&err, BASE_EUNSUPPORTED, "--certificate %.200s: %s proved nothing, no file",
                  certificate, s->solver->name);
  (void)cli_report(&err);
}

static base_status solve_and_print(const problem_source *src, const solver_choice *s,
                                   const solve_options *o, int *code, base_error *err) {
  const int n = src->p->M.n;
  double *z = calloc((size_t)n + 1, sizeof *z);
  if (z == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for the answer", src->name);
  }
  solve_record r;
  lcp_verdict room;
  const lcp_verdict *cone = NULL;
  base_status done = solve_traced(src, s, o, z, &r, err);
  if (done == BASE_OK && o->z != NULL && r.has_claim) {
    done = lcp_write_mtx_vector(o->z, n, z, err);
  }
  if (done == BASE_OK) {
    done = solve_cone(src, &r, z, &room, &cone, err);
  }
  free(z);
  if (done == BASE_OK) {
    const bool printed = json_out_print(solve_report(src, s, &r, cone), o->report);
    const bool unproved = o->certificate != NULL && !r.certificate_written;
    const bool good = r.status == RUN_OK && r.verified && !unproved;
    *code = !printed ? CLI_INTERNAL : good ? CLI_OK : CLI_HONEST;
    if (unproved) {
      tell_unproved(s, o->certificate);
    }
  }
  return done;
}

static base_status solve_table(const problem_source *src, const solver_choices *c,
                               const solve_options *o, int *code, base_error *err) {
  solve_all_end end;
  BASE_TRY(solve_all(src, c->item, c->n, isnan(o->time_limit) ? 10.0 : o->time_limit,
                     o->format != NULL ? o->format : "table", o->report, &end, err));
  *code = end.stopped ? cli_stopped() : end.verified ? CLI_OK : CLI_HONEST;
  return BASE_OK;
}

/* The option that looks into one problem, NULL: none is given. */
static const char *of_one_problem(const solve_options *o) {
  const struct {
    const char *name;
    bool given;
  } all[] = {{"--q", o->q != NULL},
             {"--z", o->z != NULL},
             {"--certificate", o->certificate != NULL},
             {"--trace", o->trace != NULL},
             {"--formulation", o->formulation != NULL},
             {"--facets", o->facets != 0},
             {"--solver", is_table(o)}};
  for (int i = 0; i < BASE_COUNT(all); i++) {
    if (all[i].given) {
      return all[i].name;
    }
  }
  return NULL;
}

static base_status solve_passes(const char *problem, const solver_choices *c,
                                const solve_options *o, int *code, base_error *err) {
  const char *single = of_one_problem(o);
  if (single != NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: a sequence is solved by one solver, as it stands",
                     single);
  }
  json_t *report;
  bool good;
  BASE_TRY(solve_sequence(problem, &c->item[0], o->start, &report, &good, err));
  *code = !json_out_print(report, o->report) ? CLI_INTERNAL : good ? CLI_OK : CLI_HONEST;
  return BASE_OK;
}

static base_status solve_problem(const char *problem, const solver_choices *c, solve_options *o,
                                 int *code, base_error *err) {
  problem_source src = {0};
  if (o->start != NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "--start %s: is of a sequence, and %s is none", o->start,
                     problem);
  }
  BASE_TRY(choose_pose(o, err));
  base_status done = problem_source_open(problem, o->q, o->facets, &src, err);
  if (done == BASE_OK && o->formulation != NULL && !problem_source_has_cone(&src)) {
    done = BASE_FAIL(err, BASE_EINVAL, "--formulation %s: %s is no friction problem",
                     o->formulation, problem);
  }
  if (done == BASE_OK) {
    done = is_table(o) ? solve_table(&src, c, o, code, err)
                       : solve_and_print(&src, &c->item[0], o, code, err);
  }
  problem_source_close(&src);
  return done;
}

static const arg_option options[] = {
    ARG(solve_options, solver, "--solver", ARG_LIST, "SOLVER|all",
        "solver with its options behind a colon; all, or more than one, give a table",
        .needed = true),
    ARG(solve_options, format, "--format", ARG_TEXT, "table|csv|json",
        "format of the table; table where none is given"),
    ARG(solve_options, time_limit, "--time-limit", ARG_SECONDS, "T",
        "wall time of each solver of a table; 10 s where none is given", .unit = "s",
        .above = true),
    ARG(solve_options, q, "--q", ARG_TEXT, "FILE",
        "vector q of a Matrix Market problem; NAME.q.mtx beside NAME.M.mtx where none is given"),
    ARG(solve_options, tol, "--tol", ARG_TEXT, "T", "residual to stop at, the solver's option tol",
        .unit = "1"),
    ARG(solve_options, max_iter, "--max-iter", ARG_TEXT, "N",
        "iterations at most, the solver's option max_iter", .unit = "1"),
    ARG(solve_options, formulation, "--formulation", ARG_TEXT, "coulomb|velocity",
        "poses a friction problem on the exact cone, or on facets"),
    ARG(solve_options, facets, "--facets", ARG_INT, "N",
        "facets of the polyhedral cone of a friction problem", .unit = "1", .min = 2),
    ARG(solve_options, z, "--z", ARG_OUTPUT, "FILE",
        "file that gets the answer, as a Matrix Market vector"),
    ARG(solve_options, certificate, "--certificate", ARG_OUTPUT, "FILE",
        "file that gets a proof which verify checks without a solver"),
    ARG(solve_options, start, "--start", ARG_TEXT, "cold|previous|basis|predicted",
        "of each problem of a sequence: zero, the last answer, the last basis, or a line through "
        "the last two"),
    ARG(solve_options, trace, "--trace", ARG_OUTPUT, "FILE.csv", "history of the solve"),
};
static const arg_table args = {
    options,   BASE_COUNT(options),
    1,         1,
    "PROBLEM", "family with its parameters, problem file, or sequence; - is standard input"};

static int run(int argc, char **argv) {
  solve_options o = {.time_limit = (double)NAN};
  const char *problem;
  int n_positional;
  base_error err = {0};
  if (args_parse(&args, &o, argc, argv, &problem, &n_positional, &err) != BASE_OK) {
    return cli_report(&err);
  }
  o.report = args_take_stdout(&args, &o) ? stderr : stdout;
  solver_choices s = {0};
  int code = CLI_INTERNAL;
  base_status done = check_table(&o, &err);
  if (done == BASE_OK) {
    done = choose_all(&o, &s, &err);
  }
  if (done == BASE_OK) {
    done = sequence_is(problem) ? solve_passes(problem, &s, &o, &code, &err)
                                : solve_problem(problem, &s, &o, &code, &err);
  }
  free_all(&s);
  return (done == BASE_OK) ? code : cli_report(&err);
}

extern const cli_verb verb_solve;
const cli_verb verb_solve = {
    .name = "solve",
    .args = &args,
    .help =
        "solves one problem (file or family) and prints one JSON object; by all solvers, a table",
    .run = run,
};
