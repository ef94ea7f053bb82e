/* harness/measure/registry.h - components by "NAME:option=value,..." text.
 *
 * The solvers of the build plus those a test program adds (tests/faulty: solvers that lie, crash
 * and hang, which no release binary contains). */
#pragma once

#include "formulations/formulation.h"
#include "lcp/lcp_solver.h"

/* Solvers added to the build's own; NULL-terminated, static storage. Called once, before any
 * other call. */
void registry_extend(const lcp_solver *const *extra);

/* The i-th solver, NULL past the end. */
const lcp_solver *registry_solver(int i);
const lcp_solver *registry_solver_find(const char *name);

enum { CHOICE_CONFIG = 640 };

/* A component with its options; owns `opt`. `config` holds all options as they are used. */
typedef struct solver_choice {
  const lcp_solver *solver;
  void *opt;
  char config[CHOICE_CONFIG];
} solver_choice;

typedef struct formulation_choice {
  const formulation *form;
  void *opt;
  char config[CHOICE_CONFIG];
} formulation_choice;

base_status solver_choose(const char *text, solver_choice *out, base_error *err);
base_status solver_choice_set(solver_choice *c, const char *option, const char *value,
                              base_error *err);
/* The wall limit of one solve (option max_seconds) becomes the least of what was asked for and
 * `seconds`. False: it was as low already, or the solver has no such option. */
bool solver_choice_limit(solver_choice *c, double seconds);
void solver_choice_free(solver_choice *c);

base_status formulation_choose(const char *text, formulation_choice *out, base_error *err);
base_status formulation_choice_set(formulation_choice *c, const char *option, const char *value,
                                   base_error *err);
bool formulation_choice_has(const formulation_choice *c, const char *option);
/* Facets of the friction cone, 0 where the formulation has none. */
int formulation_choice_facets(const formulation_choice *c);
void formulation_choice_free(formulation_choice *c);
