/* harness/measure/predictions.h - what theory says of a scene against what a run gave. */
#pragma once

#include "harness/measure/check_eval.h"
#include "harness/measure/simulate.h"

/* The trajectory yardstick of one run. The reference quantity is the scene's first kinematic check
 * (a state, a window, a drift) that holds for the exact cone, or its first where none does; it is
 * the same for every formulation and solver, also for those that are not expected to meet it. */
typedef struct prediction_summary {
  int n, n_missed;
  double worst;     /* largest error over its tolerance; <= 1: all hold */
  bool has_ref;     /* a kinematic prediction applied and could be evaluated */
  double error;     /* |value - predicted| of the reference quantity, in its unit */
  double predicted; /* its predicted value */
  double tolerance; /* its tolerance */
  char quantity[80];
  char missed[160];   /* what was missed, worst first of each kind: "max_drift top.y 3.2x, ..." */
  const char *source; /* view into the spec */
  bool has_end;       /* the scene observes something, and the run came to its end */
  double end;         /* the scene's first observed quantity there, in its unit */
} prediction_summary;

/* Does the i-th check of the scene apply to this run? False for all when a declared effect is left
 * out (unless the request says that it makes no difference), and for checks at times beyond the
 * duration. */
bool prediction_applies(const sim_request *q, int i);

/* Does the scene have a reference quantity for this run (prediction_summary)? */
bool prediction_exists(const sim_request *q);

check_context prediction_context(const sim_request *q, const series *record, const sim_result *r);

void predictions_summarise(const sim_request *q, const series *record, const sim_result *r,
                           prediction_summary *out);
