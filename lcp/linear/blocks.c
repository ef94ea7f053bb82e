#include "lcp/linear/blocks.h"

#include "lcp/base/clones.h"
#include "lcp/linear/blocks_inside.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double singular = 1e-15; /* least pivot over the largest */

void lin_blocks_close(lin_blocks *s) {
  free(s->mem);
  free(s->row);
  free(s->at);
  free(s->value_mem);
  free(s->inverse_mem);
  free(s->pair);
  free(s->front_mem);
  free(s->dense_mem);
  *s = (lin_blocks){0};
}

void lin_blocks_rest(lin_blocks *s) {
  void **const numbers[] = {&s->value_mem, &s->inverse_mem, &s->dense_mem};
  for (int i = 0; i < BASE_COUNT(numbers); i++) {
    free(*numbers[i]);
    *numbers[i] = NULL;
  }
}

/* ---- entries --------------------------------------------------------------------------------- */

void lin_blocks_clear(lin_blocks *s, bool symmetric) {
  const int n = s->n;
  const size_t low = (s->column[n] > 0) ? s->at[s->column[n] - 1] : 0;
  const size_t last = (s->column[n] > 0) ? (size_t)LIN_BLOCK_MAX * LIN_BLOCK_MAX : 0;
  const size_t count = (low + last < s->cap_low) ? low + last : s->cap_low;
  s->symmetric = symmetric;
  memset(s->diag, 0, s->at_diag[n] * sizeof *s->diag);
  memset(s->low, 0, count * sizeof *s->low);
  if (!symmetric) {
    memset(s->up, 0, count * sizeof *s->up);
  }
}

int lin_blocks_find(const lin_blocks *s, int i, int j) {
  int low = s->column[j], high = s->column[j + 1] - 1;
  while (low < high) {
    const int mid = low + (high - low) / 2;
    if (s->row[mid] < i) {
      low = mid + 1;
    } else {
      high = mid;
    }
  }
  assert(s->row[low] == i);
  return low;
}

void lin_blocks_add(lin_blocks *s, int a, int b, const double *B) {
  const int i = s->place[a], j = s->place[b], m = lin_blocks_rows(s, i), n = lin_blocks_rows(s, j);
  if (i < j) { /* above: kept transposed, as B stands */
    double *to = s->up + (s->symmetric ? 0 : s->at[lin_blocks_find(s, j, i)]);
    for (int k = 0; !s->symmetric && k < m * n; k++) {
      to[k] += B[k];
    }
    return;
  }
  double *to = (i == j) ? s->diag + s->at_diag[i] : s->low + s->at[lin_blocks_find(s, i, j)];
  for (int r = 0; r < m; r++) {
    for (int c = 0; c < n; c++) {
      to[r + c * m] += B[r * n + c];
    }
  }
}

/* ---- numbers --------------------------------------------------------------------------------- */

/* X <- X T^-1 for X of m rows, column after column: T upper triangular is T(d, c) = t[d * across + c * down]. */
BASE_INLINE void divide_of(int m, int n, const double *t, int across, int down, bool unit,
                           double *X) {
  for (int c = 0; c < n; c++) {
    double *restrict x = X + c * m;
    for (int d = 0; d < c; d++) {
      const double f = t[d * across + c * down];
      const double *other = X + d * m;
      if (f != 0) {
        for (int r = 0; r < m; r++) {
          x[r] -= other[r] * f;
        }
      }
    }
    for (int r = 0; r < m && !unit; r++) {
      x[r] /= t[c * across + c * down];
    }
  }
}

BASE_CLONES static void divide(int m, int n, const double *t, int across, int down, bool unit,
                               double *X) {
  if (m == 6 && n == 6) {
    divide_of(6, 6, t, across, down, unit, X);
  } else {
    divide_of(m, n, t, across, down, unit, X);
  }
}

/* C -= X Y', C m x n, X m x k, Y n x k, all by columns. */
static inline void subtract_of(double *restrict C, const double *restrict X,
                               const double *restrict Y, int m, int n, int k) {
  for (int j = 0; j < n; j++) {
    for (int c = 0; c < k; c++) {
      const double f = Y[j + c * n];
      for (int i = 0; i < m; i++) {
        C[i + j * m] -= X[i + c * m] * f;
      }
    }
  }
}

BASE_CLONES void lin_blocks_subtract(double *C, const double *X, const double *Y, int m, int n,
                                     int k) {
  if (m == 6 && n == 6 && k == 6) {
    subtract_of(C, X, Y, 6, 6, 6);
  } else if (m == 3 && n == 3 && k == 3) {
    subtract_of(C, X, Y, 3, 3, 3);
  } else {
    subtract_of(C, X, Y, m, n, k);
  }
}

static void swap_columns(int m, int n, const int *swap, double *X) {
  for (int k = 0; k < n; k++) {
    for (int r = 0; r < m && swap[k] != k; r++) {
      const double x = X[r + k * m];
      X[r + k * m] = X[r + swap[k] * m];
      X[r + swap[k] * m] = x;
    }
  }
}

/* Factors the diagonal block of column p and divides the blocks below and right of it. */
static bool pivot_on(lin_blocks *s, int p, lin_span *pivots) {
  const int n = lin_blocks_rows(s, p);
  double *D = s->diag + s->at_diag[p];
  int *swap = s->swap + s->first[s->order[p]];
  if (!lin_blocks_pivot(s, n, D, swap, pivots)) {
    return false;
  }
  for (int k = s->column[p]; k < s->column[p + 1]; k++) {
    const int m = lin_blocks_rows(s, s->row[k]);
    if (s->symmetric) {
      divide(m, n, D, n, 1, false, s->low + s->at[k]); /* by L', L'(d, c) = L(c, d) */
      continue;
    }
    divide(m, n, D, 1, n, false, s->low + s->at[k]); /* by U */
    swap_columns(m, n, swap, s->up + s->at[k]);
    divide(m, n, D, n, 1, true, s->up + s->at[k]); /* by L' */
  }
  return true;
}

/* Takes column p out of the blocks that its rows span. */
static void update(lin_blocks *s, int p) {
  const int n = lin_blocks_rows(s, p);
  for (int k = s->column[p]; k < s->column[p + 1]; k++) {
    const int j = s->row[k], width = lin_blocks_rows(s, j);
    const double *left = s->low + s->at[k];
    const double *right = s->symmetric ? left : s->up + s->at[k];
    lin_blocks_subtract(s->diag + s->at_diag[j], left, right, width, width, n);
    int to = s->column[j];
    for (int m = k + 1; m < s->column[p + 1]; m++) {
      const int height = lin_blocks_rows(s, s->row[m]);
      while (s->row[to] < s->row[m]) {
        to++;
      }
      lin_blocks_subtract(s->low + s->at[to], s->low + s->at[m], right, height, width, n);
      if (!s->symmetric) {
        lin_blocks_subtract(s->up + s->at[to], s->up + s->at[m], left, height, width, n);
      }
    }
  }
}

bool lin_blocks_factor(lin_blocks *s) {
  lin_span pivots = {HUGE_VAL, 0};
  if (s->n_front > 0 && !lin_blocks_factor_fronts(s, &pivots)) {
    return false;
  }
  for (int p = 0; p < s->n && s->n_front == 0; p++) {
    if (!pivot_on(s, p, &pivots)) {
      return false;
    }
    update(s, p);
  }
  return s->n == 0 || !(pivots.low <= singular * pivots.high);
}

/* x <- the solution with the first factor of a diagonal block. */
static void forward(const lin_blocks *s, int n, const double *D, const int *swap, double *x) {
  for (int k = 0; k < n; k++) {
    if (!s->symmetric && swap[k] != k) {
      const double t = x[k];
      x[k] = x[swap[k]];
      x[swap[k]] = t;
    }
  }
  for (int k = 0; k < n; k++) {
    x[k] /= s->symmetric ? D[k + k * n] : 1.0;
    for (int i = k + 1; i < n; i++) {
      x[i] -= D[i + k * n] * x[k];
    }
  }
}

static void backward(const lin_blocks *s, int n, const double *D, double *x) {
  for (int k = n - 1; k >= 0; k--) {
    for (int i = k + 1; i < n; i++) {
      x[k] -= (s->symmetric ? D[i + k * n] : D[k + i * n]) * x[i];
    }
    x[k] /= D[k + k * n];
  }
}

/* to -= L x and x -= U' from, of blocks of m rows and n columns. */
BASE_INLINE void take_down(int m, int n, const double *L, const double *x, double *restrict to) {
  for (int c = 0; c < n; c++) {
    for (int r = 0; r < m; r++) {
      to[r] -= L[r + c * m] * x[c];
    }
  }
}

BASE_INLINE void take_up(int m, int n, const double *U, const double *from, double *restrict x) {
  for (int c = 0; c < n; c++) {
    double sum = 0;
    for (int r = 0; r < m; r++) {
      sum += U[r + c * m] * from[r];
    }
    x[c] -= sum;
  }
}

/* Rows stay where the caller has them: block p works on its own part of x. */
BASE_CLONES void lin_blocks_solve(const lin_blocks *s, double *x) {
  for (int p = 0; p < s->n; p++) {
    const int at = s->first[s->order[p]], n = lin_blocks_rows(s, p);
    forward(s, n, s->diag + s->at_diag[p], s->swap + at, x + at);
    for (int k = s->column[p]; k < s->column[p + 1]; k++) {
      const int m = lin_blocks_rows(s, s->row[k]);
      double *to = x + s->first[s->order[s->row[k]]];
      if (m == 6 && n == 6) {
        take_down(6, 6, s->low + s->at[k], x + at, to);
      } else {
        take_down(m, n, s->low + s->at[k], x + at, to);
      }
    }
  }
  for (int p = s->n - 1; p >= 0; p--) {
    const int at = s->first[s->order[p]], n = lin_blocks_rows(s, p);
    for (int k = s->column[p]; k < s->column[p + 1]; k++) {
      const int m = lin_blocks_rows(s, s->row[k]);
      const double *from = x + s->first[s->order[s->row[k]]];
      const double *U = (s->symmetric ? s->low : s->up) + s->at[k];
      if (m == 6 && n == 6) {
        take_up(6, 6, U, from, x + at);
      } else {
        take_up(m, n, U, from, x + at);
      }
    }
    backward(s, n, s->diag + s->at_diag[p], x + at);
  }
}
