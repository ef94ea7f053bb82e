/* lcpbench verify: recomputes the verdicts of a campaign folder. The answers stored with it are put
 * back in the place of the solver, and the whole run is judged again from the problem. --rerun starts
 * the command of every row instead, which must give the same verdict, counters and bits; cells
 * without stored answers are rerun in any case. With --certificate: checks that file against
 * a problem. */
#include "harness/args.h"
#include "harness/cell_command.h"
#include "harness/cell_run.h"
#include "harness/cli.h"
#include "harness/json_out.h"
#include "harness/runner.h"
#include "harness/verify_certificate.h"
#include "harness/versions.h"

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

/* Every verdict of the row, and the bits they were made of. */
static bool same_verdicts(const record *row, const record *again, char *why, size_t cap) {
  const struct {
    const char *name, *was, *is;
  } words[] = {{"status", row->status, again->status},
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

static bool verify_stored(const char *path, const record *row, char *why, size_t cap) {
  char text[sizeof row->command];
  record again;
  cell c;
  base_error err = {0};
  const campaign limits = {.limits.time = row->t_limit_s};
  (void)snprintf(text, sizeof text, "%s", row->command);
  base_status done = cell_of_command(text, &c, &err);
  if (done == BASE_OK) {
    const cell_job job = {.campaign = &limits, .cell = &c};
    done = cell_replay(&job, path, &again, &err);
  }
  if (done != BASE_OK) {
    (void)snprintf(why, cap, "%.200s", err.text);
    return false;
  }
  return same_verdicts(row, &again, why, cap);
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
  if (cell_command_split(text, word, CELL_WORDS) < 3 || pipe2(fd, O_CLOEXEC) != 0) {
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

static bool verify_again(const record *r, char *why, size_t cap) {
  json_t *o = run_again(r->command);
  if (o == NULL) {
    (void)snprintf(why, cap, "the command gave no JSON: %.150s", r->command);
    return false;
  }
  const bool good = same_text(o, "status", r->status, why, cap) &&
                    same_text(o, "solution_hash", r->solution_hash, why, cap) &&
                    same_count(o, "n_iter", r->n_iter, why, cap) &&
                    same_count(o, "n_pivot", r->n_pivot, why, cap) &&
                    same_count(o, "n_factor", r->n_factor, why, cap) &&
                    same_count(o, "n_matvec", r->n_matvec, why, cap);
  json_decref(o);
  return good;
}

/* ---- the folder -------------------------------------------------------------------------------*/

/* Rows of processes that died, or never got to an answer, have nothing to recompute. */
static bool has_answer(const record *r) {
  return r->solution_hash[0] != '\0';
}

typedef struct verify_counts {
  int stored, rerun, bad, none;
} verify_counts;

static void verify_row(const char *dir, const record *r, bool rerun, verify_counts *n) {
  char path[1100];
  char why[300] = "";
  if (!has_answer(r)) {
    n->none++;
    return;
  }
  (void)snprintf(path, sizeof path, "%s/solutions/%s.ans", dir, r->cell_id);
  const bool stored = !rerun && access(path, R_OK) == 0;
  const bool held =
      stored ? verify_stored(path, r, why, sizeof why) : verify_again(r, why, sizeof why);
  n->stored += (held && stored) ? 1 : 0;
  n->rerun += (held && !stored) ? 1 : 0;
  n->bad += held ? 0 : 1;
  if (!held) {
    const bool same_code = strcmp(r->base_hash, build_base()) == 0;
    (void)printf("DIFFERS %s %s: %s%s\n", r->cell_id, r->problem, why,
                 same_code ? "" : " (the row is of another build)");
  }
}

static base_status verify_rows(const char *dir, const record_table *t, bool rerun, int *code,
                               base_error *err) {
  verify_counts n = {0};
  bool *first = calloc((size_t)t->n + 1, sizeof *first);
  base_status done = (first != NULL) ? record_table_firsts(t, first, err)
                                     : BASE_FAIL(err, BASE_ENOMEM, "no memory for %d rows", t->n);
  for (int i = 0; done == BASE_OK && i < t->n; i++) {
    if (first[i]) {
      verify_row(dir, &t->row[i], rerun, &n);
    }
  }
  free(first);
  if (done == BASE_OK) {
    (void)printf("%d cells verified (%d from stored answers, %d run again), %d differ, %d without "
                 "an answer\n",
                 n.stored + n.rerun, n.stored, n.rerun, n.bad, n.none);
  }
  *code = (n.bad == 0) ? CLI_OK : CLI_HONEST;
  return done;
}

static int run(int argc, char **argv) {
  bool rerun = false;
  const char *certificate = NULL;
  const char *q = NULL;
  int facets = 0;
  const arg_option options[] = {{"--rerun", ARG_FLAG, &rerun},
                                {"--certificate", ARG_TEXT, &certificate},
                                {"--q", ARG_TEXT, &q},
                                {"--facets", ARG_INT, &facets}};
  const arg_table table = {options, BASE_COUNT(options), 1, 1, "DIR or PROBLEM"};
  const char *dir;
  int n;
  base_error err = {0};
  record_table t;
  base_status done = args_parse(&table, argc, argv, &dir, &n, &err);
  if (done == BASE_OK && certificate != NULL) {
    return verify_certificate(dir, q, facets, certificate);
  }
  if (done == BASE_OK && (q != NULL || facets != 0)) {
    done = BASE_FAIL(&err, BASE_EINVAL, "--q and --facets describe the problem of a --certificate");
  }
  if (done == BASE_OK) {
    done = runner_read_rows(dir, &t, &err);
  }
  if (done != BASE_OK) {
    return cli_report(&err);
  }
  int code = CLI_INTERNAL;
  done = verify_rows(dir, &t, rerun, &code, &err);
  record_table_free(&t);
  return (done == BASE_OK) ? code : cli_report(&err);
}

extern const cli_verb verb_verify;
const cli_verb verb_verify = {
    .name = "verify",
    .usage = "verify DIR [--rerun] | PROBLEM --certificate FILE [--q FILE] [--facets N]",
    .help =
        "recomputes every verdict of a campaign from its stored answers (--rerun: by running the"
        " solvers again); or checks a certificate without any solver",
    .run = run,
};
