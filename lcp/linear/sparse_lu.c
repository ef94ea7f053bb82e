#include "lcp/linear/sparse_lu.h"

#include "lcp/base/clones.h"

#include <suitesparse/colamd.h>

#include <cblas.h>
#include <lapacke.h>
#include <math.h>
#include <string.h>

enum {
  DENSE_FROM = 4,   /* rows below which a dense factor costs more than it saves */
  LAPACK_FROM = 64, /* rows below which a call of LAPACK does */
};
static const double colamd_trial = 40; /* operations per entry of A that make it worth a trial */
static const double colamd_gain = 0.7; /* share of them left when it is kept */

void lin_lu_layout(lin_lu *f, int n, int nnz, size_t fill, base_arena *a) {
  const size_t m = (size_t)n;
  *f = (lin_lu){.cap_n = n, .cap_nnz = nnz, .cap_fill = fill};
  f->ufirst = BASE_ARRAY(a, size_t, m + 1);
  f->lfirst = BASE_ARRAY(a, size_t, m);
  f->index = BASE_ARRAY(a, int, fill);
  f->value = BASE_ARRAY(a, double, fill);
  f->pivot = BASE_ARRAY(a, double, m);
  f->prow = BASE_ARRAY(a, int, m);
  f->col = BASE_ARRAY(a, int, m);
  f->step = BASE_ARRAY(a, int, m);
  f->row_count = BASE_ARRAY(a, int, m);
  f->x = BASE_ARRAY(a, double, m);
  f->reach = BASE_ARRAY(a, int, m);
  f->stack = BASE_ARRAY(a, int, m);
  f->mark = BASE_ARRAY(a, int, m);
  f->next = BASE_ARRAY(a, size_t, m);
  f->order_len = colamd_recommended(nnz, n, n) + m + 1; /* its work, then the column pointers */
  f->order_work = BASE_ARRAY(a, int, f->order_len);
}

/* Counting sort: fewest entries first, equal ones in the order given. */
static void order_by_count(lin_lu *f, const lin_columns *A) {
  int *first = f->stack; /* of each count; a column has at most n entries */
  for (int c = 0; c < A->n; ++c) {
    first[c] = 0;
  }
  for (int j = 0; j < A->n; ++j) {
    const int count = A->colptr[j + 1] - A->colptr[j];
    if (count < A->n) { /* those with more come last: their places are the tail */
      first[count]++;
    }
  }
  int sum = 0;
  for (int c = 0; c < A->n; ++c) {
    const int own = first[c];
    first[c] = sum;
    sum += own;
  }
  for (int j = 0; j < A->n; ++j) {
    const int count = A->colptr[j + 1] - A->colptr[j];
    f->col[(count < A->n) ? first[count]++ : sum++] = j;
  }
}

/* Column order into f->col. A matrix COLAMD declines keeps its own order. */
static void order_columns(lin_lu *f, const lin_columns *A) {
  const int n = A->n;
  const size_t len = f->order_len - (size_t)f->cap_n - 1;
  int *ptr = f->order_work + len;
  int stats[COLAMD_STATS];
  for (int j = 0; j < n; ++j) {
    f->col[j] = j;
  }
  if (n <= 3) {
    return;
  }
  if (f->ordering == LIN_BY_COUNT || f->ordering == LIN_KEEP_COUNT ||
      len < colamd_recommended(A->colptr[n], n, n)) {
    order_by_count(f, A);
    return;
  }
  memcpy(ptr, A->colptr, sizeof(int) * ((size_t)n + 1));
  memcpy(f->order_work, A->rowind, sizeof(int) * (size_t)A->colptr[n]);
  if (colamd(n, n, (int)len, f->order_work, ptr, NULL, stats) != 0) {
    memcpy(f->col, ptr, sizeof(int) * (size_t)n);
  }
}

/* Rows reached from `root` through L, appended to reach[top..] in topological order. */
static int search(lin_lu *f, int root, int tag, int top) {
  int depth = 0;
  f->stack[0] = root;
  while (depth >= 0) {
    const int row = f->stack[depth];
    const int k = f->step[row];
    if (f->mark[row] != tag) {
      f->mark[row] = tag;
      f->next[depth] = (k < 0) ? 0 : f->lfirst[k];
    }
    const size_t end = (k < 0) ? 0 : f->ufirst[k + 1];
    size_t p = f->next[depth];
    while (p < end && f->mark[f->index[p]] == tag) {
      ++p;
    }
    if (p < end) {
      f->next[depth] = p + 1;
      f->stack[++depth] = f->index[p];
    } else {
      f->reach[--top] = row;
      --depth;
    }
  }
  return top;
}

/* x <- L \ A(:,j) on the reached rows; returns where they start in `reach`. */
static int eliminate(lin_lu *f, const lin_columns *A, int j, int tag) {
  int top = A->n;
  for (int p = A->colptr[j]; p < A->colptr[j + 1]; ++p) {
    if (f->mark[A->rowind[p]] != tag) {
      top = search(f, A->rowind[p], tag, top);
    }
    f->x[A->rowind[p]] = A->val[p];
  }
  for (int t = top; t < A->n; ++t) {
    const int k = f->step[f->reach[t]];
    const double xk = f->x[f->reach[t]];
    if (k < 0 || xk == 0) {
      continue;
    }
    const size_t end = f->ufirst[k + 1];
    for (size_t p = f->lfirst[k]; p < end; ++p) {
      f->x[f->index[p]] -= f->value[p] * xk;
    }
    f->flops += 2 * (double)(end - f->lfirst[k]);
  }
  return top;
}

/* Row of the pivot among reach[top..n), or -1 when nothing of size is left. */
static int choose_pivot(const lin_lu *f, const lin_columns *A, int j, int top) {
  double largest = 0;
  double whole = 0;
  for (int p = A->colptr[j]; p < A->colptr[j + 1]; ++p) {
    whole = fmax(whole, fabs(A->val[p]));
  }
  for (int t = top; t < A->n; ++t) {
    const int row = f->reach[t];
    if (f->step[row] < 0) {
      largest = fmax(largest, fabs(f->x[row]));
    }
  }
  if (!(largest > LIN_LU_SINGULAR * whole)) {
    return -1;
  }
  int best = -1;
  for (int t = top; t < A->n; ++t) {
    const int row = f->reach[t];
    const double size = fabs(f->x[row]);
    if (f->step[row] >= 0 || size < LIN_LU_THRESHOLD * largest) {
      continue;
    }
    if (best < 0 || f->row_count[row] < f->row_count[best] ||
        (f->row_count[row] == f->row_count[best] && size > fabs(f->x[best]))) {
      best = row;
    }
  }
  return best;
}

/* Moves the finished column into the factors, U first; clears x. False when it does not fit. */
static bool store_column(lin_lu *f, int n, int k, int row, int top) {
  size_t at = f->ufirst[k];
  const bool fits = at + (size_t)(n - top) <= f->cap_fill;
  for (int pass = 0; pass < 2; ++pass) {
    for (int t = top; t < n && fits; ++t) {
      const int i = f->reach[t];
      const bool upper = f->step[i] >= 0;
      if (i == row || upper != (pass == 0) || f->x[i] == 0) {
        continue;
      }
      f->index[at] = i;
      f->value[at++] = upper ? f->x[i] : f->x[i] / f->x[row];
    }
    if (pass == 0) {
      f->lfirst[k] = at;
    }
  }
  f->ufirst[k + 1] = at;
  f->pivot[k] = f->x[row];
  f->prow[k] = row;
  f->step[row] = k;
  for (int t = top; t < n; ++t) {
    f->x[f->reach[t]] = 0;
  }
  return fits;
}

static void begin(lin_lu *f, const lin_columns *A) {
  const int n = A->n;
  order_columns(f, A);
  f->n = n;
  f->flops = 0;
  f->deficient = 0;
  f->ufirst[0] = 0;
  for (int i = 0; i < n; ++i) {
    f->step[i] = -1;
    f->mark[i] = -1;
    f->row_count[i] = 0;
    f->x[i] = 0;
  }
  for (int p = 0; p < A->colptr[n]; ++p) {
    f->row_count[A->rowind[p]]++;
  }
}

/* COLAMD itself costs some tens of operations an entry. */
static void review_ordering(lin_lu *f, const lin_columns *A) {
  const double each = f->flops / (1 + A->colptr[A->n]);
  if (f->ordering == LIN_BY_COUNT && each > colamd_trial) {
    f->ordering = LIN_TRY_COLAMD;
    f->spent = each;
  } else if (f->ordering == LIN_TRY_COLAMD) {
    f->ordering = (each < colamd_gain * f->spent) ? LIN_KEEP_COLAMD : LIN_KEEP_COUNT;
  }
}

/* Largest entry of each column of A into x, its entries into `value`. */
static void unpack(lin_lu *f, const lin_columns *A) {
  const int n = A->n;
  memset(f->value, 0, sizeof(double) * (size_t)n * (size_t)n);
  for (int j = 0; j < n; ++j) {
    double *column = f->value + (size_t)j * (size_t)n;
    double top = 0;
    for (int p = A->colptr[j]; p < A->colptr[j + 1]; ++p) {
      column[A->rowind[p]] = A->val[p];
      const double size = fabs(A->val[p]);
      top = (size > top) ? size : top;
    }
    f->x[j] = top;
  }
}

/* y -= f x. */
static inline void subtract(int n, double f, const double *restrict x, double *restrict y) {
  for (int i = 0; i < n; ++i) {
    y[i] -= f * x[i];
  }
}

/* P A = L U in place with partial pivoting, as dgetrf; swap[k]: row exchanged with row k, for all of them. False: a pivot is
 * zero. */
BASE_CLONES static bool factor_small(int n, double *A, int *swap) {
  bool regular = true;
  for (int k = 0; k < n; ++k) {
    double *own = A + (ptrdiff_t)k * n;
    int p = k;
    for (int i = k + 1; i < n; ++i) {
      p = (fabs(own[i]) > fabs(own[p])) ? i : p;
    }
    swap[k] = p;
    for (int j = 0; j < n && p != k; ++j) {
      const double x = A[p + j * n];
      A[p + j * n] = A[k + j * n];
      A[k + j * n] = x;
    }
    if (!(fabs(own[k]) > 0)) {
      regular = false; /* nothing below it either */
      continue;
    }
    for (int i = k + 1; i < n; ++i) {
      own[i] /= own[k];
    }
    for (int j = k + 1; j < n; ++j) {
      double *other = A + (ptrdiff_t)j * n;
      subtract(n - k - 1, other[k], own + k + 1, other + k + 1);
    }
  }
  return regular;
}

/* b <- U^-1 L^-1 b. */
BASE_CLONES static void solve_small(int n, const double *A, double *b) {
  for (int k = 0; k < n; ++k) {
    subtract(n - k - 1, b[k], A + k + k * n + 1, b + k + 1);
  }
  for (int k = n - 1; k >= 0; --k) {
    b[k] /= A[k + k * n];
    subtract(k, b[k], A + k * n, b);
  }
}

/* True when A was factored as a dense matrix. */
static bool factor_dense(lin_lu *f, const lin_columns *A) {
  const int n = A->n;
  const size_t entries = (size_t)n * (size_t)n;
  f->dense = n >= DENSE_FROM && 2 * (size_t)A->colptr[n] > entries && entries <= f->cap_fill;
  if (!f->dense) {
    return false;
  }
  unpack(f, A);
  bool regular = (n < LAPACK_FROM)
                     ? factor_small(n, f->value, f->stack)
                     : LAPACKE_dgetrf_work(LAPACK_COL_MAJOR, n, n, f->value, n, f->stack) == 0;
  for (int k = 0; k < n; ++k) {
    f->prow[k] = k;
    f->col[k] = k;
    const double pivot = f->value[(size_t)k * (size_t)n + (size_t)k];
    regular = regular && fabs(pivot) > LIN_LU_SINGULAR * f->x[k];
    f->x[k] = 0;
  }
  for (int k = 0; k < n; ++k) { /* the exchanges of rows, one after another */
    const int other = f->stack[k] - ((n < LAPACK_FROM) ? 0 : 1);
    const int row = f->prow[other];
    f->prow[other] = f->prow[k];
    f->prow[k] = row;
  }
  f->n = n;
  f->flops = 2.0 / 3 * (double)n * (double)n * (double)n;
  f->fill = entries;
  f->deficient = 0;
  f->dense = regular;
  return regular;
}

bool lin_lu_factor(lin_lu *f, const lin_columns *A) {
  const int n = A->n;
  if (factor_dense(f, A)) {
    return true;
  }
  begin(f, A);
  int kept = 0;
  for (int t = 0; kept + f->deficient < n; ++t) {
    const int j = f->col[kept];
    const int top = eliminate(f, A, j, t);
    const int row = choose_pivot(f, A, j, top);
    if (row < 0) { /* dependent: park it behind the columns still to come */
      for (int i = top; i < n; ++i) {
        f->x[f->reach[i]] = 0;
      }
      f->deficient++;
      f->col[kept] = f->col[n - f->deficient];
      f->col[n - f->deficient] = j;
      continue;
    }
    if (!store_column(f, n, kept, row, top)) {
      return false;
    }
    ++kept;
  }
  f->fill = f->ufirst[kept];
  review_ordering(f, A);
  return f->deficient == 0;
}

static void solve_dense(const lin_lu *f, double *b) {
  const int n = f->n;
  for (int k = 0; k < n; ++k) {
    f->x[k] = b[f->prow[k]];
  }
  if (n < LAPACK_FROM) {
    solve_small(n, f->value, f->x);
  } else {
    cblas_dtrsv(CblasColMajor, CblasLower, CblasNoTrans, CblasUnit, n, f->value, n, f->x, 1);
    cblas_dtrsv(CblasColMajor, CblasUpper, CblasNoTrans, CblasNonUnit, n, f->value, n, f->x, 1);
  }
  for (int k = 0; k < n; ++k) {
    b[f->prow[k]] = f->x[k];
    f->x[k] = 0;
  }
}

void lin_lu_solve(const lin_lu *f, double *b) {
  const int n = f->n;
  if (f->dense) {
    solve_dense(f, b);
    return;
  }
  for (int k = 0; k < n; ++k) {
    const double xk = b[f->prow[k]];
    if (xk == 0) {
      continue;
    }
    const size_t end = f->ufirst[k + 1];
    for (size_t p = f->lfirst[k]; p < end; ++p) {
      b[f->index[p]] -= f->value[p] * xk;
    }
  }
  for (int k = n - 1; k >= 0; --k) {
    const int row = f->prow[k];
    if (b[row] == 0) {
      continue;
    }
    const double xk = b[row] / f->pivot[k];
    b[row] = xk;
    for (size_t p = f->ufirst[k]; p < f->lfirst[k]; ++p) {
      b[f->index[p]] -= f->value[p] * xk;
    }
  }
}
