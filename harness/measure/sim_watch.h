/* harness/measure/sim_watch.h - what the step loop looks at besides the answer: which declared effects
 * showed up, and a hash of the bits. */
#pragma once

#include "formulations/formulation.h"
#include "problems/spec/spec.h"
#include "problems/world/contact_merit.h"

#include <stdint.h>

#define SIM_HASH_START 0xcbf29ce484222325u /* FNV-1a 64-bit offset basis */

/* FNV-1a over the bytes of x[n], continued from `hash`. -0.0 counts as 0.0. */
uint64_t sim_hash(uint64_t hash, const double *x, int n);

/* Effects that this step showed at work (EFFECT_ bits). */
unsigned sim_effects_seen(const scene_spec *spec, const contact_set *set,
                          const formulation_answer *a);
