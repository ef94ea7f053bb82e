/* harness/cli/script.h - verbs that are Python: the figures and the report. */
#pragma once

/* Becomes scripts/NAME with these words: of the folder LCPBENCH_SCRIPTS, of the installed data, or of the source folder that
 * this program was built from. Returns the exit code only where it cannot be started. */
int script_run(const char *name, int argc, char **argv);
