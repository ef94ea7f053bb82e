/* solvers/lemke/block.h - one contact's LCP, solved by Lemke's path on the tableau. */
#pragma once

#include "lcp/solvers/lemke/path.h"

enum { LEMKE_BLOCK_MAX = 66 }; /* normal, 64 facets, sigma */

typedef struct lemke_block {
  lemke_path path;
  lemke_table table;
  lemke_system system;
  int *power; /* rows */
} lemke_block;

enum {
  LEMKE_KEPT_MAX = 18
}; /* rows of a block whose inverse may be kept: normal, 16 facets, sigma */

/* The basis of a block that was inverted last. */
typedef struct lemke_kept {
  unsigned support; /* bit i: z_i is basic; 0: none is kept */
  bool singular;    /* its M_BB is, to rounding */
} lemke_kept;

/* inverse <- M_BB^-1, k x k by columns, for the k rows `row` of M, m x m. False: singular to rounding. */
bool lemke_block_invert(int k, const int *row, int m, const double *M, double *inverse);

/* The solution in the basis of the rows with z_i > 0, if there is one: x_B = -M_BB^-1 q_B >= 0, w_N >= 0 to rounding, for
 * m <= LEMKE_KEPT_MAX. The inverse (m*m) is kept while the support stays the same, so the answer goes by z alone. */
bool lemke_block_stays(lemke_kept *k, double *inverse, int m, const double *M, const double *q,
                       const double *z, double *x);

/* For blocks of up to `rows` rows. */
void lemke_block_layout(lemke_block *k, int rows, base_arena *a);

/* w = M z + q, z >= 0, w >= 0, z'w = 0 into z[m]; M column-major m*m, scaled for the path by powers of two near
 * 1/sqrt(M_ii). False (z untouched) when the path ends on a ray or after 100 m pivots. */
bool lemke_block_solve(lemke_block *k, int m, const double *M, const double *q, double *z);
