/* harness/measure/combination_plan.h - which formulation and solver take a run's steps, and from which step on.
 *
 *   A            all along
 *   A/12:B       B from the 13th step on, when 12 steps are done
 *
 * in the text of the formulation, of the solver or of both. What one remembers of its contacts the next one has by their ids
 * (formulation_take_over). */
#pragma once

#include "harness/measure/registry.h"

enum { COMBINATION_SPANS = 16 };

typedef struct combination_span {
  long from; /* steps done before it */
  formulation_choice form;
  solver_choice solver;
} combination_span;

typedef struct combination_plan {
  int n; /* the first from 0, ascending */
  combination_span span[COMBINATION_SPANS];
} combination_plan;

/* BASE_EINVAL names the step that is wrong; what formulations and solvers say. tol (NULL: their own) is that of all solvers. Whatever is
 * returned, combination_plan_free gives back what was opened. */
base_status combination_plan_parse(const char *forms, const char *solvers, const char *tol,
                                   combination_plan *out, base_error *err);
/* That of the step which follows `done` steps. */
const combination_span *combination_plan_at(const combination_plan *p, long done);
void combination_plan_free(combination_plan *p);
