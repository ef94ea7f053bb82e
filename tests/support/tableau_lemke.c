#include "tests/support/tableau_lemke.h"

#include <string.h>

static const double pivot_tol = 1e-10; /* smaller elements are taken for zero */
static const double tie_tol = 1e-12;   /* equal ratios */

size_t tableau_lemke_work(int n) {
  const size_t k = (size_t)n;
  return k * (2 * k + 2) + k;
}

/* Columns: w 0..n-1, z n..2n-1, z0 2n, right-hand side 2n+1. */
static void pivot(double *T, int n, int r, int c) {
  const int width = 2 * n + 2;
  double *row = T + (ptrdiff_t)r * width;
  const double p = row[c];
  for (int k = 0; k < width; ++k) {
    row[k] /= p;
  }
  for (int i = 0; i < n; ++i) {
    double *restrict other = T + (ptrdiff_t)i * width;
    const double f = other[c];
    if (i != r && f != 0) {
      const double *restrict from = row;
      for (int k = 0; k < width; ++k) {
        other[k] -= f * from[k];
      }
    }
  }
}

/* Negative: row i before row j in the lexicographic order of [q, B^-1] / pivot element. */
static int compare(const double *T, int n, int i, int j, int c) {
  const int width = 2 * n + 2;
  const double *a = T + (ptrdiff_t)i * width;
  const double *b = T + (ptrdiff_t)j * width;
  const double pa = (c < 0) ? 1 : a[c];
  const double pb = (c < 0) ? 1 : b[c];
  const double x = a[width - 1] / pa - b[width - 1] / pb;
  if (x > tie_tol || x < -tie_tol) {
    return (x > 0) - (x < 0);
  }
  for (int k = 0; k < n; ++k) {
    const double y = a[k] / pa - b[k] / pb;
    if (y > tie_tol || y < -tie_tol) {
      return (y > 0) - (y < 0);
    }
  }
  return 0;
}

static int leaving_row(const double *T, int n, int c, const double *head) {
  int r = -1;
  for (int i = 0; i < n; ++i) {
    if (T[(ptrdiff_t)i * (2 * n + 2) + c] > pivot_tol && (r < 0 || compare(T, n, i, r, c) < 0)) {
      r = i;
    }
  }
  for (int i = 0; i < n && r >= 0; ++i) { /* prefer z0 among equal ratios */
    const double *a = T + (ptrdiff_t)i * (2 * n + 2);
    const double *b = T + (ptrdiff_t)r * (2 * n + 2);
    if ((int)head[i] == 2 * n && a[c] > pivot_tol &&
        a[2 * n + 1] / a[c] <= b[2 * n + 1] / b[c] + tie_tol) {
      return i;
    }
  }
  return r;
}

static void read_solution(const double *T, int n, const double *head, double *z) {
  const int width = 2 * n + 2;
  for (int i = 0; i < n; ++i) {
    if ((int)head[i] >= n) {
      z[(int)head[i] - n] = T[(ptrdiff_t)i * width + width - 1];
    }
  }
}

lcp_outcome tableau_lemke(int n, const double *M, const double *q, double *z, double *work,
                          long *pivots) {
  const int width = 2 * n + 2;
  double *T = work;
  double *head = work + (ptrdiff_t)n * width; /* basic variable of each row, small integers */
  int r = 0;
  memset(T, 0, sizeof(double) * (size_t)n * (size_t)width);
  memset(z, 0, sizeof(double) * (size_t)n);
  *pivots = 0;
  for (int i = 0; i < n; ++i) {
    double *row = T + (ptrdiff_t)i * width;
    row[i] = 1;
    for (int j = 0; j < n; ++j) {
      row[n + j] = -M[(ptrdiff_t)j * n + i];
    }
    row[2 * n] = -1;
    row[2 * n + 1] = q[i];
    head[i] = i;
    r = (compare(T, n, i, r, -1) < 0) ? i : r;
  }
  if (n == 0 || T[(ptrdiff_t)r * width + width - 1] >= 0) {
    return LCP_SOLVED;
  }
  for (int c = 2 * n; r >= 0;) {
    const int left = (int)head[r];
    pivot(T, n, r, c);
    head[r] = c;
    ++*pivots;
    if (left == 2 * n) {
      read_solution(T, n, head, z);
      return LCP_SOLVED;
    }
    if (*pivots >= 100L * n + 1000) {
      return LCP_MAX_ITER;
    }
    c = (left < n) ? left + n : left - n;
    r = leaving_row(T, n, c, head);
  }
  return LCP_RAY;
}
