/* harness/campaign/budget.h - the order of a run that may be cut off by the clock. */
#pragma once

#include "harness/plan/cover.h"

/* Puts the plan's units into the order of a cover (harness/plan/cover.h). text: the campaign as it was asked for, whose quick form
 * comes first; like: a folder of earlier rows, which tell how dear a cell is (NULL: all cells are taken to cost what the
 * campaign's limits let them). The rows of the run itself are not asked, so that a run that goes on finds the same order.
 * Errors: those of reading the quick form and the rows; BASE_ENOMEM. */
base_status budget_order(plan *p, const char *text, const char *like, cover *out, base_error *err);
