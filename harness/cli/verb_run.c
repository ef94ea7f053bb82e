/* lcpbench run: measures a campaign, or goes on with one. */
#include "harness/campaign/budget.h"
#include "harness/campaign/dry_run.h"
#include "harness/campaign/runner.h"
#include "harness/cli/cli.h"
#include "harness/measure/registry.h"
#include "harness/measure/verdict.h"
#include "harness/util/stop.h"
#include "lcp/base/fields.h"
#include "lcp/base/nearest.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { NOT_GIVEN = INT_MIN };

typedef struct run_options {
  const char *out, *like, *shard, *rerun, *cache, *solutions, *stage;
  plan_filter filter;
  int reps;
  int seed;
  double time_limit, memory_limit, budget;
  bool dry_run, resume, quick, quiet, strict, no_pin, trace;
} run_options;

static base_status parse_shard(const char *text, plan_filter *f, base_error *err) {
  if (text == NULL) {
    return BASE_OK;
  }
  char first[16];
  const size_t len = strcspn(text, "/");
  (void)snprintf(first, sizeof first, "%.*s", (int)len, text);
  if (text[len] != '/' || !base_parse_int(first, &f->shard) ||
      !base_parse_int(text + len + 1, &f->n_shard) || f->shard < 1 || f->shard > f->n_shard) {
    return BASE_FAIL(err, BASE_EINVAL, "--shard %s: need k/n with 1 <= k <= n", text);
  }
  return BASE_OK;
}

static base_status parse_rerun(const char *text, runner_options *o, base_error *err) {
  static const char *const words[] = {"", "failed", "timeouts", "all"};
  if (text == NULL) {
    return BASE_OK;
  }
  for (int i = 1; i < BASE_COUNT(words); i++) {
    if (strcmp(words[i], text) == 0) {
      o->rerun = (rerun_what)i;
      return BASE_OK;
    }
  }
  o->rerun = RERUN_SOLVER;
  o->rerun_solver = text;
  if (registry_solver_find(text) != NULL) {
    return BASE_OK;
  }
  char hint[BASE_NEAREST_HINT];
  base_nearest near = base_nearest_to(text, strlen(text));
  base_nearest_offer_words(&near, "failed|timeouts|all");
  for (int i = 0; registry_solver(i) != NULL; i++) {
    base_nearest_offer(&near, registry_solver(i)->name);
  }
  return BASE_FAIL(err, BASE_EINVAL, "--rerun %.100s: need failed, timeouts, all or a solver%s",
                   text, base_nearest_hint(&near, hint));
}

/* One of two words, where the option is given. */
static base_status choice(const char *name, const char *text, const char *no, const char *yes,
                          bool *out, base_error *err) {
  if (text != NULL && strcmp(text, no) != 0 && strcmp(text, yes) != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%s %s: need %s or %s", name, text, no, yes);
  }
  *out = (text != NULL) ? strcmp(text, yes) == 0 : *out;
  return BASE_OK;
}

static base_status check_out(const run_options *o, base_error *err) {
  if (o->out != NULL && o->out[0] == '\0') {
    return BASE_FAIL(err, BASE_EINVAL, "--out: need a folder");
  }
  return BASE_OK;
}

static base_status override(const run_options *o, campaign *c, base_error *err) {
  if (o->reps != NOT_GIVEN) {
    c->sampling.samples = o->reps;
    c->sampling.max_samples = o->reps;
  }
  BASE_TRY(choice("--cache", o->cache, "warm", "cold", &c->sampling.cold, err));
  BASE_TRY(choice("--solutions", o->solutions, "off", "on", &c->solutions, err));
  c->trace = c->trace || o->trace;
  c->seed = (o->seed != NOT_GIVEN) ? (uint64_t)o->seed : c->seed;
  c->limits.time = (o->time_limit != NOT_GIVEN) ? o->time_limit : c->limits.time;
  c->limits.memory = (o->memory_limit != NOT_GIVEN) ? o->memory_limit : c->limits.memory;
  return BASE_OK;
}

/* ---- run --------------------------------------------------------------------------------------*/

static void print_summary(const runner_summary *s, const char *out) {
  (void)printf("%s/results.csv: %d processes, %d measured now, %d done before, %d rows added", out,
               s->units, s->measured, s->resumed, s->rows);
  if (s->stale > 0) {
    (void)printf(", %d stale rows moved to stale.csv", s->stale);
  }
  (void)printf("; harness %.1f %% of %.3g s\n",
               s->wall > 0 ? 100.0 * (1.0 - s->inside / s->wall) : 0.0, s->wall);
  if (s->left > 0 && !s->interrupted) {
    (void)printf("  cut: %d processes are left; a later run goes on\n", s->left);
  }
  for (int i = 0; i < RUN_STATUS_COUNT; i++) {
    if (s->by_status[i] > 0) {
      (void)printf("  %-11s %d cells\n", run_status_name((run_status)i), s->by_status[i]);
    }
  }
}

static int exit_code(const runner_summary *s, bool strict) {
  if (s->interrupted) {
    return cli_stopped();
  }
  if (s->left > 0) {
    return CLI_INTERRUPTED;
  }
  int bad = 0;
  for (int i = 0; i < RUN_STATUS_COUNT; i++) {
    bad += (i != RUN_OK && i != RUN_UNSUPPORTED && i != RUN_SKIPPED) ? s->by_status[i] : 0;
  }
  return (strict && bad > 0) ? CLI_HONEST : CLI_OK;
}

static base_status measure(const plan *p, const run_options *o, const runner_options *ro, int *code,
                           base_error *err) {
  runner_summary sum;
  BASE_TRY(runner_run(p, ro, &sum, err));
  print_summary(&sum, ro->out);
  *code = exit_code(&sum, o->strict);
  return BASE_OK;
}

static base_status run_campaign(const char *text, const run_options *o, int *code,
                                base_error *err) {
  char out[600];
  runner_options ro = {.filter = &o->filter,
                       .pin = !o->no_pin,
                       .quiet = o->quiet,
                       .canary_every = 120.0,
                       .budget = (o->budget != NOT_GIVEN) ? o->budget : 0.0};
  cover_stage last = COVER_rest;
  BASE_TRY(parse_rerun(o->rerun, &ro, err));
  BASE_TRY(o->stage != NULL ? cover_stage_find(o->stage, &last, err) : BASE_OK);
  campaign c;
  BASE_TRY(campaign_read(text, o->quick, &c, err));
  (void)snprintf(out, sizeof out, "results/%.48s%s", c.name, o->quick ? "-quick" : "");
  ro.out = (o->out != NULL) ? o->out : out;
  plan p;
  cover order = {0};
  base_status done = override(o, &c, err);
  ro.solutions = c.solutions;
  ro.trace = c.trace;
  if (done == BASE_OK) {
    done = plan_make(&c, &o->filter, &p, err);
    ro.units = p.n_unit;
    if (done == BASE_OK && ro.budget > 0.0) {
      done = budget_order(&p, text, o->like, &order, err);
      ro.order = &order;
      ro.units = cover_until(&order, last) * c.sampling.processes;
    }
    if (done == BASE_OK) {
      *code = CLI_OK;
      done = o->dry_run ? dry_run(&p, &ro, o->like, err) : measure(&p, o, &ro, code, err);
    }
    cover_free(&order);
    plan_free(&p);
  }
  campaign_free(&c);
  return done;
}

static const arg_option options[] = {
    ARG(run_options, out, "--out", ARG_TEXT, "DIR",
        "folder of the rows; results/NAME where none is given"),
    ARG(run_options, filter.filter, "--filter", ARG_LIST, "AXIS=GLOB",
        "measures only what matches; may be repeated"),
    ARG(run_options, reps, "--reps", ARG_INT, "N",
        "repetitions of each process, instead of the campaign's rule", .unit = "1", .min = 1),
    ARG(run_options, time_limit, "--time-limit", ARG_SECONDS, "T",
        "wall time of one process, instead of the campaign's", .unit = "s", .above = true),
    ARG(run_options, memory_limit, "--memory-limit", ARG_BYTES, "B",
        "address space of one process, instead of the campaign's", .unit = "B"),
    ARG(run_options, seed, "--seed", ARG_INT, "N", "seed of the order of the processes",
        .unit = "1"),
    ARG(run_options, shard, "--shard", ARG_TEXT, "k/n",
        "measures the k-th of n shares of the problems"),
    ARG(run_options, dry_run, "--dry-run", ARG_FLAG, NULL,
        "prints what would be measured and how long it takes"),
    ARG(run_options, like, "--like", ARG_TEXT, "DIR",
        "earlier rows, packed or not, that tell --dry-run and --budget how long cells take"),
    ARG(run_options, budget, "--budget", ARG_SECONDS, "T",
        "begins no process after this time, and takes the cells in an order that keeps every axis",
        .unit = "s", .above = true),
    ARG(run_options, stage, "--stage", ARG_TEXT, "quick|values|pairs|rest",
        "with --budget: the last stage of that order from which cells are taken"),
    ARG(run_options, rerun, "--rerun", ARG_TEXT, "failed|timeouts|all|SOLVER",
        "measures these cells again"),
    ARG(run_options, resume, "--resume", ARG_FLAG, NULL,
        "goes on with the rows that are there, as it does without it"),
    ARG(run_options, quick, "--quick", ARG_FLAG, NULL, "takes the quick form of the campaign"),
    ARG(run_options, quiet, "--quiet", ARG_FLAG, NULL, "shows no progress"),
    ARG(run_options, strict, "--strict", ARG_FLAG, NULL, "ends with code 3 where a cell is not ok"),
    ARG(run_options, no_pin, "--no-pin", ARG_FLAG, NULL, "lets the system choose the processor"),
    ARG(run_options, cache, "--cache", ARG_TEXT, "warm|cold",
        "state of the caches before each repetition"),
    ARG(run_options, solutions, "--solutions", ARG_TEXT, "on|off",
        "stores the answers, for verify"),
    ARG(run_options, trace, "--trace", ARG_FLAG, NULL,
        "records the history of each cell by an untimed twin"),
};
static const arg_table args = {options, BASE_COUNT(options), 1,
                               1,       "CAMPAIGN",          "shipped campaign, or a .yaml file"};

static int run(int argc, char **argv) {
  run_options o = {.reps = NOT_GIVEN,
                   .seed = NOT_GIVEN,
                   .time_limit = NOT_GIVEN,
                   .memory_limit = NOT_GIVEN,
                   .budget = NOT_GIVEN};
  const char *text;
  int n_positional;
  base_error err = {0};
  int code = CLI_INTERNAL;
  base_status done = args_parse(&args, &o, argc, argv, &text, &n_positional, &err);
  if (done == BASE_OK) {
    done = check_out(&o, &err);
  }
  if (done == BASE_OK && o.like != NULL && !o.dry_run && o.budget == NOT_GIVEN) {
    done = BASE_FAIL(&err, BASE_EINVAL, "--like %s: tells --dry-run and --budget only", o.like);
  }
  if (done == BASE_OK && o.stage != NULL && o.budget == NOT_GIVEN) {
    done = BASE_FAIL(&err, BASE_EINVAL, "--stage %s: is one of the order of --budget", o.stage);
  }
  if (done == BASE_OK && o.rerun != NULL && o.budget != NOT_GIVEN) {
    done = BASE_FAIL(
        &err, BASE_EINVAL,
        "--rerun %s: sets rows aside each time, which --budget would not come to measure", o.rerun);
  }
  if (done == BASE_OK) {
    done = parse_shard(o.shard, &o.filter, &err);
  }
  if (done == BASE_OK) {
    stop_catch_signals();
    (void)setenv("OPENBLAS_NUM_THREADS", "1", 1);
    (void)setenv("OMP_NUM_THREADS", "1", 1);
    done = run_campaign(text, &o, &code, &err);
  }
  if (done != BASE_OK && stop_requested() != 0) {
    (void)cli_report(&err); /* stopped while it waited for another run */
    return cli_stopped();
  }
  return (done == BASE_OK) ? code : cli_report(&err);
}

extern const cli_verb verb_run;
const cli_verb verb_run = {
    .name = "run",
    .args = &args,
    .help = "measures a campaign (a shipped name or a .yaml file), or goes on with it",
    .run = run,
};
