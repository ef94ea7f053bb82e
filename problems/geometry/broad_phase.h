/* problems/geometry/broad_phase.h - pairs of balls that may touch, in time and memory linear in their
 * number, whatever their sizes.
 *
 * Grids of cells, one for each factor of four in the radius (Ericson 2005, 7.2): a ball sits in the cell of
 * its centre in the grid of its size, whose cells are as wide as its largest ball, so partners of a ball are
 * in the neighbouring cells of its own grid and of those of larger balls. */
#pragma once

#include "lcp/base/gather.h"

#include <stdatomic.h>
#include <stdbool.h>

typedef struct broad_ball {
  double x[3];
  double r; /* bounding radius with the margin of this step [m] */
} broad_ball;

typedef struct broad_pair {
  int a, b; /* a < b */
} broad_pair;

enum { BROAD_LEVELS = 16, BROAD_FEW = 27 };

typedef struct broad_cell {
  int at[3], level;
} broad_cell;

typedef struct broad_level {
  int first, n;     /* its balls in `order` */
  double per_width; /* cells a metre */
} broad_level;

typedef struct broad_phase {
  int n, cap;
  broad_ball *ball; /* n; the caller fills it after broad_reserve */
  int n_pair, cap_pair;
  broad_pair *pair; /* result, in no particular order but always the same one */
  base_gather found;
  atomic_long tested; /* pairs whose balls were compared */
  int cap_bucket;
  int *head, *next; /* bucket heads, chains */
  broad_cell *cell; /* of each ball in its own grid */
  int *order;       /* balls by level, the largest first */
  broad_level level[BROAD_LEVELS];
} broad_phase;

base_status broad_reserve(broad_phase *bp, int n, base_error *err);
void broad_close(broad_phase *bp);

/* Fills pair with all a < b whose balls overlap; shared out (base/crew.h). */
base_status broad_find(broad_phase *bp, int dim, base_error *err);
