/* lcpbench check: every case of a file with everything that applies, judged by its own rules. */
#include "harness/check/check_run.h"
#include "harness/cli/cli.h"
#include "harness/util/args.h"
#include "harness/util/stop.h"

#include <stdlib.h>
#include <string.h>

typedef struct check_options {
  const char *step;
  arg_list filter, solver, formulation;
  bool json, verbose;
  double time_limit;
} check_options;

static base_status choose_solvers(const check_options *o, check_plan *plan, base_error *err) {
  const bool all = o->solver.count == 1 && strcmp(o->solver.item[0], "all") == 0;
  plan->default_solvers = o->solver.count == 0;
  for (int i = 0; !all && i < o->solver.count; i++) {
    BASE_TRY(solver_choose(o->solver.item[i], &plan->solver[plan->n_solver], err));
    plan->n_solver++;
  }
  const lcp_solver *s;
  for (int i = 0; (all || plan->default_solvers) && (s = registry_solver(i)) != NULL; i++) {
    if (plan->n_solver == CHECK_CHOICES) {
      return BASE_FAIL(err, BASE_EINVAL, "check: more than %d solvers", CHECK_CHOICES);
    }
    solver_choice *c = &plan->solver[plan->n_solver];
    BASE_TRY(solver_choose(s->name, c, err));
    plan->n_solver++;
    if (strcmp(s->name, "nsgs") == 0) { /* scenes have the tolerances of an exact method */
      BASE_TRY(solver_choice_set(c, "tol", "1e-12", err));
      BASE_TRY(solver_choice_set(c, "max_iter", "100000", err));
    }
  }
  return BASE_OK;
}

static base_status choose_formulations(const check_options *o, check_plan *plan, base_error *err) {
  for (int i = 0; i < o->formulation.count; i++) {
    BASE_TRY(formulation_choose(o->formulation.item[i], &plan->form[plan->n_form], err));
    plan->n_form++;
  }
  int count;
  const formulation *const *all = formulations(&count);
  for (int i = 0; o->formulation.count == 0 && i < count && i < CHECK_CHOICES; i++) {
    BASE_TRY(formulation_choose(all[i]->name, &plan->form[plan->n_form], err));
    plan->n_form++;
  }
  return BASE_OK;
}

static base_status make_plan(const check_options *o, check_plan *plan, base_error *err) {
  plan->id_glob = "*";
  for (int i = 0; i < o->filter.count; i++) {
    if (strncmp(o->filter.item[i], "id=", 3) != 0 || i > 0) {
      return BASE_FAIL(err, BASE_EINVAL, "--filter %s: need one id=GLOB", o->filter.item[i]);
    }
    plan->id_glob = o->filter.item[i] + 3;
  }
  if (o->step != NULL && (!base_parse_real(o->step, &plan->step) || !(plan->step > 0.0))) {
    return BASE_FAIL(err, BASE_EINVAL, "--step %s: need a number above 0", o->step);
  }
  if (!(o->time_limit > 0.0)) {
    return BASE_FAIL(err, BASE_EINVAL, "--time-limit: need a time above 0");
  }
  plan->limits =
      (isolate_limits){.wall = o->time_limit, .grace = 2.0, .output = 1048576.0, .cpu = -1};
  BASE_TRY(choose_solvers(o, plan, err));
  return choose_formulations(o, plan, err);
}

static void free_plan(check_plan *plan) {
  for (int i = 0; i < plan->n_solver; i++) {
    solver_choice_free(&plan->solver[i]);
  }
  for (int i = 0; i < plan->n_form; i++) {
    formulation_choice_free(&plan->form[i]);
  }
}

static base_status run_lcps(const check_plan *plan, const case_file *f, base_error *err) {
  for (int i = 0; i < f->n_lcp; i++) {
    if (!check_selected(plan, f->lcp[i].id)) {
      continue;
    }
    BASE_TRY(check_lcp_case(plan, &f->lcp[i], err));
  }
  return BASE_OK;
}

static base_status run_scenes(const check_plan *plan, const case_file *f, base_error *err) {
  for (int i = 0; i < f->scenes.n_scene; i++) {
    const scene_spec *s = &f->scenes.scene[i];
    base_error why = {0};
    if (!check_selected(plan, s->id)) {
      continue;
    }
    if (formulation_words(s, &why) != BASE_OK) {
      check_refuse(plan, s->id, why.text);
      continue;
    }
    BASE_TRY(check_scene_case(plan, s, err));
  }
  for (int i = 0; i < f->scenes.n_failed; i++) {
    if (check_selected(plan, f->scenes.failed[i].id)) {
      check_refuse(plan, f->scenes.failed[i].id, f->scenes.failed[i].err.text);
    }
  }
  return BASE_OK;
}

static base_status run_cases(const check_plan *plan, const case_file *f, base_error *err) {
  BASE_TRY(run_lcps(plan, f, err));
  BASE_TRY(run_scenes(plan, f, err));
  for (int i = 0; i < f->n_equivalence; i++) {
    if (!check_selected(plan, f->equivalence[i].id)) {
      continue;
    }
    BASE_TRY(check_equivalence(plan, &f->equivalence[i], &f->scenes, err));
  }
  return BASE_OK;
}

static base_status run_file(const check_plan *plan, const char *path, base_error *err) {
  case_file f;
  BASE_TRY(case_file_read(path, &f, err));
  const base_status done = run_cases(plan, &f, err);
  case_file_free(&f);
  return done;
}

static const arg_option options[] = {
    ARG(check_options, filter, "--filter", ARG_LIST, "id=GLOB",
        "judges the cases whose id matches; may be repeated"),
    ARG(check_options, solver, "--solver", ARG_LIST, "SOLVER",
        "judges with this solver, all for each of them; may be repeated"),
    ARG(check_options, formulation, "--formulation", ARG_LIST, "FORMULATION",
        "judges scenes with this formulation; may be repeated"),
    ARG(check_options, step, "--step", ARG_TEXT, "H", "step of the scenes instead of their own",
        .unit = "s", .above = true),
    ARG(check_options, time_limit, "--time-limit", ARG_SECONDS, "T",
        "limit of one case; 60 s where none is given", .unit = "s", .above = true),
    ARG(check_options, json, "--json", ARG_FLAG, NULL, "prints one JSON array instead of lines"),
    ARG(check_options, verbose, "--verbose", ARG_FLAG, NULL, "prints the checks that held, too"),
};
static const arg_table args = {
    options, BASE_COUNT(options), 1, 1, "FILE", "case or scene file, JSON or YAML"};

static int run(int argc, char **argv) {
  check_options o = {.time_limit = 60.0};
  const char *path;
  int n_positional;
  base_error err = {0};
  if (args_parse(&args, &o, argc, argv, &path, &n_positional, &err) != BASE_OK) {
    return cli_report(&err);
  }
  stop_catch_signals();
  check_report report;
  check_plan *plan = calloc(1, sizeof *plan);
  if (plan == NULL) {
    (void)BASE_FAIL(&err, BASE_ENOMEM, "check: no memory");
    return cli_report(&err);
  }
  plan->report = &report;
  check_report_open(&report, o.json, o.verbose);
  base_status done = make_plan(&o, plan, &err);
  if (done == BASE_OK) {
    done = run_file(plan, path, &err);
  }
  free_plan(plan);
  free(plan);
  if (done != BASE_OK) {
    json_decref(report.all);
    return cli_report(&err);
  }
  if (report.count[0] + report.count[1] + report.count[2] == 0) {
    json_decref(report.all);
    (void)BASE_FAIL(&err, BASE_EINVAL, "%s: no case matches the filter", path);
    return cli_report(&err);
  }
  const bool printed = check_report_close(&report);
  if (stop_requested() != 0) {
    return cli_stopped();
  }
  return !printed ? CLI_INTERNAL : (report.count[CHECK_FAILED] == 0) ? CLI_OK : CLI_HONEST;
}

extern const cli_verb verb_check;
const cli_verb verb_check = {
    .name = "check",
    .args = &args,
    .help = "judges every LCP (by all solvers) and scene (by lemke, nsgs on cones; --solver all: "
            "by all)"
            " of a case file by the file's own tolerances",
    .run = run,
};
