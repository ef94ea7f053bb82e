/* The scaled column form of a problem. Scaling by powers of two changes no digit. Columns are always scaled, rows only
 * when they differ by more than 2^20, or when that is asked for, because a row scaling is a choice of covering vector and
 * d = 1 is to mean what it says. */
#include "lcp/solvers/lemke/system.h"

#include "lcp/lcp_mixture.h"
#include "lcp/linear/extended.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double apart = 0x1p20; /* rows whose maxima differ by more are scaled */
enum { REACH = 500 };               /* largest exponent in a view */
enum { PASSES = 64 };
static const double settled =
    0.25; /* a sweep that moves no row by more of a power of two is the last */

void lemke_system_layout(lemke_system *s, lemke_store *m, const lcp_capacity *cap, base_arena *a) {
  const size_t rows = (size_t)cap->n + (size_t)cap->n_dof;
  const size_t nnz = (size_t)cap->nnz + 2 * (size_t)cap->n_jac + (size_t)cap->n_dof;
  *s = (lemke_system){.n = cap->n};
  m->colptr = BASE_ARRAY(a, int, rows + 1);
  m->rowind = BASE_ARRAY(a, int, nnz);
  m->val = BASE_ARRAY(a, double, nnz);
  m->jptr = BASE_ARRAY(a, int, (cap->n_dof > 0) ? cap->n + 1 : 0);
  m->jdof = BASE_ARRAY(a, int, cap->n_jac);
  m->jval = BASE_ARRAY(a, double, cap->n_jac);
  m->q = BASE_ARRAY(a, double, rows);
  m->row_exp = BASE_ARRAY(a, int, rows);
  m->col_exp = BASE_ARRAY(a, int, rows);
  m->sum = BASE_ARRAY(a, double, rows);
  m->diagonal = BASE_ARRAY(a, double, cap->n);
  m->is_free = BASE_ARRAY(a, unsigned char, rows);
  m->row_top = BASE_ARRAY(a, int, rows);
  s->row_top = m->row_top;
  s->w = BASE_ARRAY(a, long double, rows);
  s->row_sum = BASE_ARRAY(a, long double, rows);
  s->tau0 = BASE_ARRAY(a, double, rows);
  s->zref = BASE_ARRAY(a, double, rows);
  m->scratch = s->zref;
  s->force = BASE_ARRAY(a, lcp_farkas_sum, cap->n_dof);
}

double lemke_largest_of_many(const double *x, int n) {
  double top[4] = {0, 0, 0, 0}; /* four chains run side by side */
  int i = 0;
  for (; i + 4 <= n; i += 4) {
    top[0] = lemke_larger(fabs(x[i]), top[0]);
    top[1] = lemke_larger(fabs(x[i + 1]), top[1]);
    top[2] = lemke_larger(fabs(x[i + 2]), top[2]);
    top[3] = lemke_larger(fabs(x[i + 3]), top[3]);
  }
  for (; i < n; ++i) {
    top[0] = lemke_larger(fabs(x[i]), top[0]);
  }
  return lemke_larger(lemke_larger(top[0], top[1]), lemke_larger(top[2], top[3]));
}

/* ---- columns ---------------------------------------------------------------------------------- */

static int push(lemke_store *m, int at, int row, double v) {
  if (v != 0) {
    m->rowind[at] = row;
    m->val[at++] = v;
  }
  return at;
}

static void columns_of_dense(lemke_store *m, const lcp_matrix *M) {
  int at = 0;
  int *restrict rowind = m->rowind;
  double *restrict val = m->val;
  for (int j = 0; j < M->n; ++j) {
    const double *column = M->val + (size_t)j * (size_t)M->n;
    m->colptr[j] = at;
    for (int i = 0; i < M->n; ++i) { /* a zero is overwritten by what follows */
      rowind[at] = i;
      val[at] = column[i];
      at += column[i] != 0;
    }
  }
  m->colptr[M->n] = at;
}

static void columns_of_csc(lemke_store *m, const lcp_csc *M) {
  int at = 0;
  for (int j = 0; j < M->n_col; ++j) {
    m->colptr[j] = at;
    for (int p = M->colptr[j]; p < M->colptr[j + 1]; ++p) {
      at = push(m, at, M->rowind[p], M->val[p]);
    }
  }
  m->colptr[M->n_col] = at;
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
static int body_velocity(lemke_store *m, const lcp_factored *f, int body, const double *jac,
                         int at) {
  const int first = f->dof_start[body];
  const int size = f->dof_start[body + 1] - first;
  const double *W = f->weight + f->weight_start[body];
  double *v = m->scratch; /* rows: at least as long */
  if (size == 6) {
    weigh(W, jac, v, 6);
  } else {
    weigh(W, jac, v, size);
  }
  for (int i = 0; i < size; ++i) {
    at = push(m, at, m->n + first + i, v[i]);
  }
  return at;
}

static int shift_column(lemke_store *m, const lcp_csc *S, int j, int at) {
  for (int p = (S != NULL) ? S->colptr[j] : 0; S != NULL && p < S->colptr[j + 1]; ++p) {
    at = push(m, at, S->rowind[p], S->val[p]);
  }
  return at;
}

/* The impulse columns of  [S J; WJ' -I]: body velocities u = W J' z become free unknowns, so that
 * no product of two contacts is ever formed (Lloyd 2005). */
static int impulse_columns(lemke_store *m, const lcp_factored *f) {
  int at = 0;
  double room[LCP_MIXED_MAX];
  const double *all = (m->n > 0) ? lcp_factored_rows(f, 0, room) : NULL;
  for (int j = 0, g = 0; j < m->n; ++j) {
    for (; j == f->row_start[g + 1]; all = lcp_factored_rows(f, g, room)) {
      ++g;
    }
    const int rows = f->row_start[g + 1] - f->row_start[g];
    const double *jac = all;
    m->colptr[j] = at;
    at = shift_column(m, f->shift, j, at);
    for (int k = 0; k < 2; ++k) {
      const int body = f->body[2 * g + k];
      const int size = (body < 0) ? 0 : f->dof_start[body + 1] - f->dof_start[body];
      at = (body < 0)
               ? at
               : body_velocity(m, f, body, jac + (ptrdiff_t)(j - f->row_start[g]) * size, at);
      jac += (ptrdiff_t)rows * size;
    }
  }
  return at;
}

static void row_entries(lemke_store *m, int row, const double *jac, int size, int *next,
                        bool store) {
  for (int c = 0; c < size; ++c) {
    if (store && jac[c] != 0) {
      m->rowind[next[c]] = row;
      m->val[next[c]] = jac[c];
    }
    next[c] += jac[c] != 0;
  }
}

/* Counts the entries of J in group g by column, or stores them where next says. */
static void group_entries(lemke_store *m, const lcp_factored *f, int g, int *next, bool store) {
  double room[LCP_MIXED_MAX];
  const double *jac = lcp_factored_rows(f, g, room);
  const int rows = f->row_start[g + 1] - f->row_start[g];
  for (int k = 0; k < 2; ++k) {
    const int body = f->body[2 * g + k];
    const int first = (body < 0) ? 0 : f->dof_start[body];
    const int size = (body < 0) ? 0 : f->dof_start[body + 1] - first;
    for (int r = 0; r < rows; ++r, jac += size) {
      row_entries(m, f->row_start[g] + r, jac, size, next + first, store);
    }
  }
}

static int velocity_columns(lemke_store *m, const lcp_factored *f, int at) {
  const int n_dof = f->dof_start[f->n_body];
  int *next = m->row_top; /* counts first, then where the next entry goes */
  memset(next, 0, sizeof(int) * (size_t)n_dof);
  for (int g = 0; g < f->n_group; ++g) {
    group_entries(m, f, g, next, false);
  }
  for (int c = 0; c < n_dof; ++c) { /* one more entry each, the last: the diagonal */
    const int count = next[c];
    m->colptr[m->n + c] = at;
    next[c] = at;
    at += count + 1;
    m->rowind[at - 1] = m->n + c;
    m->val[at - 1] = -1;
  }
  for (int g = 0; g < f->n_group; ++g) {
    group_entries(m, f, g, next, true);
  }
  return at;
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

/* Columns to maximum 1..2, rows as they are. */
static void scale_columns(lemke_store *m) {
  for (int j = 0; j < m->rows; ++j) {
    const double top = lemke_largest(m->val + m->colptr[j], m->colptr[j + 1] - m->colptr[j]);
    m->row_exp[j] = 0;
    m->col_exp[j] = (top > 0) ? -lemke_exponent(top) : 0;
  }
}

/* Are the largest entries of the rows, zero of an empty one, within 2^20 of each other? */
static bool alike(const double *top, int n) {
  double low = HUGE_VAL;
  double high = 0;
  for (int i = 0; i < n; ++i) {
    low = (top[i] > 0 && top[i] < low) ? top[i] : low;
    high = lemke_larger(top[i], high);
  }
  return high == 0 || low * apart >= high;
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

/* Do rows, with the columns scaled, differ so much that they have to be scaled too? */
static bool rows_differ(const lemke_store *m) {
  double *top = m->scratch;
  memset(top, 0, sizeof *top * (size_t)m->rows);
  for (int j = 0; j < m->rows; ++j) {
    const double unit = scaled(1, m->col_exp[j]);
    const int first = m->colptr[j];
    raise_tops(m->val + first, m->rowind + first, m->colptr[j + 1] - first, m->rows, unit, top);
  }
  return !alike(top, m->rows);
}

/* Exponents of the columns from those of the rows, and what the rows then add up to: one sweep. */
static void sweep_means(lemke_store *m) {
  memset(m->sum, 0, sizeof *m->sum * (size_t)m->rows);
  for (int j = 0; j < m->rows; ++j) {
    const int count = m->colptr[j + 1] - m->colptr[j];
    double sum = 0;
    for (int p = m->colptr[j]; p < m->colptr[j + 1]; ++p) {
      sum += lemke_exponent(m->val[p]) + m->scratch[m->rowind[p]];
    }
    const double mean = (count > 0) ? sum / count : 0;
    m->col_exp[j] = (int)lround(-mean);
    for (int p = m->colptr[j]; p < m->colptr[j + 1]; ++p) {
      m->sum[m->rowind[p]] += lemke_exponent(m->val[p]) - mean;
    }
  }
}

/* Rows and columns to geometric mean 1, which makes the squares of the exponents smallest in sum (Curtis & Reid 1972): of
 * all scalings of one matrix it finds the same, up to rounding to powers of two. */
static void scale_both(lemke_store *m) {
  int *count = m->row_top;
  double *mean = m->scratch; /* of the rows, negative */
  memset(count, 0, sizeof *count * (size_t)m->rows);
  for (int p = 0; p < m->colptr[m->rows]; ++p) {
    count[m->rowind[p]]++;
  }
  memset(mean, 0, sizeof *mean * (size_t)m->rows);
  double moved = 1;
  for (int pass = 0; pass < PASSES && moved > settled; ++pass) {
    sweep_means(m);
    moved = 0;
    for (int i = 0; i < m->rows; ++i) {
      const double next = (count[i] > 0) ? -m->sum[i] / count[i] : 0;
      moved = lemke_larger(fabs(next - mean[i]), moved);
      mean[i] = next;
      m->row_exp[i] = (int)lround(next);
    }
  }
}

/* True where rows were scaled too. */
static bool scale(lemke_store *m, bool rows) {
  scale_columns(m);
  rows = rows || rows_differ(m);
  if (rows) {
    scale_both(m);
  }
  for (int j = 0; j < m->rows; ++j) {
    const int e = m->col_exp[j];
    const double unit = scaled(1, e);
    const bool plain = !rows && e >= -1022 && e <= 1023;
    for (int p = m->colptr[j]; p < m->colptr[j + 1]; ++p) {
      m->val[p] = plain ? m->val[p] * unit : scaled(m->val[p], m->row_exp[m->rowind[p]] + e);
    }
  }
  return rows;
}

/* q' and its power. */
static int scale_right_side(lemke_store *m, const double *q) {
  int top = INT_MIN;
  for (int i = 0; i < m->rows; ++i) {
    m->q[i] = (i < m->n) ? q[i] : 0;
    if (m->q[i] != 0) {
      const int e = lemke_exponent(m->q[i]) + m->row_exp[i];
      top = (e > top) ? e : top;
    }
  }
  top = (top == INT_MIN) ? 0 : top;
  for (int i = 0; i < m->rows; ++i) {
    m->q[i] = scaled(m->q[i], m->row_exp[i] - top);
  }
  return top;
}

/* Transposes the velocity columns; the last entry of each is its diagonal. */
static void list_jacobian(lemke_store *m) {
  memset(m->jptr, 0, sizeof(int) * ((size_t)m->n + 1));
  for (int c = m->n; c < m->rows; ++c) {
    for (int p = m->colptr[c]; p < m->colptr[c + 1] - 1; ++p) {
      m->jptr[m->rowind[p]]++;
    }
  }
  int at = 0;
  for (int i = 0; i <= m->n; ++i) { /* ends first; filling backwards turns them into beginnings */
    at += (i < m->n) ? m->jptr[i] : 0;
    m->jptr[i] = at;
  }
  for (int c = m->rows - 1; c >= m->n; --c) {
    for (int p = m->colptr[c + 1] - 2; p >= m->colptr[c]; --p) {
      const int to = --m->jptr[m->rowind[p]];
      m->jdof[to] = c - m->n;
      m->jval[to] = m->val[p];
    }
  }
}

static bool mark_free(lemke_store *m, const lcp_problem *p) {
  bool any = false;
  memset(m->is_free, 0, (size_t)p->M.n);
  for (int b = 0; b < p->n_block && p->block; ++b) {
    if (p->block[b].set == LCP_FREE) {
      memset(m->is_free + p->block[b].start, 1, (size_t)p->block[b].size);
      any = true;
    }
  }
  return any;
}

void lemke_system_build(lemke_system *s, lemke_store *m, const lcp_problem *p, bool rows) {
  const lcp_matrix *M = &p->M;
  m->n = M->n;
  m->rows = M->n;
  s->any_free = mark_free(m, p);
  if (M->storage == LCP_DENSE) {
    columns_of_dense(m, M);
  } else if (M->storage == LCP_CSC) {
    columns_of_csc(m, &M->csc);
  } else {
    const int n_dof = M->factored->dof_start[M->factored->n_body];
    const int at = impulse_columns(m, M->factored);
    m->rows = M->n + n_dof;
    m->colptr[m->rows] = velocity_columns(m, M->factored, at);
    memset(m->is_free + M->n, 1, (size_t)n_dof);
    s->any_free = true;
  }
  s->scaled_rows = scale(m, rows);
  if (M->storage == LCP_FACTORED) {
    list_jacobian(m);
  }
  lcp_matrix_diagonal(M, m->diagonal);
  for (int i = 0; i < m->n; ++i) {
    m->diagonal[i] = scaled(m->diagonal[i], m->row_exp[i] + m->col_exp[i]);
  }
  s->q_exp = scale_right_side(m, p->q);
  s->n = m->n;
  s->rows = m->rows;
  s->view = false;
  s->edition++;
  s->colptr = m->colptr;
  s->rowind = m->rowind;
  s->val = m->val;
  s->q = m->q;
  s->is_free = m->is_free;
  s->row_exp = m->row_exp;
  s->col_exp = m->col_exp;
  s->jptr = m->jptr;
  s->jdof = m->jdof;
  s->jval = m->jval;
  s->diagonal = m->diagonal;
}

/* ---- views ------------------------------------------------------------------------------------ */

/* Notes the power that scales column j to maximum 1..2, and its diagonal. */
static void view_column(lemke_store *m, const lcp_column *c, int j) {
  const double largest = lemke_largest(c->val, c->count);
  double diagonal = (c->row == NULL) ? c->val[j] : 0;
  for (int p = 0; c->row != NULL && p < c->count; ++p) {
    diagonal = (c->row[p] == j) ? c->val[p] : diagonal;
  }
  m->col_exp[j] = (largest > 0) ? -lemke_exponent(largest) : 0;
  m->diagonal[j] = diagonal;
}

/* Has row i an entry, the columns scaled, that stands for its maximum: above 2^-19, where none is above 2? The diagonal
 * mostly; of a sparse matrix no other is looked for. */
static bool view_clear(const lemke_system *s, const lemke_store *m, int i) {
  bool clear = fabs(m->diagonal[i]) * lemke_power(m->col_exp[i]) * apart >= 2;
  for (int j = 0; j < s->n && s->rowind == NULL && !clear; ++j) {
    clear = fabs(s->val[(ptrdiff_t)j * s->n + i]) * lemke_power(m->col_exp[j]) * apart >= 2;
  }
  return clear;
}

/* Are the rows of a view within 2^20 of each other? */
static bool view_alike(const lemke_system *s, lemke_store *m) {
  const int n = s->n;
  bool clear = true;
  for (int i = 0; i < n && clear; ++i) {
    clear = view_clear(s, m, i);
  }
  if (clear) {
    return true;
  }
  double *top = m->scratch;
  memset(top, 0, sizeof *top * (size_t)n);
  for (int j = 0; j < n; ++j) {
    const lcp_column c = lemke_system_column(s, j);
    raise_tops(c.val, c.row, c.count, n, lemke_power(m->col_exp[j]), top);
  }
  return alike(top, n);
}

bool lemke_system_view(lemke_system *s, lemke_store *m, const lcp_problem *p) {
  const lcp_matrix *M = &p->M;
  const bool dense = M->storage == LCP_DENSE;
  const int n = M->n;
  s->n = n;
  s->rows = n;
  s->view = true;
  s->scaled_rows = false;
  s->edition++;
  s->any_free = false;
  s->colptr = dense ? NULL : M->csc.colptr;
  s->rowind = dense ? NULL : M->csc.rowind;
  s->val = dense ? M->val : M->csc.val;
  s->q = p->q;
  s->row_exp = NULL;
  s->col_exp = m->col_exp;
  s->diagonal = m->diagonal;
  int most = 0;
  for (int j = 0; j < n; ++j) {
    const lcp_column c = lemke_system_column(s, j);
    view_column(m, &c, j);
    most = (abs(m->col_exp[j]) > most) ? abs(m->col_exp[j]) : most;
  }
  const double largest = lemke_largest(p->q, n);
  s->q_exp = (largest > 0) ? lemke_exponent(largest) : 0;
  return most <= REACH && abs(s->q_exp) <= REACH && view_alike(s, m);
}

bool lemke_system_over(lemke_system *s, int n, const double *M, const double *q, const int *row_exp,
                       const int *col_exp) {
  int top = -1;
  *s = (lemke_system){.n = n,
                      .rows = n,
                      .edition = s->edition + 1,
                      .view = true,
                      .val = M,
                      .q = q,
                      .row_exp = row_exp,
                      .col_exp = col_exp};
  for (int i = 0; i < n; ++i) {
    const int e = (q[i] != 0) ? lemke_exponent(q[i]) + row_exp[i] : INT_MIN;
    top = (i == 0 || e > top) ? e : top;
  }
  s->q_exp = (top == INT_MIN) ? 0 : top;
  return s->q_exp >= -REACH && s->q_exp <= REACH;
}

void lemke_system_defect(const lemke_system *s, const int *head, const double *x, long double *sum,
                         double *r) {
  const int n = s->rows;
  const double q_unit = s->view ? lemke_power(-s->q_exp) : 1;
  lin_extended e = {.n = n, .sum = sum};
  for (int i = 0; i < n; ++i) {
    sum[i] = (long double)(q_unit * s->q[i]);
  }
  for (int k = 0; k < n; ++k) {
    const int j = head[k] - n;
    if (j >= 0 && j < n && x[k] != 0) {
      const lcp_column c = lemke_system_column(s, j);
      const double unit = s->view ? lemke_power(s->col_exp[j]) : 1;
      lin_extended_add(&e, (long double)(unit * x[k]), c.val, c.row, c.count);
    }
  }
  lin_extended_flush(&e);
  for (int i = 0; i < n && s->view && s->row_exp != NULL; ++i) {
    sum[i] *= (long double)lemke_power(s->row_exp[i]);
  }
  for (int k = 0; k < n; ++k) {
    sum[(head[k] < n) ? head[k] : 0] -= (head[k] < n) ? (long double)x[k] : 0;
  }
  for (int i = 0; i < n; ++i) {
    r[i] = (double)sum[i];
  }
}
