#include "lcp/solvers/small_lemke.h"

#include <math.h>

/* Rows of the tableau are w_r = ...: [ w_1..w_m | z_1..z_m | z_0 | q ], basis inverse in front. */
typedef struct tableau {
  int m, stride;
  double *t;    /* m x stride, row-major */
  double *s;    /* m, scaling */
  int *basis;   /* m, column of each basic variable */
  double *work; /* m */
} tableau;

static void scale(const tableau *t, const double *M) {
  const int m = t->m;
  for (int i = 0; i < m; i++) {
    t->s[i] = (M[i + i * m] > 0.0) ? 1.0 / sqrt(M[i + i * m]) : 0.0;
  }
  for (int i = 0; i < m; i++) {
    double top = 0.0;
    for (int j = 0; t->s[i] == 0.0 && j < m; j++) {
      if (M[j + j * m] > 0.0) {
        top = fmax(top, fmax(fabs(M[i + j * m]), fabs(M[j + i * m])) / sqrt(M[j + j * m]));
      }
    }
    t->work[i] = (t->s[i] != 0.0) ? t->s[i] : ((top > 0.0) ? 1.0 / top : 1.0);
  }
  for (int i = 0; i < m; i++) {
    t->s[i] = t->work[i];
  }
}

static void fill(const tableau *t, const double *M, const double *q) {
  const int m = t->m;
  for (int i = 0; i < m; i++) {
    double *row = t->t + (size_t)i * (size_t)t->stride;
    for (int j = 0; j < m; j++) {
      row[j] = (i == j) ? 1.0 : 0.0;
      row[m + j] = -t->s[i] * M[i + j * m] * t->s[j];
    }
    row[t->stride - 2] = -1.0;
    row[t->stride - 1] = t->s[i] * q[i];
    t->basis[i] = i;
  }
}

static void pivot(const tableau *t, int r, int column) {
  double *row = t->t + (size_t)r * (size_t)t->stride;
  const double inverse = 1.0 / row[column];
  for (int j = 0; j < t->stride; j++) {
    row[j] *= inverse;
  }
  row[column] = 1.0;
  for (int i = 0; i < t->m; i++) {
    double *other = t->t + (size_t)i * (size_t)t->stride;
    const double f = other[column];
    if (i != r && f != 0.0) {
      for (int j = 0; j < t->stride; j++) {
        other[j] -= f * row[j];
      }
      other[column] = 0.0;
    }
  }
  t->basis[r] = column;
}

/* Sign of (row a)/da - (row b)/db in the order q, then the basis inverse; ties within 1e-12. */
static bool before(const tableau *t, int a, int b, int column) {
  const double *ra = t->t + (size_t)a * (size_t)t->stride;
  const double *rb = t->t + (size_t)b * (size_t)t->stride;
  const int q = 2 * t->m + 1;
  for (int k = -1; k < t->m; k++) {
    const int j = (k < 0) ? q : k;
    const double x = ra[j] / ra[column], y = rb[j] / rb[column];
    if (fabs(x - y) > 1e-12 * fmax(1.0, fmax(fabs(x), fabs(y)))) {
      return x < y;
    }
  }
  return false;
}

/* Leaving row for the entering column, z_0's row where it ties; -1: ray. */
static int leaving(const tableau *t, int column) {
  int best = -1, z0 = -1;
  for (int i = 0; i < t->m; i++) {
    const double *row = t->t + (size_t)i * (size_t)t->stride;
    if (row[column] > 1e-11) {
      z0 = (t->basis[i] == 2 * t->m) ? i : z0;
      best = (best < 0 || before(t, i, best, column)) ? i : best;
    }
  }
  if (z0 >= 0 && z0 != best) {
    const int q = 2 * t->m + 1;
    const double *rz = t->t + (size_t)z0 * (size_t)t->stride;
    const double *rb = t->t + (size_t)best * (size_t)t->stride;
    const double x = rz[q] / rz[column], y = rb[q] / rb[column];
    best = (x <= y + 1e-12 * fmax(1.0, fabs(y))) ? z0 : best;
  }
  return best;
}

static bool run(const tableau *t) {
  const int m = t->m, q = 2 * m + 1;
  int first = 0;
  for (int i = 1; i < m; i++) { /* lexicographically smallest (q_i, e_i): the last of equals */
    first = (t->t[(size_t)i * (size_t)t->stride + (size_t)q] <=
             t->t[(size_t)first * (size_t)t->stride + (size_t)q])
                ? i
                : first;
  }
  if (t->t[(size_t)first * (size_t)t->stride + (size_t)q] >= 0.0) {
    return true;
  }
  int column = m + t->basis[first];
  pivot(t, first, 2 * m);
  for (int k = 0; k < 100 * m; k++) {
    const int r = leaving(t, column);
    if (r < 0) {
      return false;
    }
    const int out = t->basis[r];
    pivot(t, r, column);
    if (out == 2 * m) {
      return true;
    }
    column = (out < m) ? out + m : out - m;
  }
  return false;
}

bool lcp_small_lemke(int m, const double *M, const double *q, double *z, double *work) {
  int basis[LCP_SMALL_MAX] = {0};
  tableau t = {.m = m, .stride = 2 * m + 2, .t = work, .basis = basis};
  t.s = work + (size_t)m * (size_t)t.stride;
  t.work = t.s + m;
  scale(&t, M);
  double top = 0.0; /* q to size one: the tie test above is relative to it */
  for (int i = 0; i < m; i++) {
    top = fmax(top, t.s[i] * fabs(q[i]));
  }
  top = (top > 0.0) ? top : 1.0;
  for (int i = 0; i < m; i++) {
    t.work[m + i] = q[i] / top;
  }
  fill(&t, M, t.work + m);
  if (!run(&t)) {
    return false;
  }
  for (int i = 0; i < m; i++) {
    z[i] = 0.0;
  }
  for (int i = 0; i < m; i++) {
    const int k = t.basis[i] - m;
    if (k >= 0 && k < m) {
      z[k] = fmax(0.0, t.t[(size_t)i * (size_t)t.stride + (size_t)(2 * m + 1)]) * top * t.s[k];
    }
  }
  return true;
}
