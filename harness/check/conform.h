/* harness/check/conform.h - does a solver keep the promises of lcp_solver.h? For plug-ins above all, which no test of this build
 * has seen. */
#pragma once

#include "harness/check/check_run.h"

/* The only solver of the plan on small problems of every set and storage that it declares, each in a process of its own. Outcomes of
 * each: `answer` (what it claims is true; problems that are called easy must be solved), `again` (the same bits twice), `start` (it
 * stays at its own answer, where it declares warm), `few` (one iteration allowed: no false claim), `data` (the problem is as it
 * was), `heap` (repeated solves leave nothing behind). */
base_status conform_solver(const check_plan *plan, base_error *err);
