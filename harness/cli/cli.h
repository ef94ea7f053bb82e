/* harness/cli/cli.h - the command line: a table of verbs, each in its own file verb_NAME.c.
 *
 * Verbs print (data to stdout, messages to stderr) and return the exit code; everything below
 * them returns base_status and is silent. */
#pragma once

#include "lcp/base/status.h"

/* README.md has them as a table. */
enum {
  CLI_OK = 0,           /* solved and verified, campaign complete */
  CLI_INTERNAL = 1,     /* internal error, or stdout could not be written */
  CLI_USAGE = 2,        /* usage, bad input, a file that cannot be read or written */
  CLI_HONEST = 3,       /* not solved, unsolvable, prediction missed, failed checks */
  CLI_INTERRUPTED = 4,  /* stopped by SIGTERM, resumable */
  CLI_SIGINT_EXIT = 130 /* stopped by Ctrl-C, results flushed */
};

typedef struct cli_verb {
  const char *name;
  const char *usage; /* without "lcpbench" */
  const char *help;  /* one sentence */
  int (*run)(int argc, char **argv);
} cli_verb;

/* The whole program; returns the exit code. */
int cli_main(int argc, char **argv);

/* The exit code where isolate_stop_requested() tells of a signal. */
int cli_stopped(void);

/* Prints "lcpbench: text" as one line on stderr, without control characters, and returns the exit code for
 * the status. */
int cli_report(const base_error *err);
