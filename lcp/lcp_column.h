/* lcp/lcp_column.h - one column of a matrix as it is stored: of M, or of S where M = J W J' + S is held in
 * factors. For the solvers and everything that prepares problems for them; the judge and the verifier of
 * certificates gather columns on their own (lcp_wide_column.h). */
#pragma once

#include "lcp/lcp_problem.h"

/* A view: entry k stands in row `row[k]`, ascending, or in row k where `row` is NULL (a dense column, which
 * then has all n entries). */
typedef struct lcp_column {
  int count;
  const int *row;
  const double *val;
} lcp_column;

/* Column j of m; one without entries where m is NULL. */
static inline lcp_column lcp_csc_column(const lcp_csc *m, int j) {
  static const int no_row = 0; /* `row` is not NULL: this is no dense column */
  if (m == NULL) {
    return (lcp_column){0, &no_row, NULL};
  }
  const int first = m->colptr[j];
  return (lcp_column){m->colptr[j + 1] - first, m->rowind + first, m->val + first};
}

/* Column j of what M stores: M itself, or S of the factored form. */
static inline lcp_column lcp_column_of(const lcp_matrix *M, int j) {
  switch (M->storage) {
  case LCP_DENSE:
    return (lcp_column){M->n, NULL, M->val + (size_t)j * (size_t)M->n};
  case LCP_CSC:
    return lcp_csc_column(&M->csc, j);
  case LCP_FACTORED:
    break;
  }
  return lcp_csc_column(M->factored->shift, j);
}

static inline int lcp_column_row(const lcp_column *c, int k) {
  return (c->row != NULL) ? c->row[k] : k;
}

/* y += x c. */
static inline void lcp_column_add(lcp_column c, double x, double *restrict y) {
  if (c.row == NULL) {
    for (int i = 0; i < c.count; i++) {
      y[i] += c.val[i] * x;
    }
    return;
  }
  for (int k = 0; k < c.count; k++) {
    y[c.row[k]] += c.val[k] * x;
  }
}

/* size += |x| |c|. */
static inline void lcp_column_add_size(lcp_column c, double x, double *restrict size) {
  if (c.row == NULL) {
    for (int i = 0; i < c.count; i++) {
      size[i] += fabs(c.val[i] * x);
    }
    return;
  }
  for (int k = 0; k < c.count; k++) {
    size[c.row[k]] += fabs(c.val[k] * x);
  }
}

/* y += x c, size += |x| |c|: a product with the sum of its absolute terms. */
static inline void lcp_column_add_sized(lcp_column c, double x, double *restrict y,
                                        double *restrict size) {
  if (c.row == NULL) {
    for (int i = 0; i < c.count; i++) {
      const double term = c.val[i] * x;
      y[i] += term;
      size[i] += fabs(term);
    }
    return;
  }
  for (int k = 0; k < c.count; k++) {
    const double term = c.val[k] * x;
    y[c.row[k]] += term;
    size[c.row[k]] += fabs(term);
  }
}
