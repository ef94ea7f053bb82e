/* lcpbench verify: recomputes the verdicts of a campaign folder. Answers that are stored are judged
 * again from the problem; every other cell is run again by its own command, and must give the same
 * verdict, counters and bits. With --certificate: checks that file against a problem. */
#include "harness/args.h"
#include "harness/cli.h"
#include "harness/json_out.h"
#include "harness/problem_source.h"
#include "harness/runner.h"
#include "harness/sim_watch.h"
#include "harness/verify_certificate.h"
#include "lcp/lcp_judge.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { VERIFY_WORDS = 32 };

/* ---- stored answers ---------------------------------------------------------------------------*/

static bool judge_answer(const record *r, const lcp_problem *p, const double *z, char *why,
                         size_t cap) {
  lcp_verdict v;
  char hash[24];
  base_error err = {0};
  if (lcp_judge(p, z, &v, &err) != BASE_OK) {
    (void)snprintf(why, cap, "%.200s", err.text);
    return false;
  }
  (void)snprintf(hash, sizeof hash, "%016llx",
                 (unsigned long long)sim_hash(SIM_HASH_START, z, p->M.n));
  const bool same = v.rho == r->rho || (!isfinite(v.rho) && isnan(r->rho));
  if (!same || strcmp(hash, r->solution_hash) != 0) {
    (void)snprintf(why, cap, "stored answer: rho %.17g and hash %s, the row says %.17g and %s",
                   v.rho, hash, r->rho, r->solution_hash);
    return false;
  }
  return true;
}

static bool verify_answer(const char *path, const record *r, char *why, size_t cap) {
  problem_source src;
  base_error err = {0};
  if (problem_source_open(r->problem, NULL, 0, &src, &err) != BASE_OK) {
    (void)snprintf(why, cap, "%.200s", err.text);
    return false;
  }
  const lcp_problem *p = src.p;
  double *z = calloc((size_t)p->M.n + 1, sizeof *z);
  bool good = false;
  if (z == NULL || lcp_read_mtx_vector(path, p->M.n, z, &err) != BASE_OK) {
    (void)snprintf(why, cap, "%.200s", z == NULL ? "no memory" : err.text);
  } else {
    good = judge_answer(r, p, z, why, cap);
  }
  free(z);
  problem_source_close(&src);
  return good;
}

/* ---- running the command again ----------------------------------------------------------------*/

/* Splits "lcpbench solve 'x y' --solver 'z'" in place; returns the number of words. */
static int split_command(char *text, char **word) {
  int n = 0;
  char *at = text;
  while (*at != '\0' && n + 1 < VERIFY_WORDS) {
    at += strspn(at, " ");
    const bool quoted = *at == '\'';
    at += quoted ? 1 : 0;
    if (*at == '\0') {
      break;
    }
    word[n++] = at;
    at += strcspn(at, quoted ? "'" : " ");
    if (*at != '\0') {
      *at++ = '\0';
    }
  }
  word[n] = NULL;
  return n;
}

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
  char *word[VERIFY_WORDS];
  int fd[2];
  (void)snprintf(text, sizeof text, "%s", command);
  if (split_command(text, word) < 3 || pipe2(fd, O_CLOEXEC) != 0) {
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
                    same_count(o, "n_pivot", r->n_pivot, why, cap);
  json_decref(o);
  return good;
}

/* ---- the folder -------------------------------------------------------------------------------*/

/* Rows of processes that died, or never got to an answer, have nothing to recompute. */
static bool has_answer(const record *r) {
  return r->solution_hash[0] != '\0';
}

static bool seen_before(const record_table *t, int i) {
  for (int k = 0; k < i; k++) {
    if (strcmp(t->row[k].cell_id, t->row[i].cell_id) == 0) {
      return true;
    }
  }
  return false;
}

static int verify_rows(const char *dir, const record_table *t) {
  int good = 0;
  int bad = 0;
  int none = 0;
  for (int i = 0; i < t->n; i++) {
    const record *r = &t->row[i];
    char path[1100];
    char why[300] = "";
    if (seen_before(t, i)) {
      continue;
    }
    if (!has_answer(r)) {
      none++;
      continue;
    }
    (void)snprintf(path, sizeof path, "%s/solutions/%s.mtx", dir, r->cell_id);
    const bool stored = r->formulation[0] == '\0' && access(path, R_OK) == 0;
    const bool held =
        stored ? verify_answer(path, r, why, sizeof why) : verify_again(r, why, sizeof why);
    good += held ? 1 : 0;
    bad += held ? 0 : 1;
    if (!held) {
      (void)printf("DIFFERS %s %s: %s\n", r->cell_id, r->problem, why);
    }
  }
  (void)printf("%d cells verified, %d differ, %d without an answer\n", good, bad, none);
  return (bad == 0) ? CLI_OK : CLI_HONEST;
}

static int run(int argc, char **argv) {
  const char *certificate = NULL;
  const char *q = NULL;
  int facets = 0;
  const arg_option options[] = {{"--certificate", ARG_TEXT, &certificate},
                                {"--q", ARG_TEXT, &q},
                                {"--facets", ARG_INT, &facets}};
  const arg_table table = {options, BASE_COUNT(options), 1, 1, "DIR or PROBLEM"};
  const char *dir;
  int n;
  char path[1100];
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
    runner_path(dir, "results.csv", path, sizeof path);
    done = record_table_read(path, &t, &err);
  }
  if (done != BASE_OK) {
    return cli_report(&err);
  }
  const int code = verify_rows(dir, &t);
  record_table_free(&t);
  return code;
}

extern const cli_verb verb_verify;
const cli_verb verb_verify = {
    .name = "verify",
    .usage = "verify DIR | PROBLEM --certificate FILE [--q FILE] [--facets N]",
    .help =
        "recomputes every verdict of a campaign: stored answers are judged again, scenes run again;"
        " or checks a certificate without any solver",
    .run = run,
};
