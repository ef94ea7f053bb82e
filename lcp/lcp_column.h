/* lcp/lcp_column.h - the columns of a matrix of any storage, one at a time, in long double.
 *
 * LCP_FACTORED is walked through lists body -> groups, so a column costs what its neighbours have
 * and n x n is never formed. For judges, conversions and certificates; not for hot loops. */
#pragma once

#include "lcp/lcp_problem.h"

/* Rows strictly increasing; views, valid until the next call. */
typedef struct lcp_column {
  int count;
  const int *row;
  const long double *val;
} lcp_column;

typedef struct lcp_columns {
  const lcp_matrix *M;
  int *group_start, *group; /* per body: groups that touch it */
  int *group_of;            /* per row */
  unsigned char *marked;    /* per row: already in `row` */
  int *row;                 /* result */
  long double *val;
  long double *sum; /* per row: the column being gathered */
  long double *wj;  /* W J_j' of one body */
  void *mem;
} lcp_columns;

base_status lcp_columns_open(lcp_columns *c, const lcp_matrix *M, base_error *err);
lcp_column lcp_columns_at(lcp_columns *c, int j);
void lcp_columns_close(lcp_columns *c); /* accepts a zeroed struct */
