/* harness/control/error_run.h - `--error E`: a run whose error is at most E, as far as can be told.
 *
 * Runs with smaller and smaller tolerances (step_control.h), until the quantities that the scene is asked for differ
 * by little enough between the last two. Where the error of a run is proportional to its tolerance (first order in
 * the step), that of the last one is |Q_k - Q_k-1| / (r - 1) with r the ratio of the two tolerances (Richardson
 * 1911); ERROR_SAFETY times that is `estimate`. It covers what local errors grow to, which their sum does not. It is no
 * less than what the worst located impact is off by, which two runs may have in common.
 *
 * Formulations that integrate by themselves halve their steps, and what two runs differ by counts whole.
 *
 * The quantities: whatever the scene's checks of state look at, as they look at it, and what it observes at the end; where
 * that is nothing, or nothing of the unit asked for, the places of all bodies at the end. E is absolute, with the
 * unit of the quantities it holds for ("1e-3m", "0.01rad"), or relative to the scale of each quantity's unit:
 *
 *   m      the longest way that a body's centre, or one of the quantities, is from where it began; at least the size
 *          of the smallest body
 *   m/s    the largest speed of a body; at least that of the length above in the time of the run
 *   rad    1
 *   rad/s  the largest value of the quantities of this unit; at least 1 rad in the time of the run
 *   else   the largest value of the quantities of this unit, in the run
 *
 * It says that the error cannot be promised where the runs do not come nearer to each other, where a step has no
 * solution, and where the limit of work comes first. */
#pragma once

#include "harness/control/step_control.h"

enum { ERROR_LEVELS = 12, ERROR_QUANTITIES = 64, ERROR_UNIT = 16, ERROR_LIMIT = 500000 };

#define ERROR_SAFETY 2.0 /* [1] */

typedef struct error_asked {
  double E;              /* in `unit`, or [1] */
  char unit[ERROR_UNIT]; /* "": relative */
  long limit;            /* of steps solved by all runs, trials included */
} error_asked;

typedef struct error_quantity {
  char name[112];
  const char *unit;
  double value, scale, estimate; /* [unit]; estimate HUGE_VAL: there is only one run */
} error_quantity;

typedef struct error_level {
  double tolerance; /* [m] */
  double
      change; /* largest difference from the level before, in units of E [1]; HUGE_VAL: the first */
  step_account account;
  double seconds; /* of simulation, trials included */
} error_level;

typedef struct error_result {
  error_asked asked;
  bool promised;
  char reason[200]; /* why not; "" where it is */
  double
      estimate; /* largest of the quantities that E holds for: in `unit`, or over its scale [1] */
  int n_quantity;
  error_quantity quantity[ERROR_QUANTITIES];
  int n_level;
  error_level level[ERROR_LEVELS];
  long solved; /* steps of all runs */
} error_result;

/* "1e-3m", "2 %", "1%", "0.01". BASE_EINVAL: no number above 0, or no unit that the program knows. */
base_status error_parse(const char *text, error_asked *out, base_error *err);

/* The finest run that was made, its record and steps; out->time is that of all runs. q as for simulate_controlled. */
base_status error_run(const sim_request *q, const error_asked *asked, series *record,
                      sim_result *out, step_list *kept, error_result *result, base_error *err);

/* The length that the first run is measured by: the size of the smallest body, or how far the fastest one gets [m]. */
base_status error_first_scale(const sim_request *q, double *scale, base_error *err);
