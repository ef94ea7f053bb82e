#include "harness/cli/cli.h"

#include "harness/util/version.h"

#include <errno.h>
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
  (void)fprintf(stderr, "lcpbench: %s\n", err->text);
  return (err->code == BASE_ENOMEM || err->code == BASE_EEXTERNAL) ? CLI_INTERNAL : CLI_USAGE;
}

static int help(FILE *to) {
  (void)fprintf(to, "lcpbench %s - benchmarks of contact formulations and LCP solvers\n\n",
                harness_version());
  for (int i = 0; i < BASE_COUNT(verbs); i++) {
    (void)fprintf(to, "  lcpbench %s\n      %s\n", verbs[i]->usage, verbs[i]->help);
  }
  (void)fprintf(
      to, "\nExit codes: 0 done, 1 internal error, 2 usage, bad input or a file that cannot be"
          "\nwritten, 3 honest failure, 4 interrupted and resumable, 130 after Ctrl-C.\n");
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

static int run_verb(const cli_verb *v, int argc, char **argv) {
  for (int i = 0; i < argc; i++) {
    if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
      (void)printf("lcpbench %s\n    %s\n", v->usage, v->help);
      return CLI_OK;
    }
  }
  return v->run(argc, argv);
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
  base_error err;
  (void)BASE_FAIL(&err, BASE_EINVAL, "'%s': unknown command; see lcpbench --help", word);
  return cli_report(&err);
}

int cli_main(int argc, char **argv) {
  return finish(dispatch(argc, argv));
}
