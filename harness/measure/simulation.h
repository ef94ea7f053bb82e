/* harness/measure/simulation.h - one run of a scene, from the texts of a command line or of a cell. */
#pragma once

#include "harness/measure/effects_auto.h"

/* As typed; NULL or "": the default. */
typedef struct simulation_texts {
  const char *scene, *formulation, *solver, *tol;
  const char *step, *duration, *effects, *start, *contact_order;
} simulation_texts;

/* What the texts choose; owns everything the request points to. */
typedef struct simulation {
  scene_spec spec;
  formulation_choice form;
  solver_choice solver;
  sim_request request;
  effects_choice effects; /* what --effects auto:E decided */
} simulation;

/* Whatever is returned, simulation_close gives back what was opened. Errors: BASE_EINVAL with the
 * option's name, and what scene, formulation and solver say. */
base_status simulation_open(const simulation_texts *t, simulation *out, base_error *err);
void simulation_close(simulation *s);
