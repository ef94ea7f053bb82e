#include "lcp/linear/basis.h"

#include "lcp/base/clones.h"
#include "lcp/linear/extended.h"

#include <assert.h>
#include <math.h>
#include <string.h>

void lin_basis_layout(lin_basis *b, int n, int nnz, base_arena *a) {
  const size_t m = (size_t)n;
  const size_t entries = (size_t)nnz + m; /* z0 adds one column */
  const size_t dense = m * (m + 1);
  const size_t sparse = 32 * entries + 256 * m;
  *b = (lin_basis){.cap_n = n, .cap_nnz = nnz};
  b->head = BASE_ARRAY(a, int, m);
  b->where = BASE_ARRAY(a, int, 2 * m + 1);
  b->kernel_var = BASE_ARRAY(a, int, m);
  b->kernel_row = BASE_ARRAY(a, int, m);
  b->local = BASE_ARRAY(a, int, m);
  b->kcolptr = BASE_ARRAY(a, int, m + 1);
  b->krowind = BASE_ARRAY(a, int, entries);
  b->kval = BASE_ARRAY(a, double, entries);
  b->work = BASE_ARRAY(a, double, m);
  b->active = BASE_ARRAY(a, double, m);
  lin_lu_layout(&b->lu, n, nnz + n, (dense < sparse) ? dense : sparse, a);
  b->cap_eta = m * LIN_ETA_MAX + 1; /* one entry may be written ahead */
  b->eta_first = BASE_ARRAY(a, size_t, LIN_ETA_MAX + 1);
  b->eta_pos = BASE_ARRAY(a, int, LIN_ETA_MAX);
  b->eta_pivot = BASE_ARRAY(a, double, LIN_ETA_MAX);
  b->eta_index = BASE_ARRAY(a, int, b->cap_eta);
  b->eta_value = BASE_ARRAY(a, double, b->cap_eta);
}

#ifndef NDEBUG
/* Every row position has a variable of its own, and head and where name each other. */
static bool consistent(const lin_basis *b) {
  const int n = b->sys->n;
  int basic = 0;
  bool good = true;
  for (int v = 0; v <= 2 * n; ++v) {
    basic += b->where[v] >= 0;
  }
  for (int i = 0; i < n; ++i) {
    const int v = b->head[i];
    good = good && v >= 0 && v <= 2 * n && b->where[v] == i;
  }
  return good && basic == n;
}
#endif

void lin_basis_start(lin_basis *b, const lin_system *sys, const unsigned char *in_z) {
  const int n = sys->n;
  b->sys = sys;
  b->fresh = false;
  b->n_eta = 0;
  b->eta_flops = 0;
  for (int v = 0; v <= 2 * n; ++v) {
    b->where[v] = -1;
  }
  for (int i = 0; i < n; ++i) {
    b->head[i] = in_z[i] ? n + i : i;
    b->where[b->head[i]] = i;
  }
  assert(consistent(b));
}

/* Appends the kernel part of one column; w rows are left out. */
static int gather(lin_basis *b, int var, int at) {
  const lin_system *s = b->sys;
  if (var == 2 * s->n) {
    for (int i = 0; i < s->n; ++i) {
      if (b->local[i] >= 0 && s->cover[i] != 0) {
        b->krowind[at] = b->local[i];
        b->kval[at++] = -s->cover[i];
      }
    }
    return at;
  }
  const int j = var - s->n;
  for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
    if (b->local[s->rowind[p]] >= 0 && s->val[p] != 0) {
      b->krowind[at] = b->local[s->rowind[p]];
      b->kval[at++] = -s->val[p];
    }
  }
  return at;
}

static void gather_kernel(lin_basis *b) {
  const int n = b->sys->n;
  int rows = 0;
  int k = 0;
  for (int i = 0; i < n; ++i) {
    b->local[i] = -1;
    if (b->where[i] < 0) { /* w_i nonbasic: its row belongs to the kernel */
      b->local[i] = rows;
      b->kernel_row[rows++] = i;
    }
  }
  int at = 0;
  for (int v = n; v <= 2 * n; ++v) {
    if (b->where[v] >= 0) {
      b->kernel_var[k] = v;
      b->kcolptr[k++] = at;
      at = gather(b, v, at);
    }
  }
  b->kcolptr[k] = at;
  b->kernel_size = k;
}

bool lin_basis_factor(lin_basis *b) {
  const int n = b->sys->n;
  gather_kernel(b);
  const lin_columns kernel = {b->kernel_size, b->kcolptr, b->krowind, b->kval};
  b->factorizations++;
  b->n_eta = 0;
  b->eta_flops = 0;
  b->eta_first[0] = 0;
  const bool ok = lin_lu_factor(&b->lu, &kernel);
  b->full = !ok && b->lu.deficient == 0;
  b->fresh = ok;
  if (!ok) {
    return false;
  }
  for (int i = 0; i < n; ++i) {
    if (b->local[i] < 0) {
      b->head[i] = i;
      b->where[i] = i;
    }
  }
  for (int k = 0; k < b->kernel_size; ++k) {
    const int row = b->kernel_row[b->lu.prow[k]];
    const int var = b->kernel_var[b->lu.col[k]];
    b->head[row] = var;
    b->where[var] = row;
  }
  assert(consistent(b));
  return true;
}

/* y <- y - t x */
static void subtract(int n, double t, const double *restrict x, double *restrict y) {
  for (int i = 0; i < n; ++i) {
    y[i] -= t * x[i];
  }
}

/* x <- x - sum of four columns, in one sweep. */
BASE_CLONES static void subtract_four(int n, const double *t, const double *const *column,
                                      double *restrict x) {
  const double *restrict a = column[0];
  const double *restrict b = column[1];
  const double *restrict c = column[2];
  const double *restrict d = column[3];
  for (int i = 0; i < n; ++i) {
    x[i] = (((x[i] - t[0] * a[i]) - t[1] * b[i]) - t[2] * c[i]) - t[3] * d[i];
  }
}

/* x += t * column(var). */
static void add_column(const lin_system *s, int var, double t, double *x) {
  if (var < s->n) {
    x[var] += t;
  } else if (var == 2 * s->n) {
    for (int i = 0; i < s->n; ++i) {
      x[i] -= t * s->cover[i];
    }
  } else {
    const int j = var - s->n;
    const int first = s->colptr[j];
    const int count = s->colptr[j + 1] - first;
    const double *val = s->val + first;
    const int *row = s->rowind + first;
    if (count == s->n) { /* a full column needs no index */
      subtract(count, t, val, x);
    } else {
      for (int p = 0; p < count; ++p) {
        x[row[p]] -= t * val[p];
      }
    }
  }
}

/* Columns to be added to x, the full ones of M four at a time. */
typedef struct waiting {
  int count;
  double t[4];
  const double *column[4];
} waiting;

static void add_later(waiting *w, const lin_system *s, int var, double t, double *x) {
  const int j = var - s->n;
  if (j < 0 || j == s->n || s->colptr[j + 1] - s->colptr[j] != s->n) {
    add_column(s, var, t, x);
    return;
  }
  w->t[w->count] = t;
  w->column[w->count++] = s->val + s->colptr[j];
  if (w->count == 4) {
    subtract_four(s->n, w->t, w->column, x);
    w->count = 0;
  }
}

static void add_waiting(waiting *w, int n, double *x) {
  for (int k = 0; k < w->count; ++k) {
    subtract(n, w->t[k], w->column[k], x);
  }
  w->count = 0;
}

void lin_basis_column(const lin_basis *b, int var, double *x) {
  memset(x, 0, sizeof(double) * (size_t)b->sys->n);
  add_column(b->sys, var, 1, x);
}

void lin_basis_solve(lin_basis *b, double *x) {
  b->backsolves++;
  for (int k = 0; k < b->kernel_size; ++k) {
    b->work[k] = x[b->kernel_row[k]];
  }
  lin_lu_solve(&b->lu, b->work);
  waiting w = {0};
  for (int k = 0; k < b->kernel_size; ++k) { /* rows outside the kernel: x_w = r - B_wk x_k */
    b->active[k] = b->work[b->lu.prow[k]];
    if (b->active[k] != 0) {
      add_later(&w, b->sys, b->kernel_var[b->lu.col[k]], -b->active[k], x);
    }
  }
  add_waiting(&w, b->sys->n, x);
  for (int k = 0; k < b->kernel_size; ++k) {
    x[b->kernel_row[b->lu.prow[k]]] = b->active[k];
  }
  for (int e = 0; e < b->n_eta; ++e) {
    const int pos = b->eta_pos[e];
    if (x[pos] == 0) {
      continue;
    }
    const double t = x[pos] / b->eta_pivot[e];
    if (b->eta_first[e + 1] - b->eta_first[e] == (size_t)b->sys->n) {
      subtract(b->sys->n, t, b->eta_value + b->eta_first[e], x);
      x[pos] = t;
      continue;
    }
    for (size_t p = b->eta_first[e]; p < b->eta_first[e + 1]; ++p) {
      x[b->eta_index[p]] -= b->eta_value[p] * t;
    }
    x[pos] = t;
  }
}

void lin_basis_residual(const lin_basis *b, const double *y, const double *r, long double *sum) {
  const lin_system *s = b->sys;
  const int n = s->n;
  lin_extended e = {.n = n, .sum = sum};
  for (int i = 0; i < n; ++i) {
    sum[i] = (long double)r[i];
  }
  for (int k = 0; k < n; ++k) {
    const int var = b->head[k];
    const long double t = (long double)y[k];
    if (t == 0) {
      continue;
    }
    if (var < n) {
      sum[var] -= t;
    } else if (var == 2 * n) {
      lin_extended_add(&e, t, s->cover, NULL, n);
    } else {
      const int first = s->colptr[var - n];
      lin_extended_add(&e, t, s->val + first, s->rowind + first, s->colptr[var - n + 1] - first);
    }
  }
  lin_extended_flush(&e);
}

void lin_basis_replace(lin_basis *b, int p, int var, const double *d) {
  const int n = b->sys->n;
  const int e = b->n_eta++;
  b->fresh = false;
  size_t at = b->eta_first[e];
  for (int i = 0; i < n; ++i) {
    b->eta_index[at] = i;
    b->eta_value[at] = d[i];
    at += d[i] != 0 && i != p;
  }
  if (at - b->eta_first[e] > (size_t)(n / 3)) { /* full enough to be kept without an index */
    at = b->eta_first[e] + (size_t)n;
    memcpy(b->eta_value + b->eta_first[e], d, sizeof(double) * (size_t)n);
  }
  b->eta_first[e + 1] = at;
  b->eta_pos[e] = p;
  b->eta_pivot[e] = d[p];
  b->eta_flops += 2 * (double)at;
  assert(b->where[var] < 0);
  b->where[b->head[p]] = -1;
  b->head[p] = var;
  b->where[var] = p;
  assert(consistent(b));
}

/* Product-form columns are streamed, a factorisation jumps about: the weights are measured times of
 * an operation of each kind in units of a streamed one. */
bool lin_basis_due(const lin_basis *b) {
  const double each = b->lu.dense ? 1 : 4;
  const double factor = each * b->lu.flops + 16 * (double)b->kcolptr[b->kernel_size];
  return b->n_eta == LIN_ETA_MAX || b->eta_flops > factor + 50 * (double)b->sys->n;
}
