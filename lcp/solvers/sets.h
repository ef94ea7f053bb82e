/* sets.h - orthants, boxes and free rows as intervals. */
#pragma once

#include "lcp/lcp_problem.h"

/* lo[n], hi[n]: 0, HUGE_VAL on orthants; -HUGE_VAL, HUGE_VAL on free rows. p has no cones. */
void lcp_set_intervals(const lcp_problem *p, double *lo, double *hi);

static inline double lcp_set_clip(double x, double lo, double hi) {
  return (x < lo) ? lo : ((x > hi) ? hi : x);
}

/* Diagonal scaling s_i with s_i^2 M_ii = 1 where M_ii > 0; elsewhere 1 over the largest scaled entry
 * of row and column i (1 where both are zero). d[n] is the diagonal. */
void lcp_set_scaling(const lcp_matrix *M, const double *d, double *s);

/* Declared, or found by comparing entries. */
bool lcp_set_symmetric(const lcp_problem *p);
