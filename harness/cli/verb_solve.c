/* lcpbench solve: one complementarity problem, one solver, one JSON object. */
#include "harness/cli/cli.h"
#include "harness/measure/problem_source.h"
#include "harness/measure/solve_once.h"
#include "harness/measure/trace.h"
#include "harness/util/args.h"
#include "harness/util/json_out.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

typedef struct solve_options {
  const char *solver, *q, *tol, *max_iter, *z, *certificate, *formulation, *trace;
  int facets;
  FILE *report; /* where the JSON object goes */
} solve_options;

static base_status choose(const solve_options *o, solver_choice *s, base_error *err) {
  BASE_TRY(solver_choose(o->solver, s, err));
  if (o->tol != NULL) {
    BASE_TRY(solver_choice_set(s, "tol", o->tol, err));
  }
  if (o->max_iter != NULL) {
    BASE_TRY(solver_choice_set(s, "max_iter", o->max_iter, err));
  }
  return BASE_OK;
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

static void put_verdict(json_t *o, const solve_record *r) {
  const lcp_verdict *v = &r->verdict;
  const bool judged = r->has_claim;
  json_out_text(o, "status", run_status_name(r->status));
  json_out_text(o, "claimed", judged ? lcp_outcome_name(r->claim.outcome) : NULL);
  json_out_bool(o, "verified", r->verified);
  json_out_real(o, "rho", judged ? v->rho : HUGE_VAL);
  json_out_real(o, "res_natural", judged ? v->natural : HUGE_VAL);
  json_out_real(o, "res_natural_rel", judged ? v->natural_rel : HUGE_VAL);
  json_out_real(o, "res_comp", judged ? v->comp : HUGE_VAL);
}

/* Of a friction problem: how far the answer is from the true cone, whatever it was posed on. */
static base_status put_cone(json_t *o, const problem_source *src, const solve_record *r,
                            const double *z, base_error *err) {
  lcp_verdict v = {.natural = HUGE_VAL, .natural_rel = HUGE_VAL, .infeasible_z = HUGE_VAL};
  if (!problem_source_has_cone(src)) {
    return BASE_OK;
  }
  if (r->has_claim) {
    BASE_TRY(problem_source_judge_cone(src, z, &v, err));
  }
  json_out_real(o, "res_ncp", v.natural);
  json_out_real(o, "res_ncp_rel", v.natural_rel);
  json_out_real(o, "cone_violation_Ns", v.infeasible_z);
  return BASE_OK;
}

/* null: the solver handed over none, or it is of a problem whose certificates are not checked. */
static void put_certificate(json_t *o, const solve_record *r) {
  const lcp_certificate_verdict *v = &r->certificate;
  json_out_text(o, "certificate", certificate_name(r->claim.certificate.kind));
  if (r->certificate_checked) {
    json_out_bool(o, "certificate_holds", v->holds);
    json_out_bool(o, "certificate_exact", v->exact);
  } else {
    json_out_text(o, "certificate_holds", NULL);
    json_out_text(o, "certificate_exact", NULL);
  }
  json_out_text(o, "certificate_why", r->certificate_checked ? v->why : NULL);
}

static json_t *to_json(const problem_source *src, const solver_choice *s, const solve_record *r) {
  assert(s->solver != NULL);
  json_t *o = json_object();
  const lcp_work *w = &r->claim.work;
  json_out_text(o, "problem", src->name);
  json_out_int(o, "n", src->p->M.n);
  json_out_int(o, "nnz", lcp_matrix_entries(&src->p->M));
  json_out_text(o, "storage", storage_name(src->p->M.storage));
  json_out_text(o, "solver", s->solver->name);
  json_out_text(o, "options", s->config);
  json_out_text(o, "variant", r->claim.variant);
  put_verdict(o, r);
  json_out_int(o, "n_iter", w->iterations);
  json_out_int(o, "n_pivot", w->pivots);
  json_out_int(o, "n_factor", w->factorizations);
  json_out_int(o, "n_matvec", w->matvecs);
  json_out_int(o, "n_fallback", w->fallbacks);
  json_out_real(o, "t_setup_s", r->time.setup);
  json_out_real(o, "t_factor_s", r->time.factor);
  json_out_real(o, "t_solve_s", r->time.solve);
  put_certificate(o, r);
  char hash[24];
  (void)snprintf(hash, sizeof hash, "%016llx", (unsigned long long)r->hash);
  json_out_text(o, "solution_hash", r->has_claim ? hash : NULL);
  json_out_text(o, "note", r->note);
  return o;
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

static base_status solve_and_print(const problem_source *src, const solver_choice *s,
                                   const solve_options *o, int *code, base_error *err) {
  const int n = src->p->M.n;
  double *z = calloc((size_t)n + 1, sizeof *z);
  if (z == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for the answer", src->name);
  }
  solve_record r;
  base_status done = solve_traced(src, s, o, z, &r, err);
  if (done == BASE_OK && o->z != NULL && r.has_claim) {
    done = lcp_write_mtx_vector(o->z, n, z, err);
  }
  json_t *report = (done == BASE_OK) ? to_json(src, s, &r) : NULL;
  if (done == BASE_OK) {
    done = put_cone(report, src, &r, z, err);
  }
  free(z);
  if (done != BASE_OK) {
    json_decref(report);
  } else {
    const bool printed = json_out_print(report, o->report);
    *code = !printed ? CLI_INTERNAL : (r.status == RUN_OK && r.verified) ? CLI_OK : CLI_HONEST;
  }
  return done;
}

static const arg_option options[] = {
    ARG(solve_options, solver, "--solver", ARG_TEXT, "SOLVER",
        "solver with its options behind a colon", .needed = true),
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
    ARG(solve_options, trace, "--trace", ARG_OUTPUT, "FILE.csv", "history of the solve"),
};
static const arg_table args = {
    options,   BASE_COUNT(options),
    1,         1,
    "PROBLEM", "family with its parameters, or problem file; - is standard input"};

static int run(int argc, char **argv) {
  solve_options o = {0};
  const char *problem;
  int n_positional;
  base_error err = {0};
  if (args_parse(&args, &o, argc, argv, &problem, &n_positional, &err) != BASE_OK) {
    return cli_report(&err);
  }
  o.report = args_take_stdout(&args, &o) ? stderr : stdout;
  solver_choice s = {0};
  problem_source src = {0};
  int code = CLI_INTERNAL;
  base_status done = choose(&o, &s, &err);
  if (done == BASE_OK) {
    done = choose_pose(&o, &err);
  }
  if (done == BASE_OK) {
    done = problem_source_open(problem, o.q, o.facets, &src, &err);
  }
  if (done == BASE_OK && o.formulation != NULL && !problem_source_has_cone(&src)) {
    done = BASE_FAIL(&err, BASE_EINVAL, "--formulation %s: %s is no friction problem",
                     o.formulation, problem);
  }
  if (done == BASE_OK) {
    done = solve_and_print(&src, &s, &o, &code, &err);
  }
  problem_source_close(&src);
  solver_choice_free(&s);
  return (done == BASE_OK) ? code : cli_report(&err);
}

extern const cli_verb verb_solve;
const cli_verb verb_solve = {
    .name = "solve",
    .args = &args,
    .help = "solves one problem (file or family) and prints one JSON object",
    .run = run,
};
