#include "harness/cli/cli.h"

#include "harness/cell/isolate.h"
#include "harness/util/version.h"
#include "lcp/base/nearest.h"
#include "lcp/base/printable.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

/* One verb: one constant in verb_NAME.c and one word here. */
#define VERB_LIST(X)                                                                               \
  X(list)                                                                                          \
  X(solve)                                                                                         \
  X(simulate)                                                                                      \
  X(calibrate) X(check) X(run) X(status) X(merge) X(verify) X(compare) X(doctor) X(export) X(submit)

#define DECLARE_(name) extern const cli_verb verb_##name;
VERB_LIST(DECLARE_)
#define ADDRESS_(name) &verb_##name,
static const cli_verb *const verbs[] = {VERB_LIST(ADDRESS_)};

int cli_report(const base_error *err) {
  char text[4 * sizeof err->text];
  (void)fprintf(stderr, "lcpbench: %s\n", base_printable(err->text, text, sizeof text));
  return (err->code == BASE_ENOMEM || err->code == BASE_EEXTERNAL) ? CLI_INTERNAL : CLI_USAGE;
}

static int help(FILE *to) {
  (void)fprintf(to, "lcpbench %s - benchmarks of contact formulations and LCP solvers\n\n",
                harness_version());
  for (int i = 0; i < BASE_COUNT(verbs); i++) {
    (void)fprintf(to, "  lcpbench %s\n      %s\n", verbs[i]->usage, verbs[i]->help);
  }
  (void)fputs(
      "\nA FILE to be written may be -, standard output; what else would stand there goes to\n"
      "stderr. Behind -- there are no options. Exit codes: 0 done, 1 internal error or stdout\n"
      "that could not be written, 2 usage, bad input or a file that cannot be read or\n"
      "written, 3 honest failure, 4 stopped by SIGTERM and resumable, 130 after Ctrl-C.\n",
      to);
  return CLI_OK;
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
  return (isolate_stop_requested() == SIGINT) ? CLI_SIGINT_EXIT : CLI_INTERRUPTED;
}

static int run_verb(const cli_verb *v, int argc, char **argv) {
  for (int i = 0; i < argc; i++) {
    if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
      (void)printf("lcpbench %s\n    %s\n", v->usage, v->help);
      return CLI_OK;
    }
  }
  return v->run(argc, argv);
}

static int unknown_verb(const char *word) {
  char hint[BASE_NEAREST_HINT];
  base_error err;
  base_nearest near = base_nearest_to(word, strlen(word));
  for (int i = 0; i < BASE_COUNT(verbs); i++) {
    base_nearest_offer(&near, verbs[i]->name);
  }
  (void)BASE_FAIL(&err, BASE_EINVAL, "'%.200s': unknown command; see lcpbench --help%s", word,
                  base_nearest_hint(&near, hint));
  return cli_report(&err);
}

static int dispatch(int argc, char **argv) {
  if (argc < 2) {
    (void)help(stderr);
    return CLI_USAGE;
  }
  const char *word = argv[1];
  if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0 || strcmp(word, "help") == 0) {
    return help(stdout);
  }
  if (strcmp(word, "--version") == 0) {
    (void)printf("lcpbench %s\n", harness_version());
    return CLI_OK;
  }
  for (int i = 0; i < BASE_COUNT(verbs); i++) {
    if (strcmp(verbs[i]->name, word) == 0) {
      return run_verb(verbs[i], argc - 2, argv + 2);
    }
  }
  return unknown_verb(word);
}

int cli_main(int argc, char **argv) {
  /* past `ulimit -f` a write then fails with EFBIG, which is reported like a full disk */
  (void)signal(SIGXFSZ, SIG_IGN);
  return finish(dispatch(argc, argv));
}
