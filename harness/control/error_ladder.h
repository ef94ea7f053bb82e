/* harness/control/error_ladder.h - how fine each of the runs behind `--error` is: tolerance, longest step, and into how many parts a
 * time is cut that a check looks at all states of. */
#pragma once

#include "harness/control/step_control.h"

/* Off by this much less than E a run is as if exact [1]. */
#define ERROR_EXACT 1e-3

/* How a run takes its steps: a formulation that integrates by itself, plain steps, extrapolated ones. */
typedef enum error_steps { ERROR_OWN, ERROR_PLAIN, ERROR_EXTRAPOLATED } error_steps;

typedef struct error_ladder {
  error_steps steps;
  step_rule rule; /* of the next run, its stops aside */
  double parts;
  double ratio; /* of the last two tolerances */
} error_ladder;

/* The coarsest run, for an E of `length` [m]; `bears`: the longest step that the springs and swinging loads of the scene do [s]; `rests`: nothing
 * moves at the start. */
void error_ladder_begin(error_ladder *l, const sim_request *q, error_steps steps, double length,
                        double bears, bool rests);
/* The run after one that is `over` times E off, and `between` times E between its states, in at most `parts` parts. */
void error_ladder_finer(error_ladder *l, double over, double between, double parts);
/* How many times better the last run is than the one before, with second order in the step or first. */
double error_ladder_gain(const error_ladder *l, bool second);
