/* lcpbench verify: recomputes the verdicts of a campaign folder. The answers stored with it are put
 * back in the place of the solver, and the whole run is judged again from the problem. --rerun starts
 * the command of every row instead, which must give the same verdict, counters and bits; cells
 * without stored answers are rerun in any case. With --certificate: checks that file against
 * a problem. */
#include "harness/campaign/runner.h"
#include "harness/cell/cell_run.h"
#include "harness/cli/cli.h"
#include "harness/cli/verify_certificate.h"
#include "harness/measure/verdict.h"
#include "harness/plan/cell_command.h"
#include "harness/plan/plan_key.h"
#include "harness/util/args.h"
#include "harness/util/json_out.h"
#include "harness/util/shell.h"
#include "harness/util/versions.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* ---- stored answers ---------------------------------------------------------------------------*/

static bool same_real(double a, double b) {
  return a == b ||
         (!isfinite(a) && !isfinite(b)); /* not measured is written for what is not finite */
}

/* Whose the row is, every verdict of it, and the bits they were made of. */
static bool same_verdicts(const record *row, const record *again, char *why, size_t cap) {
  const struct {
    const char *name, *was, *is;
  } words[] = {{"formulation", row->formulation, again->formulation},
               {"solver", row->solver, again->solver},
               {"status", row->status, again->status},
               {"status_claimed", row->status_claimed, again->status_claimed},
               {"solution_hash", row->solution_hash, again->solution_hash},
               {"effects_seen", row->effects_seen, again->effects_seen}};
  static const char *const reals[] = {
      "rho",           "res_natural",     "res_natural_rel",  "res_feas_z", "res_feas_w",
      "res_comp",      "res_ncp",         "res_ncp_rel",      "res_cone",   "dissipation_gap_J",
      "penetration_m", "energy_defect_J", "energy_drift_rel", "err_ref",    "err_worst",
      "end_value"};
  for (int i = 0; i < BASE_COUNT(words); i++) {
    if (strcmp(words[i].was, words[i].is) != 0) {
      (void)snprintf(why, cap, "%s is %.80s, the row says %.80s", words[i].name, words[i].is,
                     words[i].was);
      return false;
    }
  }
  for (int i = 0; i < BASE_COUNT(reals); i++) {
    const double was = record_real(row, reals[i]);
    const double is = record_real(again, reals[i]);
    if (!same_real(was, is)) {
      (void)snprintf(why, cap, "%s is %.17g, the row says %.17g", reals[i], is, was);
      return false;
    }
  }
  if (row->verified != again->verified) {
    (void)snprintf(why, cap, "verified is not what the row says");
  }
  return row->verified == again->verified;
}

/* The row that the stored answers imply, from the words of one of the cell's rows. */
static base_status replay(const char *path, const record *row, record *again, base_error *err) {
  char text[sizeof row->command];
  cell c;
  const campaign limits = {.limits.time = row->t_limit_s};
  (void)snprintf(text, sizeof text, "%s", row->command);
  BASE_TRY(cell_of_command(text, &c, err));
  BASE_TRY(cell_file_unchanged(&c, row->problem_sha256, err));
  const cell_job job = {.campaign = &limits, .cell = &c, .mem_node = -1};
  return cell_replay(&job, path, again, err);
}

/* ---- running the command again ----------------------------------------------------------------*/

static json_t *read_json(int fd) {
  FILE *from = fdopen(fd, "r");
  if (from == NULL) {
    (void)close(fd);
    return NULL;
  }
  json_t *o = json_loadf(from, 0, NULL);
  (void)fclose(from);
  return o;
}

static json_t *run_again(const char *command) {
  char text[1300];
  char *word[CELL_WORDS];
  int fd[2];
  (void)snprintf(text, sizeof text, "%s", command);
  if (shell_split(text, word, CELL_WORDS) < 3 || pipe2(fd, O_CLOEXEC) != 0) {
    return NULL;
  }
  const pid_t pid = fork();
  if (pid == 0) {
    const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
    (void)dup2(fd[1], STDOUT_FILENO);
    (void)dup2(null, STDERR_FILENO);
    (void)execv("/proc/self/exe", word);
    _exit(127);
  }
  (void)close(fd[1]);
  json_t *o = read_json(fd[0]);
  if (pid > 0) {
    (void)waitpid(pid, NULL, 0);
  }
  return o;
}

static bool same_text(const json_t *o, const char *key, const char *want, char *why, size_t cap) {
  const char *got = json_string_value(json_object_get(o, key));
  if (got != NULL && strcmp(got, want) == 0) {
    return true;
  }
  (void)snprintf(why, cap, "%s is %s, the row says %s", key, got != NULL ? got : "missing", want);
  return false;
}

static bool same_count(const json_t *o, const char *key, int64_t want, char *why, size_t cap) {
  const json_t *got = json_object_get(o, key);
  if (want == INT64_MIN || (json_is_integer(got) && json_integer_value(got) == want)) {
    return true;
  }
  (void)snprintf(why, cap, "%s is %lld, the row says %lld", key, (long long)json_integer_value(got),
                 (long long)want);
  return false;
}

static bool same_run(const json_t *o, const record *r, char *why, size_t cap) {
  const bool scene = json_object_get(o, "scene") != NULL && r->formulation[0] != '\0';
  return same_text(o, "solver", r->solver, why, cap) &&
         (!scene || same_text(o, "formulation", r->formulation, why, cap)) &&
         same_text(o, "status", r->status, why, cap) &&
         same_text(o, "solution_hash", r->solution_hash, why, cap) &&
         same_count(o, "n_iter", r->n_iter, why, cap) &&
         same_count(o, "n_pivot", r->n_pivot, why, cap) &&
         same_count(o, "n_factor", r->n_factor, why, cap) &&
         same_count(o, "n_matvec", r->n_matvec, why, cap);
}

/* ---- the folder -------------------------------------------------------------------------------*/

/* Rows of processes that died, or never got to an answer, have nothing to recompute. */
static bool has_answer(const record *r) {
  return r->solution_hash[0] != '\0';
}

/* An answer that the clock cut short is another one each time: neither the stored answers, which are
 * those of the warm-up, nor another run can give it back. */
static bool cut_by_clock(const record *r) {
  return strcmp(r->status, run_status_name(RUN_TIME_LIMIT)) == 0 &&
         record_has_flag(r, "not_repeatable");
}

typedef struct verify_counts {
  int stored, rerun, bad, none, cut, rows; /* cells, but rows */
} verify_counts;

/* What the rows of a cell are held against: the stored answers judged again, or the output of the
 * command. */
typedef struct witness {
  bool stored;
  record again;
  json_t *json;
} witness;

static bool summon(const char *dir, const record *r, bool rerun, witness *w, char *why,
                   size_t cap) {
  char path[1100];
  base_error err = {0};
  (void)snprintf(path, sizeof path, "%s/solutions/%s.ans", dir, r->cell_id);
  w->stored = !rerun && access(path, R_OK) == 0;
  if (w->stored) {
    const bool good = replay(path, r, &w->again, &err) == BASE_OK;
    (void)snprintf(why, cap, "%.200s", err.text);
    return good;
  }
  w->json = run_again(r->command);
  (void)snprintf(why, cap, "the command gave no JSON: %.150s", r->command);
  return w->json != NULL;
}

/* Every row of the cell with an answer; the first that differs is named. */
static bool all_held(const row_ref *row, int n, const witness *w, char *why, size_t cap,
                     verify_counts *sum) {
  char what[300];
  for (int i = 0; i < n; i++) {
    if (!has_answer(row[i].r) || cut_by_clock(row[i].r)) {
      continue;
    }
    sum->rows++;
    if (!(w->stored ? same_verdicts(row[i].r, &w->again, what, sizeof what)
                    : same_run(w->json, row[i].r, what, sizeof what))) {
      (void)snprintf(why, cap, "process %lld, repetition %lld: %.250s",
                     (long long)row[i].r->process, (long long)row[i].r->rep, what);
      return false;
    }
  }
  return true;
}

static void verify_cell(const char *dir, const row_ref *row, int n, bool rerun,
                        verify_counts *sum) {
  char why[400] = "";
  const record *first = NULL; /* with an answer to be held against something */
  bool cut = false;
  for (int i = n; i-- > 0;) {
    cut = cut || cut_by_clock(row[i].r);
    first = (has_answer(row[i].r) && !cut_by_clock(row[i].r)) ? row[i].r : first;
  }
  if (first == NULL) {
    sum->none += cut ? 0 : 1;
    sum->cut += cut ? 1 : 0;
    return;
  }
  witness w = {.json = NULL};
  const bool held =
      summon(dir, first, rerun, &w, why, sizeof why) && all_held(row, n, &w, why, sizeof why, sum);
  json_decref(w.json);
  sum->stored += (held && w.stored) ? 1 : 0;
  sum->rerun += (held && !w.stored) ? 1 : 0;
  sum->bad += held ? 0 : 1;
  if (!held) {
    const bool same_code = strcmp(first->base_hash, build_base()) == 0;
    (void)printf("DIFFERS %s %s: %s%s\n", first->cell_id, first->problem, why,
                 same_code ? "" : " (the row is of another build)");
  }
}

static base_status verify_rows(const char *dir, const record_table *t, bool rerun, int *code,
                               base_error *err) {
  verify_counts n = {0};
  row_ref *row;
  BASE_TRY(record_table_by_cell(t, &row, err));
  for (int i = 0; i < t->n;) {
    const int same = record_same_cell(row + i, t->n - i);
    verify_cell(dir, row + i, same, rerun, &n);
    i += same;
  }
  free(row);
  (void)printf("%d cells verified (%d from stored answers, %d run again), %d differ, %d without "
               "an answer; %d rows compared\n",
               n.stored + n.rerun, n.stored, n.rerun, n.bad, n.none, n.rows);
  if (n.cut > 0) {
    (void)printf("%d cells not compared: the clock cut their answers\n", n.cut);
  }
  if (t->torn) {
    (void)printf("the last row is torn: its process is left out\n");
  }
  *code = (n.bad == 0) ? CLI_OK : CLI_HONEST;
  return BASE_OK;
}

typedef struct verify_options {
  bool rerun;
  const char *certificate, *q;
  int facets;
} verify_options;

static const arg_option options[] = {
    ARG(verify_options, rerun, "--rerun", ARG_FLAG, NULL,
        "runs the solvers again instead of judging the stored answers"),
    ARG(verify_options, certificate, "--certificate", ARG_TEXT, "FILE",
        "checks this proof against PROBLEM, without a solver"),
    ARG(verify_options, q, "--q", ARG_TEXT, "FILE", "vector q of a Matrix Market problem"),
    ARG(verify_options, facets, "--facets", ARG_INT, "N",
        "facets of the polyhedral cone of a friction problem", .unit = "1", .min = 2),
};
static const arg_table args = {
    options, BASE_COUNT(options), 1,
    1,       "DIR|PROBLEM",       "campaign folder, or with --certificate a problem"};

static int run(int argc, char **argv) {
  verify_options o = {0};
  const char *dir;
  int n;
  base_error err = {0};
  record_table t;
  base_status done = args_parse(&args, &o, argc, argv, &dir, &n, &err);
  if (done == BASE_OK && o.certificate != NULL && o.rerun) {
    done = BASE_FAIL(&err, BASE_EINVAL, "--rerun: a certificate is checked without a solver");
  }
  if (done == BASE_OK && o.certificate != NULL) {
    return verify_certificate(dir, o.q, o.facets, o.certificate);
  }
  if (done == BASE_OK && (o.q != NULL || o.facets != 0)) {
    done = BASE_FAIL(&err, BASE_EINVAL, "--q and --facets describe the problem of a --certificate");
  }
  if (done == BASE_OK) {
    done = runner_read_rows(dir, &t, &err);
  }
  if (done != BASE_OK) {
    return cli_report(&err);
  }
  int code = CLI_INTERNAL;
  done = verify_rows(dir, &t, o.rerun, &code, &err);
  record_table_free(&t);
  return (done == BASE_OK) ? code : cli_report(&err);
}

extern const cli_verb verb_verify;
const cli_verb verb_verify = {
    .name = "verify",
    .args = &args,
    .help =
        "recomputes every verdict of a campaign from its stored answers (--rerun: by running the"
        " solvers again); or checks a certificate without any solver",
    .run = run,
};
