/* tests/bench/solver_tableau.h - for registry_extend. */
#pragma once

#include "lcp/lcp_solver.h"

extern const lcp_solver *const tableau_solvers[]; /* ends with NULL */
