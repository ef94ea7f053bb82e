/* linear/sparse_lu.h - LU of a square matrix in caller-owned memory, sparse or not.
 *
 * Left-looking, one column at a time, with threshold partial pivoting (Gilbert & Peierls 1988);
 * columns ordered by their number of entries or, in a series of matrices where that fills in and the
 * dearer ordering turns out to pay, by COLAMD (Davis, Gilbert, Larimore & Ng 2004). Among entries within a factor
 * LIN_LU_THRESHOLD of the largest, the one in the row with the fewest entries is the pivot, which
 * keeps rows that couple everything (one body, many contacts) for last. A matrix with more entries
 * than half goes to LAPACK (dgetrf, partial pivoting), where its factor fits; one that turns out
 * singular there comes back to the sparse method, which finds the dependent columns.
 */
#pragma once

#include "lcp/base/arena.h"

#include <stdbool.h>
#include <stddef.h>

#define LIN_LU_THRESHOLD 0.1   /* smallest pivot relative to the largest entry of its column [1] */
#define LIN_LU_SINGULAR  1e-14 /* a column left with less than this share of itself is dependent */

/* Column-wise matrix to factor; row indices need not be sorted. */
typedef struct lin_columns {
  int n;
  const int *colptr;
  const int *rowind;
  const double *val;
} lin_columns;

typedef enum lin_ordering {
  LIN_BY_COUNT,    /* cheap; switches to a trial when it fills in */
  LIN_TRY_COLAMD,  /* the next factorisation decides */
  LIN_KEEP_COLAMD, /* it paid */
  LIN_KEEP_COUNT,  /* it did not */
} lin_ordering;

typedef struct lin_lu {
  int ordering; /* lin_ordering; set to LIN_BY_COUNT to start a series of similar matrices */
  double spent; /* operations per entry of the factorisation that made COLAMD worth a trial */
  int cap_n, n;
  int cap_nnz;     /* most entries a matrix may have */
  size_t cap_fill; /* entries of `index` and `value` */
  size_t fill;     /* entries used: L and U without their diagonals */
  double flops;    /* of the last factorisation, counted */
  bool dense;      /* the last one is LAPACK's: L and U column by column in `value` */
  int deficient;   /* columns found dependent in the last factorisation */

  size_t *ufirst; /* cap_n+1: column k holds U in [ufirst, lfirst), L in [lfirst, next ufirst) */
  size_t *lfirst; /* cap_n */
  int *index;     /* cap_fill: row */
  double *value;  /* cap_fill */
  double *pivot;  /* cap_n */
  int *prow;      /* cap_n: pivot row of step k */
  int *col;       /* cap_n: column of step k */
  int *step;      /* cap_n: step in which a row was pivot, -1 before */
  int *row_count; /* cap_n */
  double *x;      /* cap_n, zero between calls */
  int *reach, *stack, *mark;
  size_t *next; /* cap_n */
  int *order_work;
  size_t order_len;
} lin_lu;

/* n: most rows; nnz: most entries of a matrix; fill: most entries of L and U. */
void lin_lu_layout(lin_lu *f, int n, int nnz, size_t fill, base_arena *a);

/* True when A = P L U Q was found. False when the fill does not fit (deficient = 0) or A is
 * numerically singular: then col[n - deficient ..] are the dependent columns and rows with
 * step < 0 have no pivot. */
bool lin_lu_factor(lin_lu *f, const lin_columns *A);

/* b (by row) <- solution (by step k: x[k] belongs to column col[k]), written back at b[prow[k]]. */
void lin_lu_solve(const lin_lu *f, double *b);
