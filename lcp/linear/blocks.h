/* linear/blocks.h - factors of a sparse matrix made of small dense blocks, one a body, whose pattern is symmetric.
 *
 *   symmetric  A = L L'    positive definite (Cholesky by blocks)
 *   else       A = L U     pivots are exchanged inside a diagonal block and never between blocks: for matrices near a
 *                          positive definite one; what has no such factors is refused, not solved
 *
 * Blocks are eliminated in the order of AMD on their graph (Amestoy, Davis & Duff 1996), or, where that makes many products of
 * blocks, of nested dissection by METIS (Karypis & Kumar 1998) if its are fewer, and then by dense fronts. Order and fill are kept while the
 * pattern stays what it was. A block costs two dense products of its size with each pair of blocks below it, so that
 * the work is that of a sparse factor at the speed of a dense one. Fronts that do not meet, and strips of a wide one, are shared out to
 * the crew of the thread (base/crew.h), with the same bits for any. Owns its memory. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>
#include <stddef.h>

enum { LIN_BLOCK_MAX = 12 }; /* rows of a block */

/* Columns that are eliminated in one dense matrix. */
typedef struct lin_front_plan {
  int first;  /* place of its first column */
  int parent; /* place that its rest goes to; -1: it has none */
  int child,
      sibling; /* the last front that leaves its own here; the one before it of one parent; -1 */
  int begin;   /* the first front below it, or itself: all between are below it */
  size_t at;   /* of its rest on the stack */
  double work; /* of all below it and itself */
} lin_front_plan;

/* Fronts first .. end-1, which none but these leave their rest to: limbs are factored side by side. */
typedef struct lin_limb {
  int first, end;
} lin_limb;

typedef struct lin_blocks {
  int n;           /* blocks */
  int *first;      /* n+1: first row of each, as the caller counts */
  int *place;      /* n: where a block stands in the order of elimination */
  int *order;      /* n: which block stands there */
  int *column;     /* n+1: blocks below the diagonal, by place */
  int *row;        /* places, ascending in a column */
  size_t *at;      /* where such a block begins in low and up */
  size_t *at_diag; /* n+1, by place */
  double *low;     /* A_ij of i after j, rows(i) x rows(j) column-major; then L */
  double *up;      /* A_ji transposed, in the same places; then U. Not used when symmetric */
  double *diag;    /* column-major; then both factors of it */
  double *inverse_low, *inverse_diag; /* of A^-1, in the places of low and diag */
  int *swap;                          /* rows: exchanged with which row of its block */
  bool symmetric;
  long analyses; /* since the first */
  int *pair;     /* of the pattern that the analysis is of */
  size_t n_pair, cap_pair;
  int n_front; /* 0: factors block by block; else by dense fronts, where products are many */
  lin_front_plan *front; /* n_front+1 */
  int n_limb;            /* 0: one thread was to do it all */
  lin_limb *limb;
  double light; /* a front is in a limb where its work is no more */
  int *pending; /* n: fronts whose rest waits */
  int hands,
      *offset; /* threads that it was planned for; n of each: of a place in the front at hand */
  double *rest, *dense; /* the stack; the front at hand, of each thread */
  size_t apart;         /* numbers from one thread's front to the next one's, in limbs */
  size_t cap_rest, cap_dense;
  void *front_mem, *dense_mem; /* owned */
  int cap_n, cap_rows;
  size_t cap_below, cap_low, cap_diag;
  void *mem, *value_mem, *inverse_mem; /* owned, as are row, at and pair */
} lin_blocks;

void lin_blocks_close(lin_blocks *s); /* accepts zeroes, and leaves them */

/* Gives the numbers back and keeps order and fill, until the next plan. */
void lin_blocks_rest(lin_blocks *s);

/* The pattern: n blocks, rows first[b] .. first[b+1]-1 of block b (LIN_BLOCK_MAX at most), and the pairs (a, b) of blocks that
 * meet, 2 n_pair entries, each as often as it likes. BASE_ENOMEM only. */
base_status lin_blocks_plan(lin_blocks *s, int n, const int *first, const int *pair, size_t n_pair,
                            base_error *err);

/* Zeroes all blocks. */
void lin_blocks_clear(lin_blocks *s, bool symmetric);

/* Adds B to the block of rows of a and columns of b, rows(a) x rows(b) row-major. Of a symmetric matrix only one of A_ab
 * and A_ba is read, for a != b the one with a after b in the order; giving both is right. */
void lin_blocks_add(lin_blocks *s, int a, int b, const double *B);

/* False: a pivot that is zero, not positive (symmetric), or below 1e-15 of the largest. */
bool lin_blocks_factor(lin_blocks *s);

/* x <- A^-1 x, rows as the caller counts. */
void lin_blocks_solve(const lin_blocks *s, double *x);

/* The blocks of A^-1 that stand where the factor has blocks, by Takahashi's recurrence (Erisman & Tinney 1975), at about twice
 * the work of the factor. Symmetric only, after lin_blocks_factor, which stays. BASE_ENOMEM only. */
base_status lin_blocks_invert(lin_blocks *s, base_error *err);

/* x' A^-1 y of one entry each: x lives on block a, y on block b, which are one block or were given as a pair. After
 * lin_blocks_invert. */
double lin_blocks_inverse_form(const lin_blocks *s, int a, const double *x, int b, const double *y);

/* Gives the memory of A^-1 back. */
void lin_blocks_drop_inverse(lin_blocks *s);
