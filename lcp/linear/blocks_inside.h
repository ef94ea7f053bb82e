/* linear/blocks_inside.h - what the files of lin_blocks share: blocks.c (entries, factors, solutions), blocks_pattern.c
 * (order and fill), blocks_fronts_plan.c and blocks_fronts.c (factors by dense fronts) and blocks_inverse.c (parts of the inverse). */
#pragma once

#include "lcp/base/arena.h"
#include "lcp/linear/blocks.h"

/* Rows of the block that stands at a place of the order. */
static inline int lin_blocks_rows(const lin_blocks *s, int place) {
  const int b = s->order[place];
  return s->first[b + 1] - s->first[b];
}

/* Where block row i of column j < i stands, by places; it must be in the pattern. */
int lin_blocks_find(const lin_blocks *s, int i, int j);

/* Smallest and largest pivot so far. */
typedef struct lin_span {
  double low, high;
} lin_span;

/* Factors of a diagonal block, n x n: L L' in its lower triangle, or L U with rows exchanged. False: there are none. */
bool lin_blocks_pivot(const lin_blocks *s, int n, double *D, int *swap, lin_span *pivots);

/* Is front k in no limb? These follow when all limbs are done. */
static inline bool lin_blocks_is_above(const lin_blocks *s, int k) {
  return s->front[k].work > s->light;
}

/* Rows of the blocks below the diagonal of a place. */
size_t lin_blocks_rows_below(const lin_blocks *s, int place);

/* The fronts of the pattern that stands (blocks_fronts_plan.c), and memory for them; n_front = 0 where the order has none. BASE_ENOMEM
 * only. */
base_status lin_blocks_plan_fronts(lin_blocks *s, base_error *err);

/* The factor by fronts; false: a pivot that there is none for. */
bool lin_blocks_factor_fronts(lin_blocks *s, lin_span *pivots);

/* One block of memory for a layout; what stood there before is lost. BASE_ENOMEM only. */
base_status lin_blocks_memory(lin_blocks *s, void **mem, void (*layout)(lin_blocks *, base_arena *),
                              base_error *err);

/* C -= X Y', C m x n, X m x k, Y n x k, all by columns. */
void lin_blocks_subtract(double *C, const double *X, const double *Y, int m, int n, int k);
