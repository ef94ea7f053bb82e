/* harness/plan_key.h - the content key of a cell: same key, same experiment, on any machine. */
#pragma once

#include "harness/plan.h"

/* Fills id, problem_sha256 and solver_version of a cell whose texts are set. Errors: what the solver
 * or the formulation says of its options; BASE_EIO for a problem's file that cannot be read. */
base_status cell_key(const campaign *camp, cell *c, base_error *err);
