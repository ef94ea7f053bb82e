/* harness/control/checkpoint.h - a place in a run to come back to: the world, what formulation and solver remember of its
 * contacts, the record and what was found of the steps so far. What was spent (times, work, solves) stays spent. */
#pragma once

#include "harness/measure/simulate_state.h"

typedef struct checkpoint {
  double *state; /* world_save; owned */
  contact_past past;
  contact_past own; /* what the solver answered by itself */
  double *asleep;   /* world_sleep_save; owned, NULL: nobody may sleep */
  sim_asleep of_asleep;
  sim_result *out; /* its parts as far as there are any; owned */
  solved held;
  sim_carrying carrying, goes_on; /* of the step before */
  int n_row;                      /* of the record */
} checkpoint;

base_status checkpoint_open(checkpoint *c, const sim *s, base_error *err);
/* BASE_EUNSUPPORTED: the formulation cannot come back (formulation.memory). */
base_status checkpoint_take(checkpoint *c, const sim *s, const series *record, base_error *err);
base_status checkpoint_return(const checkpoint *c, sim *s, series *record, base_error *err);
void checkpoint_close(checkpoint *c);
