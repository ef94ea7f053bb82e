/* harness/cli/verbs.h - the verbs of the command line, each in its own file verb_NAME.c. */
#pragma once

#include "harness/util/args.h"

/* README.md has them as a table. */
enum {
  CLI_OK = 0,           /* solved and verified, campaign complete */
  CLI_INTERNAL = 1,     /* internal error, or stdout could not be written */
  CLI_USAGE = 2,        /* usage, bad input, a file that cannot be read or written */
  CLI_HONEST = 3,       /* not solved, unsolvable, prediction missed, failed checks */
  CLI_INTERRUPTED = 4,  /* stopped by SIGTERM, or a budget is spent; resumable */
  CLI_SIGINT_EXIT = 130 /* stopped by Ctrl-C, results flushed */
};

typedef struct cli_verb {
  const char *name;
  const arg_table *args; /* help, manual page and completion are made from it */
  const char *help;      /* one sentence */
  int (*run)(int argc, char **argv);
} cli_verb;

/* All verbs, in the order of the help. */
const cli_verb *const *cli_verbs(int *count);
const cli_verb *cli_verb_find(const char *name); /* NULL: none */
