/* harness/cli/solve_all.h - one problem by several solvers, as a table; each in a process of its own with limits. */
#pragma once

#include "harness/measure/problem_source.h"
#include "harness/measure/solve_once.h"

#include <jansson.h>
#include <stdio.h>

/* What one solver did with the problem as a JSON object; cone: the residual on the true cone of a friction problem, NULL of
 * others. docs/FORMATS.md has the members. */
json_t *solve_report(const problem_source *src, const solver_choice *s, const solve_record *r,
                     const lcp_verdict *cone);

/* Of a friction problem with an answer z: its residual on the true cone, in *room; NULL of other problems. */
base_status solve_cone(const problem_source *src, const solve_record *r, const double *z,
                       lcp_verdict *room, const lcp_verdict **cone, base_error *err);

typedef struct solve_all_end {
  bool verified; /* one of the answers is */
  bool stopped;  /* a signal came */
} solve_all_end;

/* Solves with each of the n solvers for at most `wall` seconds and prints one row each, verified answers first, the
 * fastest of them first (format: table.h). */
base_status solve_all(const problem_source *src, const solver_choice *s, int n, double wall,
                      const char *format, FILE *to, solve_all_end *end, base_error *err);
