/* small_lemke.h - one contact's LCP, solved exactly: lexicographic Lemke on a dense tableau.
 *
 * Cottle, Pang & Stone 1992, algorithm 4.4.5 with the lexicographic ratio test of section 4.9, after
 * the diagonal scaling s_i M_ij s_j. For sizes up to LCP_SMALL_MAX; no state. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

enum { LCP_SMALL_MAX = 66 }; /* normal, 64 facets, sigma */

/* Doubles that `work` must hold for size m. */
static inline size_t lcp_small_work(int m) {
  const size_t k = (size_t)m;
  return k * (2 * k + 2) + 3 * k;
}

/* w = M z + q, z >= 0, w >= 0, z'w = 0 into z[m]; M column-major m*m. False (z untouched) when the
 * method ends on a ray, or after 100 m pivots. */
bool lcp_small_lemke(int m, const double *M, const double *q, double *z, double *work);
