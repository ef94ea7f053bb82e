/* harness/cli/cli.h - the command line as a whole, and how a verb ends.
 *
 * Verbs print (data to stdout, messages to stderr) and return the exit code; everything below
 * them returns base_status and is silent. */
#pragma once

#include "harness/cli/verbs.h"

/* The whole program; returns the exit code. */
int cli_main(int argc, char **argv);

/* The exit code where stop_requested() tells of a signal. */
int cli_stopped(void);

/* Prints "lcpbench: text" as one line on stderr, without control characters, and returns the exit code for
 * the status. */
int cli_report(const base_error *err);
