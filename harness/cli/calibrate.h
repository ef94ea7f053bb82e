/* harness/cli/calibrate.h - the regularisation that reaches an error in the least time.
 *
 * Minimises log(time) over the two logarithms of the regularisation's parameters, (ratio, zeta) or
 * (k, c) of `regularized`, with NLopt's subplex (Rowan 1990), which needs no derivatives and bears
 * noise. To each pair belongs the longest step of the ladder first, first/sqrt(2), first/2, ... that
 * keeps the error; its time is the least of three runs. Pairs for which no step of the ladder does
 * are infeasible: their cost is that of a run far longer than any, plus the log of what the error is
 * too large by. */
#pragma once

#include "harness/measure/simulate.h"

enum { CALIBRATE_LADDER = 22, CALIBRATE_RUNS = 3 };

typedef enum calibrate_yardstick { CALIBRATE_TRAJECTORY, CALIBRATE_PHYSICAL } calibrate_yardstick;

typedef struct calibrate_point {
  double x[2];    /* the parameters, in their units */
  bool reaches;   /* a step of the ladder keeps the error */
  double h;       /* longest such step [s] */
  double error;   /* there; if none does: the smallest of the ladder */
  double seconds; /* least of the runs at h [s] */
} calibrate_point;

typedef struct calibrate_task {
  sim_request request;      /* but for h; form is changed */
  formulation_choice *form; /* the one that the request points to */
  const char *name[2];      /* options that are varied */
  double first;             /* longest step of the ladder [s] */
  double level;             /* error to stay below */
  calibrate_yardstick yardstick;
  int evaluations; /* of pairs, at most */
} calibrate_task;

typedef struct calibrate_result {
  calibrate_point rule, best; /* at the start, the rule of thumb; the least found */
  double gain;                /* time of the rule over time of the best, runs interleaved [1] */
  int evaluations;            /* pairs tried */
  long simulations;
} calibrate_result;

/* Gives the task's formulation the parameters x, to the six digits that the search runs with. */
base_status calibrate_set(calibrate_task *task, const double x[2], base_error *err);

/* x: the rule of thumb to start from. BASE_EEXTERNAL: NLopt refused. */
base_status calibrate(calibrate_task *task, const double x[2], calibrate_result *out,
                      base_error *err);
