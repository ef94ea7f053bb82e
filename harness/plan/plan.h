/* harness/plan/plan.h - a campaign as the list of its cells and the order in which they are measured. */
#pragma once

#include "harness/plan/campaign.h"
#include "harness/plan/record.h"
#include "harness/util/args.h"

enum { CELL_ID = 17 };

/* One combination of the axes. All texts are views into the plan's store. */
typedef struct cell {
  const char *part;
  const char *problem;
  const char *formulation; /* "": a complementarity problem, no scene */
  const char *solver;
  const char *step, *duration, *tol; /* "": the default of the scene or the solver */
  const char *start, *effects, *contact_order, *islands;
  char id[CELL_ID];        /* content key */
  char problem_sha256[65]; /* of the file, or of the scene's text and source */
  char solver_version[17]; /* of the solver's source */
  const char *skip;        /* "": to be run; otherwise why not */
} cell;

/* One process of one cell. */
typedef struct unit {
  int cell, process;
} unit;

typedef struct plan {
  const campaign *campaign; /* borrowed */
  int n_cell, cap_cell;
  cell *cell; /* owned */
  bool whole; /* no filter and no shard: other cells' rows are stale */
  int n_unit;
  unit *unit;      /* owned, in the order of measuring */
  text_list store; /* the cells' texts */
} plan;

typedef struct plan_filter {
  arg_list filter;    /* "axis=glob", or "-axis=glob" to leave out */
  int shard, n_shard; /* 1-based k of n; n = 0: everything */
} plan_filter;

/* Expands the axes, applies the filters, and orders the units: problems in a random order, and
 * within each problem processes and solvers interleaved at random, or forth and back in turn (abba), by the campaign's seed and the
 * cells' content alone, so that every shard keeps the order of the whole. A filter that matches
 * nothing is BASE_EINVAL. */
base_status plan_make(const campaign *c, const plan_filter *f, plan *out, base_error *err);
void plan_free(plan *p);

/* What a solver is told of its process's wall limit: 0.8 of it, so that it can end with an answer
 * before it is killed [s]. */
double plan_solver_limit(const campaign_limits *l);

/* The command that reruns the cell alone, with the limit that its solver was told: one line, for a POSIX
 * shell, whatever the path of the problem is made of. Returns the length it needs, as snprintf does. */
size_t cell_command(const cell *c, const campaign_limits *l, char *buf, size_t cap);

/* "a{1,2}b" -> "a1b", "a2b"; several braces: all combinations, the last varies fastest. */
base_status brace_expand(const char *text, text_list *out, base_error *err);
