/* lcpbench submit: a campaign as shards for GNU parallel or a Slurm job array. The engine only starts
 * `lcpbench run --shard k/n`; which one it was cannot change a row. */
#include "harness/campaign/runner.h"
#include "harness/choice/plugins.h"
#include "harness/cli/cli.h"
#include "harness/plan/campaign.h"
#include "harness/util/args.h"
#include "harness/util/folder.h"
#include "harness/util/shell.h"
#include "lcp/base/output.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { NOT_GIVEN = INT_MIN };

typedef struct submit_options {
  const char *engine, *out;
  int shards, jobs;
  bool dry_run, quick, wait;
  const char *slurm_time;
  bool slurm; /* the engine */
} submit_options;

typedef struct submission {
  char exe[1024], dir[1024], script[1100];
  const char *campaign;
  const submit_options *o;
} submission;

static base_status absolute(const char *path, char *out, size_t cap, base_error *err) {
  char *real = realpath(path, NULL);
  if (real == NULL) {
    return BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
  }
  const bool fits = strlen(real) < cap;
  (void)snprintf(out, cap, "%s", real);
  free(real);
  return fits ? BASE_OK
              : BASE_FAIL(err, BASE_EINVAL, "%.200s...: longer than %zu characters", out, cap - 1);
}

/* The texts of a submission as words of its script. */
typedef struct script_words {
  char exe[65536], dir[4096 + 64], campaign[4096 + 64]; /* exe: with its plug-ins */
} script_words;

static void quote(const submission *s, script_words *w) {
  const plugin_file *f;
  size_t used = shell_quote(s->exe, w->exe, sizeof w->exe);
  for (int i = 0; (f = plugins_at(i)) != NULL;
       i++) { /* at most 32, of 1 kB each, doubled by quotes at worst */
    used += (size_t)snprintf(w->exe + used, sizeof w->exe - used, " --plugin ");
    used += shell_quote(f->path, w->exe + used, sizeof w->exe - used);
  }
  (void)shell_quote(s->dir, w->dir, sizeof w->dir);
  (void)shell_quote(s->campaign, w->campaign, sizeof w->campaign);
}

/* One task = one shard = some problems with all their solvers, so that solvers are compared on one
 * host. TERM comes 60 s before the limit: the run flushes and exits with 4, and is requeued. */
static void write_slurm(FILE *to, const submission *s, const script_words *w) {
  (void)fprintf(to,
                "#!/bin/sh\n"
                "#SBATCH --job-name=lcpbench\n"
                "#SBATCH --array=1-%d\n"
                "#SBATCH --nodes=1 --ntasks=1 --exclusive\n"
                "#SBATCH --requeue --open-mode=append --signal=B:TERM@60\n"
                "#SBATCH --time=%s\n"
                "#SBATCH --output=%s/slurm.%%a.log\n"
                "%s run %s%s --shard \"$SLURM_ARRAY_TASK_ID/%d\" \\\n"
                "  --out %s/shard.\"$SLURM_ARRAY_TASK_ID\" </dev/null &\n"
                "pid=$!\n"
                "trap 'kill -TERM $pid' TERM\n"
                "wait $pid; code=$?\n"
                "if kill -0 $pid 2>/dev/null; then wait $pid; code=$?; fi\n"
                "if [ $code -eq 4 ]; then\n"
                "  scontrol requeue \"${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID\"\n"
                "fi\n"
                "exit $code\n",
                s->o->shards, s->o->slurm_time, s->dir, w->exe, w->campaign,
                s->o->quick ? " --quick" : "", s->o->shards, w->dir);
}

/* -j1: two shards at a time on one machine would disturb each other's timings. The script starts itself
 * for each of them, so that no path passes through the substitutions of parallel and a second shell. */
static void write_parallel(FILE *to, const submission *s, const script_words *w) {
  (void)fprintf(to,
                "#!/bin/sh\n"
                "# All shards by GNU parallel; with a number as argument: that shard.\n"
                "if [ $# -gt 0 ]; then\n"
                "  exec %s run %s%s --shard \"$1/%d\" --out %s/shard.\"$1\" --quiet </dev/null\n"
                "fi\n"
                "lcpbench_shard=%s/parallel.sh\n"
                "export lcpbench_shard\n"
                "# --resume-failed: started again, it runs what is not done\n"
                "seq %d | parallel -j%d --joblog %s/joblog --resume-failed --halt now,fail=0 \\\n"
                "  'sh \"$lcpbench_shard\" {}'\n",
                w->exe, w->campaign, s->o->quick ? " --quick" : "", s->o->shards, w->dir, w->dir,
                s->o->shards, s->o->jobs, w->dir);
}

static base_status write_script(submission *s, base_error *err) {
  const bool slurm = s->o->slurm;
  script_words words;
  base_out out;
  quote(s, &words);
  folder_file(s->dir, slurm ? "slurm.sh" : "parallel.sh", s->script, sizeof s->script);
  BASE_TRY(base_out_open(&out, s->script, err));
  (slurm ? write_slurm : write_parallel)(out.to, s, &words);
  BASE_TRY(base_out_close(&out, true, err));
  (void)printf("%s\nafterwards: lcpbench merge %s/shard.* --out %s\n", s->script, words.dir,
               words.dir);
  (void)fflush(stdout);
  return (chmod(s->script, 0755) == 0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EIO, "%s: %s", s->script, strerror(errno));
}

static base_status launch(char *const *argv, int *code, base_error *err) {
  const pid_t pid = fork();
  if (pid == 0) {
    (void)execvp(argv[0], argv);
    _exit(127);
  }
  int status = 0;
  if (pid < 0 || waitpid(pid, &status, 0) != pid) {
    return BASE_FAIL(err, BASE_EEXTERNAL, "%s: %s", argv[0], strerror(errno));
  }
  const int exited = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  if (exited == 127) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: not found; install it or choose another engine",
                     argv[0]);
  }
  *code = (exited == 0) ? CLI_OK : CLI_INTERRUPTED;
  return BASE_OK;
}

/* What the script does not quote, because a line of #SBATCH knows no quoting that reaches a log file's
 * name, must be plain. */
static base_status check_texts(const submission *s, base_error *err) {
  if (!shell_can_quote(s->exe) || !shell_can_quote(s->dir) || !shell_can_quote(s->campaign)) {
    return BASE_FAIL(err, BASE_EINVAL, "submit: a path ends with a line break");
  }
  for (const unsigned char *c = (const unsigned char *)s->dir; s->o->slurm && *c != '\0'; c++) {
    if (*c <= ' ' || *c == 0x7f || strchr("'\"\\%", *c) != NULL) {
      return BASE_FAIL(
          err, BASE_EINVAL,
          "--out %.200s: a Slurm script needs a folder without spaces, quotes, \\ and %%", s->dir);
    }
  }
  const char *time = s->o->slurm_time;
  return (time[0] != '\0' && time[strspn(time, "0123456789:-")] == '\0')
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL, "--slurm-time %s: need minutes, HH:MM:SS or D-HH:MM",
                         time);
}

/* Refuses what the engine has no use for; what is not given gets its default. */
static base_status settle_options(submit_options *o, base_error *err) {
  o->slurm = strcmp(o->engine, "slurm") == 0;
  if (!o->slurm && strcmp(o->engine, "parallel") != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "--engine %s: need parallel or slurm", o->engine);
  }
  if (o->slurm ? o->jobs != NOT_GIVEN : o->slurm_time != NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: has no meaning with --engine %s",
                     o->slurm ? "--jobs" : "--slurm-time", o->engine);
  }
  o->jobs = (o->jobs != NOT_GIVEN) ? o->jobs : 1;
  o->slurm_time = (o->slurm_time != NULL) ? o->slurm_time : "04:00:00";
  return BASE_OK;
}

/* The engine's own exit code does not tell: `sbatch --wait` returns 0 for a cancelled array. What
 * counts is which rows are there. */
static base_status look_after(const submission *s, const campaign *c, int *code, base_error *err) {
  int units = 0;
  int missing = 0;
  for (int k = 1; k <= s->o->shards; k++) {
    const plan_filter shard = {.shard = k, .n_shard = s->o->shards};
    char dir[1100];
    plan p;
    int left;
    BASE_TRY(plan_make(c, &shard, &p, err));
    (void)snprintf(dir, sizeof dir, "%s/shard.%d", s->dir, k);
    const base_status done = runner_left(&p, dir, &left, err);
    units += p.n_unit;
    plan_free(&p);
    BASE_TRY(done);
    missing += left;
  }
  (void)printf("%d of %d processes measured%s\n", units - missing, units,
               missing > 0 ? "; the same command goes on with the rest" : "");
  *code = (missing == 0) ? CLI_OK : CLI_INTERRUPTED;
  return BASE_OK;
}

static base_status submit(submission *s, const campaign *c, int *code, base_error *err) {
  const submit_options *o = s->o;
  char dflt[128];
  (void)snprintf(dflt, sizeof dflt, "results/%.48s-shards", c->name);
  const char *dir = (o->out != NULL) ? o->out : dflt;
  BASE_TRY(folder_make(dir, err));
  BASE_TRY(absolute(dir, s->dir, sizeof s->dir, err));
  BASE_TRY(absolute("/proc/self/exe", s->exe, sizeof s->exe, err));
  BASE_TRY(check_texts(s, err));
  BASE_TRY(write_script(s, err));
  *code = CLI_OK;
  if (o->dry_run) {
    return BASE_OK;
  }
  char sbatch[] = "sbatch";
  char wait[] = "--wait";
  char shell[] = "sh";
  char *slurm_argv[] = {sbatch, o->wait ? wait : s->script, o->wait ? s->script : NULL, NULL};
  char *parallel_argv[] = {shell, s->script, NULL};
  BASE_TRY(launch(o->slurm ? slurm_argv : parallel_argv, code, err));
  if (!o->slurm || o->wait) {
    return look_after(s, c, code, err);
  }
  return (*code == CLI_OK) ? BASE_OK
                           : BASE_FAIL(err, BASE_EEXTERNAL,
                                       "sbatch refused %s; nothing was submitted", s->script);
}

static base_status read_and_submit(submission *s, int *code, base_error *err) {
  campaign c;
  BASE_TRY(campaign_read(s->campaign, s->o->quick, &c, err)); /* fails here, not in N logs */
  const base_status done = submit(s, &c, code, err);
  campaign_free(&c);
  return done;
}

static const arg_option options[] = {
    ARG(submit_options, engine, "--engine", ARG_TEXT, "parallel|slurm", "what starts the shards",
        .needed = true),
    ARG(submit_options, shards, "--shards", ARG_INT, "N",
        "shares of the campaign; 1 where none is given", .unit = "1", .min = 1),
    ARG(submit_options, jobs, "--jobs", ARG_INT, "N",
        "shards at a time, of parallel; 1 where none is given", .unit = "1", .min = 1),
    ARG(submit_options, out, "--out", ARG_TEXT, "DIR",
        "folder of the shards; results/NAME-shards where none is given"),
    ARG(submit_options, slurm_time, "--slurm-time", ARG_TEXT, "T",
        "limit of a shard as Slurm takes it; 04:00:00 where none is given"),
    ARG(submit_options, quick, "--quick", ARG_FLAG, NULL, "takes the quick form of the campaign"),
    ARG(submit_options, wait, "--wait", ARG_FLAG, NULL, "waits for the end of a job array"),
    ARG(submit_options, dry_run, "--dry-run", ARG_FLAG, NULL,
        "writes the script and starts nothing"),
};
static const arg_table args = {options, BASE_COUNT(options), 1,
                               1,       "CAMPAIGN",          "shipped campaign, or a .yaml file"};

static int run(int argc, char **argv) {
  submit_options o = {.shards = 1, .jobs = NOT_GIVEN};
  submission s = {.o = &o};
  int n;
  int code = CLI_INTERNAL;
  base_error err = {0};
  base_status done = args_parse(&args, &o, argc, argv, &s.campaign, &n, &err);
  if (done == BASE_OK) {
    done = settle_options(&o, &err);
  }
  if (done == BASE_OK) {
    done = read_and_submit(&s, &code, &err);
  }
  return (done == BASE_OK) ? code : cli_report(&err);
}

extern const cli_verb verb_submit;
const cli_verb verb_submit = {
    .name = "submit",
    .args = &args,
    .help = "writes and starts a campaign as shards for GNU parallel or a Slurm job array",
    .run = run,
};
