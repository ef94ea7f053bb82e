/* harness/choice/solver_choice.h - solvers by "NAME:option=value,..." text.
 *
 * The solvers of the build plus those that are added at start: plug-ins, and in a test program (tests/faulty) solvers that
 * lie, crash and hang, which no release binary contains. */
#pragma once

#include "lcp/lcp_solver.h"

/* Solvers added to the build's own; NULL-terminated, static storage. Called once, before any
 * other call. */
void registry_extend(const lcp_solver *const *extra);

/* One more, whose storage outlives every call. BASE_EINVAL: a name that is taken, or more than there is room for. Called before
 * solvers are chosen, from one thread. */
base_status registry_add(const lcp_solver *s, base_error *err);

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

base_status solver_choose(const char *text, solver_choice *out, base_error *err);
base_status solver_choice_set(solver_choice *c, const char *option, const char *value,
                              base_error *err);
/* The wall limit of one solve (option max_seconds) becomes the least of what was asked for and
 * `seconds`. False: it was as low already, or the solver has no such option. */
bool solver_choice_limit(solver_choice *c, double seconds);
void solver_choice_free(solver_choice *c);

/* ---- what the choice of any component is made of ------------------------------------------- */

/* Splits "NAME:options" at the first colon; *options is "" without one. */
base_status choice_split(const char *text, char name[64], const char **options, base_error *err);

/* Default options with the given ones on top, in a fresh block of `size` bytes; freed with free(). */
base_status choice_options(const char *name, const base_field *f, int nf, size_t size,
                           const char *text, void **opt, base_error *err);
base_status choice_set(const char *name, const base_field *f, int nf, void *opt, const char *option,
                       const char *value, base_error *err);
