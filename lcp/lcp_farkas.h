/* lcp/lcp_farkas.h - proof that a problem has no feasible point: y >= 0, M'y <= 0, q'y < 0
 * (Farkas; free rows: y_i of any sign and (M'y)_i = 0).
 *
 * Cones: De Saxce's w + (sum mu_k |w_k|) e_n lies in K* if and only if w_n >= 0, so a y that is zero in the rows of friction
 * and has (M'y)_i = 0 there gives y'w = (M'y)'z + q'y < 0 for every z in K: no w has all w_n >= 0. For M symmetric and
 * positive semidefinite, y'My <= 0 means My = 0, so nothing is lost by asking for zero in place of the polar cone. */
#pragma once

#include "lcp/lcp_problem.h"

/* The kinds of rows. */
enum { LCP_FARKAS_SIGNED, LCP_FARKAS_FREE, LCP_FARKAS_SIDEWAYS };

/* A sum held as head + tail +- lost. */
typedef struct lcp_farkas_sum {
  long double head, tail, lost;
} lcp_farkas_sum;

/* True only when the three hold exactly for the binary numbers of the problem: sums are kept as
 * head + tail with a bound on what was lost, and an undecided sign counts as a failure. y is first
 * rounded to a multiple of max|y|/k, k <= 256, where it is one up to 1e-9, so that rounded
 * directions of problems with plain data become exact. Orthant and free blocks, cones; of a factored M
 * only a y that moves no body, J'y = 0 and S'y <= 0, is a proof here. `kind` has n entries, 0 orthant or normal, 1 free,
 * 2 row of friction (NULL: all orthant); `force` is scratch, one for each velocity of a factored M, else not read. One pass
 * over M; no allocation. */
bool lcp_farkas_prove(const lcp_matrix *M, const double *q, const unsigned char *kind,
                      lcp_farkas_sum *force, double *y);
