/* harness/control/simulation.h - one run of a scene, from the texts of a command line or of a cell. */
#pragma once

#include "harness/control/choice.h"
#include "harness/control/effects_watch.h"
#include "harness/control/error_run.h"

enum { CHOICE_TRIES = 4 };

/* As typed; NULL or "": the default. */
typedef struct simulation_texts {
  const char *scene, *formulation, *solver, *tol;
  const char *step, *duration, *effects, *start, *contact_order;
  const char *islands, *threads, *memory;
  const char *error, *work, *time_limit; /* --error E, and its limits of steps and of time */
  const char *steps;                     /* a file of step lengths */
  const char
      *rows; /* what formulation and solver are chosen from with --error, where neither is given */
} simulation_texts;

/* What the texts choose; owns everything the request points to. */
typedef struct simulation {
  scene_spec spec;
  formulation_choice form; /* these two all along, */
  solver_choice solver;
  combination_plan combinations; /* or in turn; n = 0: these two */
  sim_request request;           /* its form and solver are the first */
  effects_plan plan;             /* of the effects: given, or found */
  double watch;                  /* E of --effects auto:E; 0: the effects are given */
  watch_result watched;          /* what it came to */
  error_asked error;             /* E = 0: not asked for */
  error_result found;            /* what it came to */
  step_list steps;               /* given or found; n = 0: even ones */
  bool chooses;                  /* formulation and solver, below */
  features features;
  choice choice;
  int n_tried; /* candidates that were run */
  int taken;   /* the one that stands */
  run_status tried[CHOICE_TRIES];
  char tol[32]; /* of whatever solver is chosen; "": its own */
} simulation;

/* Whatever is returned, simulation_close gives back what was opened. Errors: BASE_EINVAL with the
 * option's name, and what scene, formulation and solver say. */
base_status simulation_open(const simulation_texts *t, simulation *out, base_error *err);
/* The run. With --error the request has the steps that were found, and where it asks for files they are written by
 * a run with these steps. */
base_status simulation_run(simulation *s, series *record, sim_result *out, base_error *err);
/* After the run: even steps, so many as were `taken`, become a list, too, so that a file of it repeats them. Where --error found none there are none. */
base_status simulation_list_steps(simulation *s, long taken, base_error *err);
void simulation_close(simulation *s);
