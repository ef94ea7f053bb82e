/* lcp/lcp_rho_factored.h - sizes of the terms of w where M = J W J' + S is held in factors, entry by entry.
 *
 * The product J (W (J'x)) does not tell what its terms were: where they cancel, as at a contact that neither carries nor
 * moves between bodies that do, |w| is rounding and a bound from it is rounding too. Here every M_ij of two groups that
 * share a body is formed, which costs about an assembly of M: for the last test of a solve, not for every one. */
#pragma once

#include "lcp/lcp_problem.h"

typedef struct lcp_rho_factored {
  double *wj;    /* n_jac: W J' of the sides at every body, velocities x columns, row-major */
  int *wj_start; /* n_body+1 */
  int *start;    /* n_body+1, into side */
  int *side;   /* 2n: 2 group + side of those at a body, where the same body lies beyond together */
  int *column; /* 2n, by side: its first column at its body */
  double *by;  /* n, of one body at a time: |x| by columns */
  unsigned char *whole; /* n: rows whose sizes are to be summed over all groups */
  unsigned char *again; /* n: rows whose sizes are to be summed anew */
  bool ready;           /* for the matrix of this solve */
} lcp_rho_factored;

void lcp_rho_factored_layout(lcp_rho_factored *s, const lcp_capacity *cap, base_arena *a);

/* size_i = |q_i| + sum_j |M_ij||x_j|, over the groups that share a body with that of i (all, unless S couples others:
 * then a lower bound); over its own group alone, which is a lower bound at the price of one product, where whole (n) is zero
 * in all rows of the group. whole = NULL: no such group. The same of `some` (n): groups where it is zero in all rows keep
 * the sizes that they have. Clear s->ready when the matrix has changed. */
void lcp_rho_factored_product(lcp_rho_factored *s, const lcp_problem *p, const unsigned char *some,
                              const unsigned char *whole, const double *x, double *size);

/* Adds to `rows` (n) those of all groups that share a body with a group that has one there. After a product. */
void lcp_rho_factored_neighbours(const lcp_rho_factored *s, const lcp_factored *f,
                                 unsigned char *rows);
