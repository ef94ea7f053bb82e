/* harness/case_lcp.h - the LCP cases of a case file (cases/README.md, sections 1 and 2). */
#pragma once

#include "harness/solve_once.h"

#include <jansson.h>

/* Status words of the case format. */
#define CASE_WORD_LIST(X)                                                                          \
  X(CASE_SOLVED, "solved")                                                                         \
  X(CASE_INFEASIBLE, "infeasible")                                                                 \
  X(CASE_NO_SOLUTION, "no_solution")                                                               \
  X(CASE_RAY, "unsolved_ray")                                                                      \
  X(CASE_NOT_CONVERGED, "not_converged")                                                           \
  X(CASE_NOT_APPLICABLE, "not_applicable")                                                         \
  X(CASE_NUMERICAL, "numerical_failure")                                                           \
  X(CASE_INVALID, "invalid_input")

#define CASE_WORD_ENUM_(id, text) id,
typedef enum case_word { CASE_WORD_LIST(CASE_WORD_ENUM_) CASE_WORD_COUNT } case_word;
const char *case_word_name(case_word w);

typedef struct case_lcp {
  const char *id;     /* borrowed from the JSON */
  const json_t *json; /* borrowed */
  bool valid;         /* false: the data are not an LCP; why is in `why` */
  base_error why;
  lcp_problem p; /* views the arrays below */
  double *m, *q; /* owned */
  int *colptr, *rowind;
} case_lcp;

/* Data of the case: M and q as given, or made by the generator it names. BASE_EUNSUPPORTED: a
 * generator this build does not know. */
base_status case_lcp_read(const json_t *json, case_lcp *out, base_error *err);
void case_lcp_free(case_lcp *c);

/* What the solver claimed, in the words of the case format. */
case_word case_lcp_word(const case_lcp *c, const solve_record *r);

/* Is the word in the case's list `key` ("status_correct", ...)? */
bool case_lcp_lists(const case_lcp *c, const char *key, case_word w);

/* Distance of z to the answers the case knows, relative, by its own rule; and the tolerance.
 * False: the case states nothing beyond the residual. */
bool case_lcp_forward(const case_lcp *c, const lcp_solver *s, const double *z, double *error,
                      double *tolerance, const char **rule);
