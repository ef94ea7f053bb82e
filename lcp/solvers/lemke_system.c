/* The scaled column form of a problem. Scaling by powers of two changes no digit. Columns are always
 * scaled to maximum 1..2; rows only when they differ by more than 2^20, because a row scaling is a
 * choice of covering vector and d = 1 is to mean what it says. */
#include "lcp/solvers/lemke.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

enum { SPREAD = 20 }; /* rows whose maxima are apart by more than 2^20 are scaled */
enum { PASSES = 12 }; /* each halves the exponents (Ruiz 2001), enough for 2^1000 */

void lemke_system_layout(lemke_system *s, const lcp_capacity *cap, base_arena *a) {
  const size_t rows = (size_t)cap->n + (size_t)cap->n_dof;
  const size_t nnz = (size_t)cap->nnz + 2 * (size_t)cap->n_jac + (size_t)cap->n_dof;
  *s = (lemke_system){.n = cap->n};
  s->colptr = BASE_ARRAY(a, int, rows + 1);
  s->rowind = BASE_ARRAY(a, int, nnz);
  s->val = BASE_ARRAY(a, double, nnz);
  s->jptr = BASE_ARRAY(a, int, (cap->n_dof > 0) ? cap->n + 1 : 0);
  s->jdof = BASE_ARRAY(a, int, cap->n_jac);
  s->jval = BASE_ARRAY(a, double, cap->n_jac);
  s->q = BASE_ARRAY(a, double, rows);
  s->row_exp = BASE_ARRAY(a, int, rows);
  s->col_exp = BASE_ARRAY(a, int, rows);
  s->row_top = BASE_ARRAY(a, int, rows);
  s->col_top = BASE_ARRAY(a, int, rows);
  s->diagonal = BASE_ARRAY(a, double, cap->n);
  s->w = BASE_ARRAY(a, long double, rows);
  s->row_sum = BASE_ARRAY(a, long double, rows);
  s->tau0 = BASE_ARRAY(a, double, rows);
  s->zref = BASE_ARRAY(a, double, rows);
  s->is_free = BASE_ARRAY(a, unsigned char, rows);
  s->force = BASE_ARRAY(a, lcp_farkas_sum, cap->n_dof);
}

static int push(lemke_system *s, int at, int row, double v) {
  if (v != 0) {
    s->rowind[at] = row;
    s->val[at++] = v;
  }
  return at;
}

static void columns_of_dense(lemke_system *s, const lcp_matrix *M) {
  int at = 0;
  int *restrict rowind = s->rowind;
  double *restrict val = s->val;
  for (int j = 0; j < M->n; ++j) {
    const double *column = M->val + (size_t)j * (size_t)M->n;
    s->colptr[j] = at;
    for (int i = 0; i < M->n; ++i) { /* a zero is overwritten by what follows */
      rowind[at] = i;
      val[at] = column[i];
      at += column[i] != 0;
    }
  }
  s->colptr[M->n] = at;
}

static void columns_of_csc(lemke_system *s, const lcp_csc *M) {
  int at = 0;
  for (int j = 0; j < M->n_col; ++j) {
    s->colptr[j] = at;
    for (int p = M->colptr[j]; p < M->colptr[j + 1]; ++p) {
      at = push(s, at, M->rowind[p], M->val[p]);
    }
  }
  s->colptr[M->n_col] = at;
}

/* v = W x, W symmetric n x n: by columns, the sums of neighbours side by side. */
static inline void weigh(const double *restrict W, const double *restrict x, double *restrict v,
                         int n) {
  for (int i = 0; i < n; ++i) {
    double sum = 0;
    for (int k = 0; k < n; ++k) {
      sum += W[k * n + i] * x[k];
    }
    v[i] = sum;
  }
}

/* Entries of W J' in a column of the impulses, for one side of a group. */
static int body_velocity(lemke_system *s, const lcp_factored *f, int body, const double *jac,
                         int at) {
  const int first = f->dof_start[body];
  const int size = f->dof_start[body + 1] - first;
  const double *W = f->weight + f->weight_start[body];
  double *v = s->zref; /* rows: at least as long */
  if (size == 6) {
    weigh(W, jac, v, 6);
  } else {
    weigh(W, jac, v, size);
  }
  for (int i = 0; i < size; ++i) {
    at = push(s, at, s->n + first + i, v[i]);
  }
  return at;
}

static int shift_column(lemke_system *s, const lcp_csc *S, int j, int at) {
  for (int p = (S != NULL) ? S->colptr[j] : 0; S != NULL && p < S->colptr[j + 1]; ++p) {
    at = push(s, at, S->rowind[p], S->val[p]);
  }
  return at;
}

/* The impulse columns of  [S J; WJ' -I]: body velocities u = W J' z become free unknowns, so that
 * no product of two contacts is ever formed (Lloyd 2005). */
static int impulse_columns(lemke_system *s, const lcp_factored *f) {
  int at = 0;
  for (int j = 0, g = 0; j < s->n; ++j) {
    while (j == f->row_start[g + 1]) {
      ++g;
    }
    const int rows = f->row_start[g + 1] - f->row_start[g];
    const double *jac = f->jac + f->jac_start[g];
    s->colptr[j] = at;
    at = shift_column(s, f->shift, j, at);
    for (int k = 0; k < 2; ++k) {
      const int body = f->body[2 * g + k];
      const int size = (body < 0) ? 0 : f->dof_start[body + 1] - f->dof_start[body];
      at = (body < 0)
               ? at
               : body_velocity(s, f, body, jac + (ptrdiff_t)(j - f->row_start[g]) * size, at);
      jac += (ptrdiff_t)rows * size;
    }
  }
  return at;
}

static void row_entries(lemke_system *s, int row, const double *jac, int size, int *next,
                        bool store) {
  for (int c = 0; c < size; ++c) {
    if (store && jac[c] != 0) {
      s->rowind[next[c]] = row;
      s->val[next[c]] = jac[c];
    }
    next[c] += jac[c] != 0;
  }
}

/* Counts the entries of J in group g by column, or stores them where next says. */
static void group_entries(lemke_system *s, const lcp_factored *f, int g, int *next, bool store) {
  const double *jac = f->jac + f->jac_start[g];
  const int rows = f->row_start[g + 1] - f->row_start[g];
  for (int k = 0; k < 2; ++k) {
    const int body = f->body[2 * g + k];
    const int first = (body < 0) ? 0 : f->dof_start[body];
    const int size = (body < 0) ? 0 : f->dof_start[body + 1] - first;
    for (int r = 0; r < rows; ++r, jac += size) {
      row_entries(s, f->row_start[g] + r, jac, size, next + first, store);
    }
  }
}

static int velocity_columns(lemke_system *s, const lcp_factored *f, int at) {
  const int n_dof = f->dof_start[f->n_body];
  int *next = s->row_top; /* counts first, then where the next entry goes */
  memset(next, 0, sizeof(int) * (size_t)n_dof);
  for (int g = 0; g < f->n_group; ++g) {
    group_entries(s, f, g, next, false);
  }
  for (int c = 0; c < n_dof; ++c) { /* one more entry each, the last: the diagonal */
    const int count = next[c];
    s->colptr[s->n + c] = at;
    next[c] = at;
    at += count + 1;
    s->rowind[at - 1] = s->n + c;
    s->val[at - 1] = -1;
  }
  for (int g = 0; g < f->n_group; ++g) {
    group_entries(s, f, g, next, true);
  }
  return at;
}

/* ilogb without the call; a subnormal number takes the long way. */
static int exponent(double v) {
  uint64_t bits;
  memcpy(&bits, &v, sizeof bits);
  const int e = (int)(bits >> 52 & 0x7ff);
  return (e == 0) ? ilogb(v) : e - 1023;
}

/* ldexp without the call: a product with a power of two, where that is a normal number. */
static double scaled(double v, int e) {
  if (e < -1022 || e > 1023) {
    return ldexp(v, e);
  }
  const uint64_t bits = (uint64_t)(e + 1023) << 52;
  double power;
  memcpy(&power, &bits, sizeof power);
  return v * power;
}

/* Largest binary exponents of rows and columns under the present scaling. */
static void measure(lemke_system *s) {
  for (int i = 0; i < s->rows; ++i) {
    s->row_top[i] = INT_MIN;
    s->col_top[i] = INT_MIN;
  }
  for (int j = 0; j < s->rows; ++j) {
    for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
      const int i = s->rowind[p];
      const int e = exponent(s->val[p]) + s->row_exp[i] + s->col_exp[j];
      s->row_top[i] = (e > s->row_top[i]) ? e : s->row_top[i];
      s->col_top[j] = (e > s->col_top[j]) ? e : s->col_top[j];
    }
  }
}

/* Distance between the largest and the smallest of the exponents; empty rows do not count. */
static int spread(const int *top, int n) {
  int low = INT_MAX;
  int high = INT_MIN;
  for (int i = 0; i < n; ++i) {
    low = (top[i] != INT_MIN && top[i] < low) ? top[i] : low;
    high = (top[i] > high) ? top[i] : high;
  }
  return (low > high) ? 0 : high - low;
}

static void shift_down(int *exponent, const int *top, int n, int divisor) {
  for (int i = 0; i < n; ++i) {
    exponent[i] -= (top[i] == INT_MIN) ? 0 : top[i] / divisor;
  }
}

/* Columns to maximum 1..2, the first step of every scaling. */
static void scale_columns(lemke_system *s) {
  for (int j = 0; j < s->rows; ++j) {
    const double top = lemke_largest(s->val + s->colptr[j], s->colptr[j + 1] - s->colptr[j]);
    s->row_exp[j] = 0;
    s->col_exp[j] = (top > 0) ? -exponent(top) : 0;
  }
}

/* top_i <- max(top_i, |v_i| unit) for the entries of one column of n rows; a full one needs no index. */
static void raise_tops(const double *restrict v, const int *row, int count, int n, double unit,
                       double *restrict top) {
  for (int p = 0; p < count && count < n; ++p) {
    top[row[p]] = lemke_larger(fabs(v[p]) * unit, top[row[p]]);
  }
  for (int i = 0; i < count && count == n; ++i) {
    top[i] = lemke_larger(fabs(v[i]) * unit, top[i]);
  }
}

/* Largest entries of the rows with columns scaled, -1 for an empty row: their exponents in row_top. False
 * where a row is so small that a product with its columns' scales may have lost digits. */
static bool measure_rows(lemke_system *s) {
  double *top = s->tau0;
  for (int i = 0; i < s->rows; ++i) {
    top[i] = -1;
  }
  for (int j = 0; j < s->rows; ++j) {
    const double unit = scaled(1, s->col_exp[j]);
    const int first = s->colptr[j];
    raise_tops(s->val + first, s->rowind + first, s->colptr[j + 1] - first, s->rows, unit, top);
  }
  bool sure = true;
  for (int i = 0; i < s->rows; ++i) {
    sure = sure && (top[i] < 0 || (top[i] >= DBL_MIN && top[i] < HUGE_VAL));
    s->row_top[i] = (top[i] > 0) ? exponent(top[i]) : INT_MIN;
  }
  return sure;
}

/* Do rows, too, have to be scaled? */
static bool rows_differ(lemke_system *s) {
  if (!measure_rows(s)) {
    measure(s);
  }
  return spread(s->row_top, s->rows) > SPREAD;
}

static void scale_rows(lemke_system *s) {
  const int n = s->rows;
  measure(s);
  for (int pass = 0; pass < PASSES; ++pass) {
    shift_down(s->row_exp, s->row_top, n, 2);
    shift_down(s->col_exp, s->col_top, n, 2);
    measure(s);
  }
}

static void equilibrate(lemke_system *s) {
  scale_columns(s);
  const bool both = rows_differ(s);
  if (both) {
    scale_rows(s);
  }
  for (int j = 0; j < s->rows; ++j) {
    const int e = s->col_exp[j];
    const double unit = scaled(1, e);
    const bool plain = !both && e >= -1022 && e <= 1023;
    for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
      s->val[p] = plain ? s->val[p] * unit : scaled(s->val[p], s->row_exp[s->rowind[p]] + e);
    }
  }
}

static void scale_right_side(lemke_system *s, const double *q) {
  int top = INT_MIN;
  for (int i = 0; i < s->rows; ++i) {
    s->q[i] = (i < s->n) ? q[i] : 0;
    if (s->q[i] != 0) {
      const int e = exponent(s->q[i]) + s->row_exp[i];
      top = (e > top) ? e : top;
    }
  }
  top = (top == INT_MIN) ? 0 : top;
  for (int i = 0; i < s->rows; ++i) {
    s->q[i] = scaled(s->q[i], s->row_exp[i] - top);
  }
  s->q_exp = top;
}

/* Transposes the velocity columns; the last entry of each is its diagonal. */
static void list_jacobian(lemke_system *s) {
  memset(s->jptr, 0, sizeof(int) * ((size_t)s->n + 1));
  for (int c = s->n; c < s->rows; ++c) {
    for (int p = s->colptr[c]; p < s->colptr[c + 1] - 1; ++p) {
      s->jptr[s->rowind[p]]++;
    }
  }
  int at = 0;
  for (int i = 0; i <= s->n; ++i) { /* ends first; filling backwards turns them into beginnings */
    at += (i < s->n) ? s->jptr[i] : 0;
    s->jptr[i] = at;
  }
  for (int c = s->rows - 1; c >= s->n; --c) {
    for (int p = s->colptr[c + 1] - 2; p >= s->colptr[c]; --p) {
      const int to = --s->jptr[s->rowind[p]];
      s->jdof[to] = c - s->n;
      s->jval[to] = s->val[p];
    }
  }
}

void lemke_system_build(lemke_system *s, const lcp_problem *p) {
  const lcp_matrix *M = &p->M;
  s->n = M->n;
  s->rows = M->n;
  memset(s->is_free, 0, (size_t)M->n);
  for (int b = 0; b < p->n_block && p->block; ++b) {
    if (p->block[b].set == LCP_FREE) {
      memset(s->is_free + p->block[b].start, 1, (size_t)p->block[b].size);
    }
  }
  if (M->storage == LCP_DENSE) {
    columns_of_dense(s, M);
  } else if (M->storage == LCP_CSC) {
    columns_of_csc(s, &M->csc);
  } else {
    const int n_dof = M->factored->dof_start[M->factored->n_body];
    const int at = impulse_columns(s, M->factored);
    s->rows = M->n + n_dof;
    s->colptr[s->rows] = velocity_columns(s, M->factored, at);
    memset(s->is_free + M->n, 1, (size_t)n_dof);
  }
  equilibrate(s);
  if (M->storage == LCP_FACTORED) {
    list_jacobian(s);
  }
  lcp_matrix_diagonal(M, s->diagonal);
  for (int i = 0; i < s->n; ++i) {
    s->diagonal[i] = scaled(s->diagonal[i], s->row_exp[i] + s->col_exp[i]);
  }
  scale_right_side(s, p->q);
}
