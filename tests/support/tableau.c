#include "tests/support/tableau.h"

#include <stdlib.h>
#include <string.h>

typedef long double real;

/* M column by column; to be freed. */
static double *formed(const lcp_matrix *M) {
  double *dense = calloc((size_t)M->n * (size_t)M->n + 1, sizeof *dense);
  lcp_matrix_to_dense(M, dense);
  return dense;
}

static real absolute(real x) {
  return (x < 0) ? -x : x;
}

/* Rows of T are w_i = ...; exchanges basic variable of row r with column c. */
static void pivot(real *T, int n, int width, int r, int c) {
  real *row = T + (ptrdiff_t)r * width;
  const real p = row[c];
  for (int k = 0; k < width; k++) {
    row[k] /= p;
  }
  for (int i = 0; i < n; i++) {
    real *other = T + (ptrdiff_t)i * width;
    const real f = other[c];
    if (i != r && f != 0) {
      for (int k = 0; k < width; k++) {
        other[k] -= f * row[k];
      }
    }
  }
}

/* Columns: w (n), z (n), z0, q. Row r before row s in the lexicographic order of [q | w] / T[.][c]. */
static bool before(const real *T, int n, int width, int r, int s, int c) {
  const real *a = T + (ptrdiff_t)r * width;
  const real *b = T + (ptrdiff_t)s * width;
  for (int k = -1; k < n; k++) {
    const int at = (k < 0) ? width - 1 : k;
    const real x = a[at] / a[c];
    const real y = b[at] / b[c];
    if (absolute(x - y) > 1e-11L * (absolute(x) + absolute(y))) {
      return x < y;
    }
  }
  return r < s;
}

static int ratio_test(const real *T, int n, int width, int c, const int *basis) {
  real largest = 0;
  for (int i = 0; i < n; i++) {
    largest = (T[(ptrdiff_t)i * width + c] > largest) ? T[(ptrdiff_t)i * width + c] : largest;
  }
  int leave = -1;
  for (int i = 0; i < n; i++) {
    if (T[(ptrdiff_t)i * width + c] > 1e-10L * (1 + largest)) {
      if (leave < 0 || before(T, n, width, i, leave, c)) {
        leave = i;
      }
    }
  }
  /* z0 leaves as soon as it may */
  for (int i = 0; i < n && leave >= 0; i++) {
    const real d = T[(ptrdiff_t)i * width + c];
    if (basis[i] == 2 * n && d > 1e-10L * (1 + largest)) {
      const real x = T[(ptrdiff_t)i * width + width - 1] / d;
      const real y = T[(ptrdiff_t)leave * width + width - 1] / T[(ptrdiff_t)leave * width + c];
      leave = (x <= y + 1e-12L * (1 + absolute(y))) ? i : leave;
    }
  }
  return leave;
}

static lcp_outcome lemke(real *T, int n, int *basis) {
  const int width = 2 * n + 2;
  int r = -1;
  for (int i = 0; i < n; i++) {
    const real q = T[(ptrdiff_t)i * width + width - 1];
    if (q < 0 && (r < 0 || q < T[(ptrdiff_t)r * width + width - 1])) {
      r = i;
    }
  }
  if (r < 0) {
    return LCP_SOLVED;
  }
  int enter = 2 * n;
  for (int it = 0; it < 200 * n + 200; it++) {
    const int left = basis[r];
    pivot(T, n, width, r, enter);
    basis[r] = enter;
    if (left == 2 * n) {
      return LCP_SOLVED;
    }
    enter = (left < n) ? left + n : left - n;
    r = ratio_test(T, n, width, enter, basis);
    if (r < 0) {
      return LCP_RAY;
    }
  }
  return LCP_MAX_ITER;
}

/* Free rows first: their z becomes basic by ordinary elimination. */
static bool is_free(const lcp_problem *p, int i) {
  for (int b = 0; p->block != NULL && b < p->n_block; b++) {
    if (i >= p->block[b].start && i < p->block[b].start + p->block[b].size) {
      return p->block[b].set == LCP_FREE;
    }
  }
  return false;
}

static bool eliminate_free(const lcp_problem *p, real *F, int n) {
  for (int i = 0; i < n; i++) { /* F: w = M z + q as rows of n+1, pivoted in place */
    if (!is_free(p, i)) {
      continue;
    }
    real *row = F + (ptrdiff_t)i * (n + 1);
    const real d = row[i];
    if (absolute(d) < 1e-14L) {
      return false;
    }
    for (int k = 0; k <= n; k++) {
      row[k] = (k == i) ? 0 : -row[k] / d; /* z_i = row . (z, 1) */
    }
    for (int j = 0; j < n; j++) {
      real *other = F + (ptrdiff_t)j * (n + 1);
      const real f = other[i];
      if (j != i && f != 0) {
        other[i] = 0;
        for (int k = 0; k <= n; k++) {
          other[k] += f * row[k];
        }
      }
    }
  }
  return true;
}

lcp_outcome tableau_solve(const lcp_problem *p, double *z) {
  const int n = p->M.n;
  real *F = calloc((size_t)n * (size_t)(n + 1), sizeof *F);
  int *kept = calloc((size_t)n + 1, sizeof *kept);
  double *M = formed(&p->M);
  int m = 0;
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++) {
      F[(ptrdiff_t)i * (n + 1) + j] = M[(ptrdiff_t)j * n + i];
    }
    F[(ptrdiff_t)i * (n + 1) + n] = p->q[i];
    z[i] = 0;
    if (!is_free(p, i)) {
      kept[m++] = i;
    }
  }
  lcp_outcome out = eliminate_free(p, F, n) ? LCP_SOLVED : LCP_NUMERICAL;
  const int width = 2 * m + 2;
  real *T = calloc((size_t)m * (size_t)width + 1, sizeof *T);
  int *basis = calloc((size_t)m + 1, sizeof *basis);
  for (int i = 0; i < m; i++) {
    real *row = T + (ptrdiff_t)i * width;
    basis[i] = i;
    row[i] = 1;
    for (int j = 0; j < m; j++) {
      row[m + j] = -F[(ptrdiff_t)kept[i] * (n + 1) + kept[j]];
    }
    row[2 * m] = -1;
    row[2 * m + 1] = F[(ptrdiff_t)kept[i] * (n + 1) + n];
  }
  out = (out == LCP_SOLVED) ? lemke(T, m, basis) : out;
  for (int i = 0; i < m; i++) {
    if (basis[i] >= m && basis[i] < 2 * m) {
      z[kept[basis[i] - m]] = (double)T[(ptrdiff_t)i * width + 2 * m + 1];
    }
  }
  for (int i = 0; i < n; i++) {
    if (is_free(p, i)) {
      real sum = F[(ptrdiff_t)i * (n + 1) + n];
      for (int j = 0; j < m; j++) {
        sum += F[(ptrdiff_t)i * (n + 1) + kept[j]] * (real)z[kept[j]];
      }
      z[i] = (double)sum;
    }
  }
  free(M);
  free(F);
  free(kept);
  free(T);
  free(basis);
  return out;
}

double tableau_residual(const lcp_problem *p, const double *z) {
  double worst = 0;
  double scale = 1;
  double *M = formed(&p->M);
  for (int i = 0; i < p->M.n; i++) {
    double w = p->q[i];
    for (int j = 0; j < p->M.n; j++) {
      w += M[(ptrdiff_t)j * p->M.n + i] * z[j];
    }
    scale = fmax(scale, 1 + fabs(p->q[i]));
    worst = fmax(worst, is_free(p, i) ? fabs(w) : fabs(fmin(z[i], w)));
  }
  free(M);
  return worst / scale;
}
