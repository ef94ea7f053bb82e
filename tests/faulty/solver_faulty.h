/* tests/faulty/solver_faulty.h - solvers that misbehave on purpose, each in one way. They exist in
 * the test program lcpbench-faulty only. */
#pragma once

#include "lcp/lcp_solver.h"

/* NULL-terminated. */
extern const lcp_solver *const faulty_solvers[];
