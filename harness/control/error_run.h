/* harness/control/error_run.h - `--error E`: a run whose error is at most E, as far as can be told.
 *
 * Runs with smaller and smaller tolerances (step_control.h), until the quantities that the scene is asked for
 * (error_quantity.h) differ by little enough between the last two. Where the error of a run is proportional to its
 * tolerance, that of the last one is |Q_k - Q_k-1| / (r - 1) with r the ratio of the two tolerances (Richardson 1911);
 * ERROR_SAFETY times that is `estimate`. It covers what local errors grow to, which their sum does not. It is no less than
 * what the worst located impact is off by, which two runs may have in common, and, where contacts begin or cease to carry, than
 * what the run before is off by, over r: its estimate, or what all steps of the first run together are off by. Two runs may be
 * near each other by chance. And it is no less than what goes with the order of impacts that the last run does not tell (`doubt`), which
 * both may have taken alike.
 *
 * First with extrapolated steps (extrapolation.h). A quarter of the tolerance, and of the error, takes twice the steps then;
 * that is counted on only where no contact begins or ceases to carry and three runs show it (the last difference is that much less than the one
 * before), or the steps do: nothing is asked for between states, and the sum of what the steps are off by is that much less than in the run
 * before and at most E. Otherwise half of the step counts as half of the error: the root of r in the place of r. One run is enough where all of
 * its steps together are off by ERROR_EXACT E at most, and where only states are looked at that steps end at, or what lengths and speeds do
 * between these, where a constant acceleration stays within E / ERROR_SAFETY of the chord: it is as if exact. A law that plain steps keep to
 * rounding they keep to their order only, and go on until they do, where plain steps would be more. Where these runs do not come nearer to each
 * other, or a step fails, plain steps begin anew, and `why_plain` says why.
 *
 * Formulations that integrate by themselves halve their steps, and what two runs differ by counts whole.
 *
 * Of a speed it is no less than what an impact so near its time, or that no solve saw, changes (`jump`); of the extreme of a length over a time
 * no less than what a straight way between two states is nearer to the origin. Steps are no longer than springs bear, than a sixth of the
 * shortest period of a load, and than a quarter of the time in which what is off a steady turning grows by e.
 *
 * Nor is it less than what the formulation's friction does beyond Coulomb's (`law`, `left`), which no step mends; where that alone is more
 * than E the run says so and ends (`other_law`).
 *
 * It says that the error cannot be promised where the runs do not come nearer to each other, where they do not tell in which order bodies
 * are hit, where a step has no solution or a solve is not verified, and where the limit of work comes first. */
#pragma once

#include "harness/control/error_quantity.h"

enum { ERROR_LEVELS = 12 }; /* of each kind of steps */

#define ERROR_SAFETY 2.0 /* [1] */

typedef struct error_level {
  double tolerance; /* [m] */
  double
      change; /* largest difference from the level before, in units of E [1]; HUGE_VAL: the first */
  double known; /* what it is off by as far as the run before tells, slips aside, over E [1] */
  double
      slips; /* by how much it is too far off to tell at which bounce a body is whose speed is asked for; 0: it does [1] */
  step_account account;
  double seconds; /* of simulation, trials included */
} error_level;

typedef struct error_result {
  error_asked asked;
  bool promised;
  char reason[200]; /* why not; "" where it is */
  bool
      other_law; /* that is why: what the formulation's friction is beyond Coulomb's is more than E */
  bool extrapolated;   /* some steps of the run that is handed over are */
  char why_plain[200]; /* why they are not, where they could be */
  int first_level;     /* of the runs with steps of the last kind */
  double
      estimate; /* largest of the quantities that E holds for: in `unit`, or over its scale [1] */
  int n_quantity;
  error_quantity *quantity; /* owned */
  int n_level;
  error_level level[2 * ERROR_LEVELS];
  long solved; /* steps of all runs */
} error_result;

/* The finest run that was made, its record and steps; out->time is that of all runs. q as for simulate_controlled. Close the result, also behind
 * an error. */
base_status error_run(const sim_request *q, const error_asked *asked, series *record,
                      sim_result *out, step_list *kept, error_result *result, base_error *err);

void error_result_close(error_result *r);

/* No longer than q->h, the run, and what its springs and swinging loads bear [s]. */
base_status error_first_step(const sim_request *q, double *h, base_error *err);

/* The length that the first run is measured by: the size of the smallest body, or how far the fastest one gets [m]. */
base_status error_first_scale(const sim_request *q, double *scale, base_error *err);
