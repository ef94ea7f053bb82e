/* linear/packed_chol.h - Cholesky factor L L' of a matrix that gains and loses rows one at a time.
 *
 * L is lower triangular, packed by rows: row k starts at k (k + 1) / 2. Appending costs one forward
 * substitution, removing one sweep of Givens rotations (Gill, Golub, Murray & Saunders 1974,
 * method C1); both are backward stable, so no periodic refactorisation is needed. */
#pragma once

#include <stddef.h>

/* x <- L^-1 x, x <- L'^-1 x, for the leading m x m factor. */
void lin_chol_forward(const double *L, int m, double *x);
void lin_chol_backward(const double *L, int m, double *x);

/* Row m of L from x = L^-1 (new column) and the square root of the Schur complement. */
void lin_chol_append(double *L, int m, const double *x, double root);

/* Removes row and column p of the m x m matrix. cs: scratch of 2 m doubles. */
void lin_chol_remove(double *L, int m, int p, double *cs);

static inline size_t lin_chol_row(int k) {
  return (size_t)k * ((size_t)k + 1) / 2;
}
