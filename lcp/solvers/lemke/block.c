#include "lcp/solvers/lemke/block.h"

#include <float.h>
#include <limits.h>
#include <math.h>

static const lemke_tolerance tolerance = {1e-11, 1e-12, false};

void lemke_block_layout(lemke_block *k, int rows, base_arena *a) {
  *k = (lemke_block){.path = {.deadline = HUGE_VAL}};
  lemke_path_layout(&k->path, rows, a);
  lemke_table_layout(&k->table, rows, a);
  k->power = BASE_ARRAY(a, int, rows);
}

/* Rows without a diagonal: the largest entry that joins them to a row with one, scaled there, becomes 1. */
static int power_of_zero(const lemke_block *k, int m, const double *M, int i) {
  int top = INT_MIN;
  for (int j = 0; j < m; ++j) {
    const double v = fmax(fabs(M[i + j * m]), fabs(M[j + i * m]));
    if (M[j + j * m] > 0 && v > 0) {
      const int e = lemke_exponent(v) + k->power[j];
      top = (e > top) ? e : top;
    }
  }
  return (top == INT_MIN) ? 0 : -top;
}

/* False where the numbers are too far apart for the tableau. */
static bool scale(lemke_block *k, int m, const double *M) {
  bool good = true;
  for (int i = 0; i < m; ++i) {
    k->power[i] = (M[i + i * m] > 0) ? -lemke_exponent(M[i + i * m]) / 2 : 0;
  }
  for (int i = 0; i < m; ++i) {
    if (!(M[i + i * m] > 0)) {
      k->power[i] = power_of_zero(k, m, M, i);
      good = good && k->power[i] >= -500 && k->power[i] <= 500;
    }
  }
  return good;
}

bool lemke_block_solve(lemke_block *k, int m, const double *M, const double *q, double *z) {
  lemke_engine *e = &k->table.engine;
  lemke_system *s = &k->system;
  if (!scale(k, m, M) || !lemke_system_over(s, m, M, q, k->power, k->power)) {
    return false;
  }
  memset(k->path.in_z, 0, (size_t)m);
  k->path.pivots = 0;
  k->path.pivot_limit = 100L * m;
  if (lemke_path_run(&k->path, e, s, tolerance) != LEMKE_SOLVED) {
    return false;
  }
  for (int i = 0; i < m; ++i) {
    const int at = e->where[m + i];
    z[i] = (at < 0) ? 0 : ldexp(lemke_larger(e->x[at], 0), s->q_exp + k->power[i]);
  }
  return true;
}

/* ---- the basis of the last solution ------------------------------------------------------------ */

static const double rounding = 8 * DBL_EPSILON; /* of a w_i, against the terms that it is made of */
static const double dependent = 1e-11;          /* of a pivot, against the largest of its column */

/* Gauss-Jordan with the largest pivot of the column. */
bool lemke_block_invert(int k, const int *row, int m, const double *M, double *inverse) {
  double A[LEMKE_KEPT_MAX * LEMKE_KEPT_MAX];
  for (int j = 0; j < k; ++j) {
    for (int i = 0; i < k; ++i) {
      A[i + j * k] = M[row[i] + row[j] * m];
      inverse[i + j * k] = i == j;
    }
  }
  for (int c = 0; c < k; ++c) {
    int p = c;
    double top = 0;
    for (int i = 0; i < k; ++i) {
      top = lemke_larger(fabs(M[row[i] + row[c] * m]), top);
      p = (i > c && fabs(A[i + c * k]) > fabs(A[p + c * k])) ? i : p;
    }
    if (!(fabs(A[p + c * k]) > dependent * top)) {
      return false;
    }
    const double pivot = A[p + c * k];
    for (int j = 0; j < k; ++j) {
      const double a = A[p + j * k] / pivot;
      const double b = inverse[p + j * k] / pivot;
      A[p + j * k] = A[c + j * k];
      inverse[p + j * k] = inverse[c + j * k];
      A[c + j * k] = a;
      inverse[c + j * k] = b;
    }
    for (int i = 0; i < k; ++i) {
      const double f = A[i + c * k];
      for (int j = 0; j < k && i != c; ++j) {
        A[i + j * k] -= f * A[c + j * k];
        inverse[i + j * k] -= f * inverse[c + j * k];
      }
    }
  }
  return true;
}

/* Is w = q + M x >= 0 to rounding where x_i is not basic? */
static bool rises(int m, unsigned support, const double *M, const double *q, const double *x) {
  for (int i = 0; i < m; ++i) {
    double w = q[i];
    double size = fabs(w);
    for (int j = 0; j < m && (support >> i & 1) == 0; ++j) {
      const double term = M[i + j * m] * x[j];
      w += term;
      size += fabs(term);
    }
    if ((support >> i & 1) == 0 && !(w >= -rounding * size)) {
      return false;
    }
  }
  return true;
}

bool lemke_block_stays(lemke_kept *kept, double *inverse, int m, const double *M, const double *q,
                       const double *z, double *x) {
  int row[LEMKE_KEPT_MAX] = {0};
  int k = 0;
  unsigned support = 0;
  for (int i = 0; i < m; ++i) {
    support |= (unsigned)(z[i] > 0) << i;
    row[k] = i;
    k += z[i] > 0;
    x[i] = 0;
  }
  if (support == 0) {
    return rises(m, support, M, q, x);
  }
  if (kept->support != support) {
    *kept =
        (lemke_kept){.support = support, .singular = !lemke_block_invert(k, row, m, M, inverse)};
  }
  for (int i = 0; i < k && !kept->singular; ++i) {
    double sum = 0;
    for (int j = 0; j < k; ++j) {
      sum -= inverse[i + j * k] * q[row[j]];
    }
    if (!(sum >= 0)) {
      return false;
    }
    x[row[i]] = sum;
  }
  return !kept->singular && rises(m, support, M, q, x);
}
