/* lcpbench conform: a plug-in (or a solver of the build) tried on everything that it declares. */
#include "harness/check/conform.h"
#include "harness/choice/plugins.h"
#include "harness/cli/cli.h"
#include "harness/cli/help.h"
#include "harness/measure/solve_once.h"
#include "harness/util/stop.h"

#include <stdlib.h>
#include <string.h>

typedef struct conform_options {
  bool json, verbose;
  double time_limit;
} conform_options;

static const arg_option options[] = {
    ARG(conform_options, time_limit, "--time-limit", ARG_SECONDS, "T",
        "limit of one problem; 10 s where none is given", .unit = "s", .above = true),
    ARG(conform_options, json, "--json", ARG_FLAG, NULL,
        "prints one JSON object instead of lines, what the solver declares left out"),
    ARG(conform_options, verbose, "--verbose", ARG_FLAG, NULL, "prints the checks that held, too"),
};
static const arg_table args = {
    options, BASE_COUNT(options),
    1,       1,
    "FILE",  "a plug-in (FILE.so, with a / or the ending .so), or the name of a solver"};

static bool is_file(const char *text) {
  const size_t n = strlen(text);
  return strchr(text, '/') != NULL || (n > 3 && strcmp(text + n - 3, ".so") == 0);
}

/* The solver that `text` names; a file is loaded first, and known by its real path. */
static base_status choose(const char *text, solver_choice *out, base_error *err) {
  if (!is_file(text)) {
    return solver_choose(text, out, err);
  }
  BASE_TRY(plugins_take(text, err));
  const plugin_file *f = NULL;
  char *path = realpath(text, NULL);
  for (int i = 0; path != NULL && (f = plugins_at(i)) != NULL && strcmp(f->path, path) != 0; i++) {
  }
  free(path);
  return (f != NULL) ? solver_choose(f->solver->name, out, err)
                     : BASE_FAIL(err, BASE_EIO, "plug-in %.200s: it went away", text);
}

static void describe(const solver_choice *c) {
  const lcp_solver *s = c->solver;
  const plugin_file *f = plugins_of(s);
  (void)printf("%s: %s\n  %s\n  %s\n  sets:", s->name, s->title, s->words, s->when);
  for (int k = 0; lcp_set_name(k) != NULL; k++) {
    (void)printf("%s%s", (s->sets >> k & 1u) != 0 ? " " : "",
                 (s->sets >> k & 1u) != 0 ? lcp_set_name(k) : "");
  }
  (void)printf("; storages:");
  for (int k = LCP_DENSE; k <= LCP_FACTORED; k++) {
    (void)printf("%s%s", (s->storages >> k & 1u) != 0 ? " " : "",
                 (s->storages >> k & 1u) != 0 ? storage_name((lcp_storage)k) : "");
  }
  (void)printf("; %s, %s start\n", s->exact ? "exact" : "iterative", s->warm ? "warm" : "cold");
  if (f != NULL) {
    (void)printf("  version %.16s (%s)\n", f->sha256, f->path);
  }
  help_fields(stdout, s->fields, s->n_fields);
}

static int conform(const conform_options *o, check_plan *plan, const char *text) {
  base_error err = {0};
  plan->limits = (isolate_limits){
      .wall = o->time_limit, .grace = 1.0, .memory = 2147483648.0, .output = 1048576.0, .cpu = -1};
  base_status done = choose(text, &plan->solver[0], &err);
  if (done == BASE_OK) {
    plan->n_solver = 1;
    if (!o->json) {
      describe(&plan->solver[0]);
      (void)fflush(stdout); /* before processes are forked */
    }
    done = conform_solver(plan, &err);
    solver_choice_free(&plan->solver[0]);
  }
  if (done != BASE_OK) {
    json_decref(plan->report->all);
    return cli_report(&err);
  }
  const check_report *r = plan->report;
  if (r->count[CHECK_PASSED] + r->count[CHECK_FAILED] == 0) {
    json_decref(r->all);
    (void)BASE_FAIL(&err, BASE_EUNSUPPORTED, "conform: nothing to try on what %.100s declares",
                    text);
    return cli_report(&err);
  }
  const bool printed = check_report_close(plan->report);
  if (stop_requested() != 0) {
    return cli_stopped();
  }
  return !printed ? CLI_INTERNAL : (r->count[CHECK_FAILED] == 0) ? CLI_OK : CLI_HONEST;
}

static int run(int argc, char **argv) {
  conform_options o = {.time_limit = 10.0};
  const char *text;
  int n_positional;
  base_error err = {0};
  if (args_parse(&args, &o, argc, argv, &text, &n_positional, &err) != BASE_OK) {
    return cli_report(&err);
  }
  stop_catch_signals();
  check_report report;
  check_plan *plan = calloc(1, sizeof *plan);
  if (plan == NULL) {
    (void)BASE_FAIL(&err, BASE_ENOMEM, "conform: no memory");
    return cli_report(&err);
  }
  plan->report = &report;
  check_report_open(&report, o.json, o.verbose);
  const int code = conform(&o, plan, text);
  free(plan);
  return code;
}

extern const cli_verb verb_conform;
const cli_verb verb_conform = {
    .name = "conform",
    .args = &args,
    .help =
        "tries a plug-in on small problems of everything that it declares, each in a process of "
        "its own, and says what it can do",
    .run = run,
};
