#include "lcp/base/clones.h"
#include "lcp/linear/blocks_inside.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

static void layout_inverse(lin_blocks *s, base_arena *a) {
  s->inverse_low = BASE_ARRAY(a, double, s->cap_low);
  s->inverse_diag = BASE_ARRAY(a, double, s->cap_diag);
}

/* X <- X L^-1 for X of m rows, L lower triangular. */
BASE_INLINE void divide_lower_of(int m, int n, const double *L, double *X) {
  for (int c = n - 1; c >= 0; c--) {
    double *restrict x = X + c * m;
    for (int d = c + 1; d < n; d++) {
      const double f = L[d + c * n];
      const double *other = X + d * m;
      if (f != 0) {
        for (int r = 0; r < m; r++) {
          x[r] -= other[r] * f;
        }
      }
    }
    for (int r = 0; r < m; r++) {
      x[r] /= L[c + c * n];
    }
  }
}

BASE_CLONES static void divide_lower(int m, int n, const double *L, double *X) {
  if (m == 6 && n == 6) {
    divide_lower_of(6, 6, L, X);
  } else {
    divide_lower_of(m, n, L, X);
  }
}

/* to = X', X m x n, by columns. */
static const double *transpose(int m, int n, const double *X, double *to) {
  for (int c = 0; c < n; c++) {
    for (int r = 0; r < m; r++) {
      to[c + r * n] = X[r + c * m];
    }
  }
  return to;
}

/* Blocks of the inverse in column p below the diagonal: -Z V, V = L_Rp L_pp^-1; `own`: room for V', in the order of the
 * column. */
static void invert_below(lin_blocks *s, int p, double *own) {
  const int n = lin_blocks_rows(s, p), begin = s->column[p], end = s->column[p + 1];
  double turned[LIN_BLOCK_MAX * LIN_BLOCK_MAX];
  const size_t first = (begin < end) ? s->at[begin] : 0;
  for (int k = begin; k < end; k++) {
    const int m = lin_blocks_rows(s, s->row[k]);
    double *V = s->inverse_low + s->at[k];
    memcpy(V, s->low + s->at[k], (size_t)(m * n) * sizeof *V);
    divide_lower(m, n, s->diag + s->at_diag[p], V);
    (void)transpose(m, n, V, own + (s->at[k] - first));
    memset(V, 0, (size_t)(m * n) * sizeof *V);
  }
  for (int k = begin; k < end; k++) {
    const int i = s->row[k], height = lin_blocks_rows(s, i);
    const double *V = own + (s->at[k] - first);
    double *to = s->inverse_low + s->at[k];
    lin_blocks_subtract(to, s->inverse_diag + s->at_diag[i], V, height, n, height);
    int from = s->column[i];
    for (int m = k + 1; m < end; m++) { /* Z of the later block j and this one: both ways */
      const int j = s->row[m], wide = lin_blocks_rows(s, j);
      while (s->row[from] < j) {
        from++;
      }
      const double *Z = s->inverse_low + s->at[from];
      lin_blocks_subtract(to, transpose(wide, height, Z, turned), own + (s->at[m] - first), height,
                          n, wide);
      lin_blocks_subtract(s->inverse_low + s->at[m], Z, V, wide, n, height);
    }
  }
  for (int k = begin; k < end; k++) {
    const int m = lin_blocks_rows(s, s->row[k]);
    lin_blocks_subtract(s->inverse_diag + s->at_diag[p], own + (s->at[k] - first),
                        transpose(m, n, s->inverse_low + s->at[k], turned), n, n, m);
  }
}

base_status lin_blocks_invert(lin_blocks *s, base_error *err) {
  assert(s->symmetric);
  if (s->inverse_mem == NULL) {
    BASE_TRY(lin_blocks_memory(s, &s->inverse_mem, layout_inverse, err));
  }
  for (int p = s->n - 1; p >= 0; p--) {
    const int n = lin_blocks_rows(s, p);
    const double *L = s->diag + s->at_diag[p];
    double *Z = s->inverse_diag + s->at_diag[p], half[LIN_BLOCK_MAX * LIN_BLOCK_MAX] = {0};
    for (int k = 0; k < n; k++) {
      half[k + k * n] = 1;
    }
    divide_lower(n, n, L, half); /* L^-1 */
    memset(Z, 0, (size_t)(n * n) * sizeof *Z);
    for (int j = 0; j < n; j++) {
      for (int i = 0; i < n; i++) {
        for (int k = (i > j) ? i : j; k < n; k++) {
          Z[i + j * n] += half[k + i * n] * half[k + j * n];
        }
      }
    }
    invert_below(s, p, s->up); /* free while the matrix is symmetric */
  }
  return BASE_OK;
}

/* x' Z y, Z m x n by columns. */
static inline double form(int m, int n, const double *Z, const double *x, const double *y) {
  double sum = 0;
  for (int c = 0; c < n; c++) {
    double column = 0;
    for (int r = 0; r < m; r++) {
      column += x[r] * Z[r + c * m];
    }
    sum += column * y[c];
  }
  return sum;
}

double lin_blocks_inverse_form(const lin_blocks *s, int a, const double *x, int b,
                               const double *y) {
  const bool later = s->place[a] > s->place[b];
  const int i = s->place[later ? a : b], j = s->place[later ? b : a];
  const double *left = later ? x : y, *right = later ? y : x;
  const double *Z =
      (i == j) ? s->inverse_diag + s->at_diag[i] : s->inverse_low + s->at[lin_blocks_find(s, i, j)];
  const int m = lin_blocks_rows(s, i), n = lin_blocks_rows(s, j);
  return (m == 6 && n == 6) ? form(6, 6, Z, left, right) : form(m, n, Z, left, right);
}

void lin_blocks_drop_inverse(lin_blocks *s) {
  free(s->inverse_mem);
  s->inverse_mem = NULL;
}
