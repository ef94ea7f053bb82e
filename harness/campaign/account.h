/* harness/campaign/account.h - what a run has left out, for its manifest and for a reader of its folder. */
#pragma once

#include "harness/plan/cover.h"

#include <jansson.h>
#include <stdio.h>

/* NULL where every cell has all its rows. Otherwise a new object: "cells" of the plan, "measured" (all processes), "begun" (some),
 * "parts" {part: [measured, cells]}, "absent" {part: {axis: [values of which no cell is measured]}} of parts that have a measured one, and where
 * the order is that of a cover (otherwise NULL) "stages" {stage: [measured, cells]}. done[n_unit]; a cell with all its units done is measured. */
json_t *account_json(const plan *p, const cover *order, const bool *done);

/* The same object, read again, in lines of `to`. n_cell: cells with rows there. */
void account_print(json_t *cut, int n_cell, FILE *to);
