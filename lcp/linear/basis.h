/* linear/basis.h - basis of  w - M z - d z0 = q  for complementary pivoting.
 *
 * Of the N columns of a basis those of w are unit vectors, so only the kernel - the basic z (and
 * z0) against the rows whose w is nonbasic - is factored: its size is the number of active
 * unknowns, not N. Between factorisations the product form of the inverse takes one column a pivot
 * (Dantzig & Orchard-Hays 1954); a new factorisation is due once the product-form columns have
 * cost as much as the last factorisation, when their memory is full, or on demand.
 */
#pragma once

#include "lcp/linear/sparse_lu.h"

/* Variables: w_i = i, z_j = N + j, z0 = 2N. */
typedef struct lin_system {
  int n;
  const int *colptr; /* of M, n+1 */
  const int *rowind;
  const double *val;
  const double *cover; /* d, n */
} lin_system;

enum { LIN_ETA_MAX = 128 }; /* product-form columns at most */

typedef struct lin_basis {
  const lin_system *sys;
  int cap_n, cap_nnz;
  int *head;  /* cap_n: variable in each row position */
  int *where; /* 2 cap_n + 1: row position of a variable, -1 when nonbasic */
  bool full;  /* the last failure was lack of memory, not singularity */
  bool fresh; /* factored, and no column replaced since */

  lin_lu lu;
  int kernel_size;
  int *kernel_var; /* cap_n */
  int *kernel_row; /* cap_n: rows of the kernel */
  int *local;      /* cap_n: row -> place in the kernel, -1 outside */
  int *kcolptr, *krowind;
  double *kval;
  double *work;   /* cap_n, by place in the kernel */
  double *active; /* cap_n, by kernel column */

  size_t cap_eta;
  int n_eta;
  double eta_flops;
  size_t *eta_first; /* LIN_ETA_MAX + 1 */
  int *eta_pos;      /* LIN_ETA_MAX */
  double *eta_pivot; /* LIN_ETA_MAX */
  int *eta_index;    /* cap_eta */
  double *eta_value; /* cap_eta */

  long factorizations, backsolves;
} lin_basis;

/* n: rows; nnz: entries of M; kernels may be as large as n. */
void lin_basis_layout(lin_basis *b, int n, int nnz, base_arena *a);

/* Starts from the basis whose variable of pair i is z_i where in_z[i], else w_i. Not factored. */
void lin_basis_start(lin_basis *b, const lin_system *sys, const unsigned char *in_z);

/* Factors the variables in head; positions may change. False: see `full`, or singular with
 * dependent kernel columns kernel_var[lu.col[lu.n - lu.deficient ..]]. */
bool lin_basis_factor(lin_basis *b);

/* x (right-hand side by row) <- B^-1 x (by row position). */
void lin_basis_solve(lin_basis *b, double *x);

/* x <- column of `var` (dense, by row). */
void lin_basis_column(const lin_basis *b, int var, double *x);

/* sum <- r - B y, accumulated in extended precision (for refinement). */
void lin_basis_residual(const lin_basis *b, const double *y, const double *r, long double *sum);

/* Replaces the variable in position p by `var`, whose column solved to d. */
void lin_basis_replace(lin_basis *b, int p, int var, const double *d);

/* True when a new factorisation pays or is needed before the next replace. */
bool lin_basis_due(const lin_basis *b);
