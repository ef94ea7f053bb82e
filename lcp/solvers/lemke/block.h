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

/* For blocks of up to `rows` rows. */
void lemke_block_layout(lemke_block *k, int rows, base_arena *a);

/* w = M z + q, z >= 0, w >= 0, z'w = 0 into z[m]; M column-major m*m, scaled for the path by powers of two near
 * 1/sqrt(M_ii). False (z untouched) when the path ends on a ray or after 100 m pivots. */
bool lemke_block_solve(lemke_block *k, int m, const double *M, const double *q, double *z);
