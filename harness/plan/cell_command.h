/* harness/plan/cell_command.h - the command that reruns a cell alone, and back. */
#pragma once

#include "harness/plan/plan.h"

enum { CELL_WORDS = 32 };

/* The cell of a row's command (cell_command in plan.h); its texts are views into `text`, which is
 * split in place. Content keys stay empty. BASE_EINVAL: not such a command. */
base_status cell_of_command(char *text, cell *c, base_error *err);
