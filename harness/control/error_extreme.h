/* harness/control/error_extreme.h - what an extreme over a time may be off by because no state is there. */
#pragma once

#include "harness/control/step_list.h"
#include "harness/measure/series.h"
#include "problems/spec/spec.h"

/* Of the largest, the least or the drift of a quantity over a time: how far one between two states may be beyond it [unit], and when that may be
 * [s]; 0: no way between states turns round. */
typedef struct extreme {
  double beyond, at;
  double nearest; /* of the length of a velocity: the least at a state; else HUGE_VAL [unit] */
} extreme;

/* For each row of the record of a run what the step that ends there met; free *met. BASE_ENOMEM. */
base_status extreme_met(const series *s, const step_list *kept, unsigned char **met,
                        base_error *err);
/* Of the check c, which looks at all states of a time, at this column. */
extreme extreme_between(const series *s, const unsigned char *met, int column, const spec_check *c);
/* How near to the origin a straight way of length `far` may come whose ends are x from it or farther. */
double extreme_nearer(double far, double x);
