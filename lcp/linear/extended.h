/* linear/extended.h - sums of columns in extended precision. Reading and writing an 80-bit number costs more
 * than a product, so full columns are taken four in a sweep; each row's sum is in the order of the columns. */
#pragma once

enum { LIN_TOGETHER = 4 };

/* Full columns that are still to be added. */
typedef struct lin_extended {
  int n, count;
  long double *sum; /* n */
  const double *column[LIN_TOGETHER];
  long double t[LIN_TOGETHER];
} lin_extended;

/* Adds what waits: before sum is read. */
static inline void lin_extended_flush(lin_extended *e) {
  long double *sum = e->sum;
  if (e->count == LIN_TOGETHER) {
    const double *a = e->column[0], *b = e->column[1], *c = e->column[2], *d = e->column[3];
    const long double *t = e->t;
    for (int i = 0; i < e->n; ++i) {
      sum[i] = (((sum[i] + t[0] * (long double)a[i]) + t[1] * (long double)b[i]) +
                t[2] * (long double)c[i]) +
               t[3] * (long double)d[i];
    }
  } else if (e->count == 3) {
    const double *a = e->column[0], *b = e->column[1], *c = e->column[2];
    const long double *t = e->t;
    for (int i = 0; i < e->n; ++i) {
      sum[i] = ((sum[i] + t[0] * (long double)a[i]) + t[1] * (long double)b[i]) +
               t[2] * (long double)c[i];
    }
  } else if (e->count == 2) {
    const double *a = e->column[0], *b = e->column[1];
    for (int i = 0; i < e->n; ++i) {
      sum[i] = (sum[i] + e->t[0] * (long double)a[i]) + e->t[1] * (long double)b[i];
    }
  } else if (e->count == 1) {
    for (int i = 0; i < e->n; ++i) {
      sum[i] += e->t[0] * (long double)e->column[0][i];
    }
  }
  e->count = 0;
}

/* sum += t column; `entries` of them, in the rows `row` unless they are all. */
static inline void lin_extended_add(lin_extended *e, long double t, const double *column,
                                    const int *row, int entries) {
  if (entries == e->n) {
    e->column[e->count] = column;
    e->t[e->count++] = t;
    if (e->count == LIN_TOGETHER) {
      lin_extended_flush(e);
    }
    return;
  }
  for (int p = 0; p < entries; ++p) {
    e->sum[row[p]] += t * (long double)column[p];
  }
}
