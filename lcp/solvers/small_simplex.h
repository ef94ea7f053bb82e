/* small_simplex.h - is there x >= 0 with  sum_k column_k x_k = q?  Phase one of the simplex method on a
 * tableau in long double with Bland's rule (1977), which never cycles. */
#pragma once

#include <stdbool.h>

enum { LCP_SMALL_N = 16 };
#define LCP_SMALL_ZERO 1e-14L /* share of the terms of a sum below which it is zero [1] */

typedef struct lcp_small_simplex {
  long double t[LCP_SMALL_N][3 * LCP_SMALL_N + 1]; /* columns, artificials, right-hand side */
  long double cost[3 * LCP_SMALL_N + 1]; /* minus the sum of the artificials: zero when feasible */
  long double size;                      /* sum |q_i| */
  int basic[LCP_SMALL_N];
  int n, columns, width;
} lcp_small_simplex;

/* n <= LCP_SMALL_N rows; column k is that of var[k]: i < n is w_i (e_i), n + j is z_j (-M_j). */
void lcp_small_simplex_start(lcp_small_simplex *x, int n, long double M[][LCP_SMALL_N],
                             const long double *q, const int *var, int columns);

/* Pivots to the end; basic[i] = k: x_k = t[i][width]. When false, cost holds the multipliers. */
bool lcp_small_simplex_feasible(lcp_small_simplex *x);
