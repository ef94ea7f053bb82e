/* lcp/lcp_bounds.h - bounds lo <= z <= hi as blocks of a problem. */
#pragma once

#include "lcp/lcp_problem.h"

/* The kind of one row: 0 and infinity an orthant, minus and plus infinity free, all others a box. */
lcp_set lcp_bounds_set(double lo, double hi);

/* Blocks of rows that follow each other and have the same kind of bounds. lo NULL: zero; hi NULL: infinity. block[n] takes them; returns how many
 * there are. */
int lcp_bounds_blocks(int n, const double *lo, const double *hi, lcp_block *block);
