/* harness/cli/solve_sequence.h - a sequence of problems by one solver, as one JSON object. */
#pragma once

#include "harness/sequence/sequence_solve.h"
#include "harness/sequence/sequence_source.h"

#include <jansson.h>

/* *report: new reference; FORMATS has its members. *good: all solved and verified. BASE_EINVAL: `start` is none. */
base_status solve_sequence(const char *problem, const solver_choice *solver, const char *start,
                           json_t **report, bool *good, base_error *err);
