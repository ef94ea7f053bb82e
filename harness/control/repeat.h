/* harness/control/repeat.h - the command of a run that something automatic decided on. */
#pragma once

#include "harness/control/simulation.h"
#include "harness/util/shell.h"

/* "lcpbench simulate SCENE" with this formulation, solver and effects, and what else of the texts a run without --error reads. */
void repeat_run(shell_line *l, const simulation_texts *t, const char *form, const char *solver,
                const char *effects);

/* The --error that was asked for, and its limits. */
void repeat_error(shell_line *l, const simulation_texts *t, const error_asked *asked);
