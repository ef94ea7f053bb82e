/* lcp/lcp_wide_column.h - the columns of a matrix of any storage, one at a time, in long double.
 *
 * LCP_FACTORED is walked through lists body -> groups, so a column costs what its neighbours have and n x n
 * is never formed. Over all its columns two sums are made without them: M z, through the factors, and |M| x, whose entries are
 * then in double. For the judge, the verifier and conversions. Solvers read lcp_column.h: an error in one of
 * the two readings of a matrix then shows as a verdict that differs. */
#pragma once

#include "lcp/lcp_problem.h"

/* Rows strictly increasing; views, valid until the next call. */
typedef struct lcp_wide_column {
  int count;
  const int *row;
  const long double *val;
} lcp_wide_column;

typedef struct lcp_wide_columns {
  const lcp_matrix *M;
  int *group_start, *group;    /* per body: groups that touch it */
  int *group_of;               /* per row */
  unsigned char *marked;       /* per row: already in `row` */
  int *row;                    /* n: rows of the column at hand */
  long double *val;            /* n */
  long double *sum;            /* per row: the column being gathered */
  long double *wj;             /* per dof: W J' z, or W J_j' of one body from 0 on */
  long double *force;          /* per dof */
  double *x;                   /* sums in double, per row */
  struct lcp_wide_scratch *of; /* per hand of the crew that it was opened with */
  int hands;
  void *mem; /* owned */
} lcp_wide_columns;

/* BASE_ENOMEM. M is borrowed until the close. */
base_status lcp_wide_columns_open(lcp_wide_columns *c, const lcp_matrix *M, base_error *err);
lcp_wide_column lcp_wide_columns_at(lcp_wide_columns *c, int j);
/* The rows of column j of an LCP_FACTORED matrix alone, into c->row; returns how many. Rows of bodies that
 * row j of J does not move are left out, rows whose entry happens to be zero are not. */
int lcp_wide_columns_rows(lcp_wide_columns *c, int j);
/* Of an LCP_FACTORED matrix: w += M z; size_i += sum_j |M_ij| x_j for x >= 0; d_j = M_jj. z, w, x, size, d: n. */
void lcp_wide_factored_product(lcp_wide_columns *c, const double *z, long double *w);
void lcp_wide_factored_sizes(lcp_wide_columns *c, const long double *x, long double *size);
void lcp_wide_factored_diagonal(lcp_wide_columns *c, double *d);
/* The rows of J of group g on the body of one side, rows x dofs, row-major: a view, or made in `room` (LCP_MIXED_MAX). */
const double *lcp_wide_factored_rows(const lcp_factored *f, int g, int side, double *room);
void lcp_wide_columns_close(lcp_wide_columns *c); /* accepts a zeroed struct */
