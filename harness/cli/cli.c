#include "harness/cli/cli.h"

#include "harness/choice/plugins.h"
#include "harness/cli/help.h"
#include "harness/util/stop.h"
#include "harness/util/version.h"
#include "lcp/base/nearest.h"
#include "lcp/base/printable.h"

#include <cblas.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

int cli_report(const base_error *err) {
  char text[4 * sizeof err->text];
  (void)fprintf(stderr, "lcpbench: %s\n", base_printable(err->text, text, sizeof text));
  return (err->code == BASE_ENOMEM || err->code == BASE_EEXTERNAL) ? CLI_INTERNAL : CLI_USAGE;
}

/* What was printed and did not arrive is no success. */
static int finish(int code) {
  errno = 0;
  if (fflush(stdout) == 0 && ferror(stdout) == 0) {
    return code;
  }
  (void)fprintf(stderr, "lcpbench: stdout: %s\n",
                errno != 0 ? strerror(errno) : "could not be written");
  return (code == CLI_OK || code == CLI_HONEST) ? CLI_INTERNAL : code;
}

int cli_stopped(void) {
  return (stop_requested() == SIGINT) ? CLI_SIGINT_EXIT : CLI_INTERRUPTED;
}

static int run_verb(const cli_verb *v, int argc, char **argv) {
  for (int i = 0; i < argc && strcmp(argv[i], "--") != 0; i++) {
    if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
      help_verb(stdout, v);
      return CLI_OK;
    }
  }
  return v->run(argc, argv);
}

static int unknown_verb(const char *word) {
  char hint[BASE_NEAREST_HINT];
  base_error err;
  base_nearest near = base_nearest_to(word, strlen(word));
  int n;
  const cli_verb *const *verb = cli_verbs(&n);
  for (int i = 0; i < n; i++) {
    base_nearest_offer(&near, verb[i]->name);
  }
  (void)BASE_FAIL(&err, BASE_EINVAL, "'%.200s': unknown command; see lcpbench --help%s", word,
                  base_nearest_hint(&near, hint));
  return cli_report(&err);
}

/* The file that the word at *i and the one behind it name by --plugin FILE or --plugin=FILE; *file is NULL where
 * the word is another. */
static base_status plugin_at(int argc, char **argv, int *i, const char **file, base_error *err) {
  static const char option[] = "--plugin";
  const size_t n = sizeof option - 1;
  const char *word = argv[*i];
  *file = NULL;
  if (strncmp(word, option, n) != 0 || (word[n] != '\0' && word[n] != '=')) {
    return BASE_OK;
  }
  *file = (word[n] == '=') ? word + n + 1 : (*i + 1 < argc) ? argv[++*i] : "";
  return (**file != '\0') ? BASE_OK
                          : BASE_FAIL(err, BASE_EINVAL, "%s: need FILE.so behind it", option);
}

/* Loads what --plugin names, wherever it stands before a --, and LCPBENCH_PLUGINS; takes the words away. */
static base_status take_plugins(int *argc, char **argv, base_error *err) {
  int kept = 1;
  bool ended = false; /* behind a -- the words are kept */
  BASE_TRY(plugins_take_environment(err));
  for (int i = 1; i < *argc; i++) {
    const char *file = NULL;
    ended = ended || strcmp(argv[i], "--") == 0;
    if (!ended) {
      BASE_TRY(plugin_at(*argc, argv, &i, &file, err));
    }
    if (file == NULL) {
      argv[kept++] = argv[i];
    } else {
      BASE_TRY(plugins_take(file, err));
    }
  }
  *argc = kept;
  return BASE_OK;
}

static int dispatch(int argc, char **argv) {
  base_error err = {0};
  if (take_plugins(&argc, argv, &err) != BASE_OK) {
    return cli_report(&err);
  }
  if (argc < 2) {
    help_all(stderr);
    return CLI_USAGE;
  }
  const char *word = argv[1];
  if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0) {
    help_all(stdout);
    return CLI_OK;
  }
  if (strcmp(word, "--version") == 0) {
    (void)printf("lcpbench %s\n", harness_version());
    return CLI_OK;
  }
  const cli_verb *verb = cli_verb_find(word);
  return (verb != NULL) ? run_verb(verb, argc - 2, argv + 2) : unknown_verb(word);
}

/* One thread, unless the user says otherwise: the matrices of a step are small, and the last bits of a product depend on the
 * number of threads. */
static void quiet_blas(void) {
  const char *asked = getenv("OPENBLAS_NUM_THREADS");
  if (asked == NULL || asked[0] == '\0') {
    openblas_set_num_threads(1);
  }
}

static pid_t at_work; /* the process whose verb runs; 0: it has ended */

/* A plug-in that calls exit() would end the program as if all were done. */
static void refuse_exit(void) {
  if (at_work == getpid()) {
    (void)fputs("lcpbench: a plug-in or library has called exit()\n", stderr);
    _exit(CLI_INTERNAL);
  }
}

int cli_main(int argc, char **argv) {
  quiet_blas();
  (void)atexit(refuse_exit);
  at_work = getpid();
  /* past `ulimit -f` a write then fails with EFBIG, which is reported like a full disk */
  (void)signal(SIGXFSZ, SIG_IGN);
  const int code = dispatch(argc, argv);
  at_work = 0;
  return finish(code);
}
