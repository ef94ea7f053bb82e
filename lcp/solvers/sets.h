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

/* Powers of two s_i with s_i^2 |M_ii| between 1/2 and 4, 1 where M_ii = 0: a scaling that changes no digit. */
void lcp_set_binary_scaling(const lcp_matrix *M, double *s);

/* Declared, or found by comparing entries. */
bool lcp_set_symmetric(const lcp_problem *p);

/* Row and column i, with the diagonal d_i, are zero and M is symmetric: what joints and locks leave of a direction in which
 * nothing can move. w_i = q_i whatever z is. */
bool lcp_set_still(const lcp_problem *p, double d, int i);

/* z_i of such a row: the bound that w asks for; as it was where w asks for none, or for one at infinity. */
static inline double lcp_set_end(double z, double w, double lo, double hi) {
  const double end = (w > 0.0) ? lo : ((w < 0.0) ? hi : z);
  return (end > -HUGE_VAL && end < HUGE_VAL) ? end : z;
}
