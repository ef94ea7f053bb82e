/* harness/measure/effects_auto.h - `--effects auto:E`: leaves out what this run does not need.
 *
 * Every declared effect that adds unknowns or rows (friction restitution rolling torsion rotation
 * gyroscopic damping spatial) is dropped in turn on a pilot, the first steps of the run, and stays
 * out when the result changes by less than E [1]; what the pilot did not show at work cannot be
 * judged and stays in. A pilot knows nothing of what comes after it: what the rules of effects_rules.h forbid is not asked, and
 * where they forbid everything there is no pilot at all. The change is the largest difference over the pilot of the energy, the largest
 * speed and every quantity that the scene's checks look at, over the largest value of that unit in
 * the pilot (at least what gravity alone does in its time), times the square of the
 * run's length over the pilot's, for what acts all along grows by that. Dropped together they must still stay
 * below E; otherwise the one with the largest change comes back, one after the other. */
#pragma once

#include "harness/measure/effects_rules.h"
#include "harness/measure/simulate.h"

enum { AUTO_STEPS_MIN = 4, AUTO_STEPS_MAX = 200, AUTO_TEXT = 240 };

typedef struct effects_choice {
  bool automatic;
  double level;          /* E [1] */
  unsigned dropped;      /* EFFECT_ bits left out */
  effects_verdict rules; /* what no pilot was asked for */
  double change;         /* of all that is left out, together, over the run [1] */
  long pilot_steps;      /* of each pilot run */
  double pilot_seconds;  /* all pilot runs [s] */
  char text[AUTO_TEXT];  /* "friction 0, rolling 3e-09 | kept rotation 0.2, joints unseen" */
} effects_choice;

/* Applies text (effects_override's, or "auto:E") to the request's effects. q is complete but for
 * `effects`. BASE_EINVAL: neither, or E not a number above 0. */
base_status effects_check(const char *text, base_error *err); /* the same of a text alone */
base_status effects_choose(sim_request *q, const char *text, effects_choice *out, base_error *err);
