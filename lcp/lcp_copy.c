/* lcp_copy.c - diagonals, symmetry, and copies of a matrix in another storage. */
#include "lcp/base/crew.h"
#include "lcp/lcp_column.h"
#include "lcp/lcp_mixture.h"
#include "lcp/lcp_wide_column.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* m_ij; zero where it is not stored or m is NULL. */
static double csc_entry(const lcp_csc *m, int i, int j) {
  const lcp_column c = lcp_csc_column(m, j);
  int lo = 0, hi = c.count;
  while (lo < hi) {
    const int mid = lo + (hi - lo) / 2;
    if (c.row[mid] < i) {
      lo = mid + 1;
    } else {
      hi = mid;
    }
  }
  return (lo < c.count && c.row[lo] == i) ? c.val[lo] : 0.0;
}

static int body_dofs(const lcp_factored *f, int b) {
  return f->dof_start[b + 1] - f->dof_start[b];
}

/* Of the rows A of group g those on body b, or NULL if it does not touch b. */
static const double *group_side(const lcp_factored *f, int g, const double *A, int b) {
  if (f->body[2 * g] == b) {
    return A;
  }
  if (f->body[2 * g + 1] != b) {
    return NULL;
  }
  const int rows = f->row_start[g + 1] - f->row_start[g];
  const int first = f->body[2 * g];
  return A + ((first >= 0) ? rows * body_dofs(f, first) : 0);
}

/* sum + a' W b over n velocities, term by term. */
static inline double add_form(const double *a, const double *W, const double *b, int n,
                              double sum) {
  for (int j = 0; j < n; j++) {
    double wj = 0.0;
    for (int i = 0; i < n; i++) {
      wj += a[i] * W[j * n + i];
    }
    sum += wj * b[j];
  }
  return sum;
}

/* A group and its rows. */
typedef struct group_rows {
  int group;
  const double *rows;
  double room[LCP_MIXED_MAX];
} group_rows;

static void read_group(const lcp_factored *f, int g, group_rows *to) {
  to->group = g;
  to->rows = lcp_factored_rows(f, g, to->room);
}

/* sum over shared bodies of row r of group x times W times row s of group y. */
static double factored_entry(const lcp_factored *f, const group_rows *x, int r, const group_rows *y,
                             int s) {
  const int g = x->group;
  double sum = 0.0;
  for (int side = 0; side < 2; side++) {
    const int b = f->body[2 * g + side];
    if (b < 0 || (side == 1 && b == f->body[2 * g])) {
      continue;
    }
    const double *A = group_side(f, g, x->rows, b), *B = group_side(f, y->group, y->rows, b);
    if (B == NULL) {
      continue;
    }
    const int n = body_dofs(f, b);
    const double *W = f->weight + f->weight_start[b];
    sum = (n == 6) ? add_form(A + r * 6, W, B + s * 6, 6, sum)
                   : add_form(A + r * n, W, B + s * n, n, sum);
  }
  return sum;
}

enum { SHARE = 256 }; /* groups of one part of the work */

typedef struct diagonal {
  const lcp_factored *f;
  double *d;
} diagonal;

/* The diagonal of J W J' in the rows of the groups from .. end-1. */
static void group_diagonals(const lcp_factored *f, int from, int end, double *d) {
  for (int g = from; g < end; g++) {
    const int first = f->row_start[g], rows = f->row_start[g + 1] - first;
    const int *body = f->body + 2 * (ptrdiff_t)g;
    double room[LCP_MIXED_MAX];
    const double *A = lcp_factored_rows(f, g, room);
    memset(d + first, 0, (size_t)rows * sizeof *d);
    for (int side = 0; side < 2; side++) {
      const int b = body[side];
      if (b < 0 || (side == 1 && b == body[0])) {
        continue;
      }
      const int n = body_dofs(f, b);
      const double *W = f->weight + f->weight_start[b];
      for (int r = 0; r < rows; r++, A += n) {
        d[first + r] =
            (n == 6) ? add_form(A, W, A, 6, d[first + r]) : add_form(A, W, A, n, d[first + r]);
      }
    }
  }
}

static void share_diagonal(void *of, int part, int hand) {
  const lcp_factored *f = ((const diagonal *)of)->f;
  double *d = ((const diagonal *)of)->d;
  const int from = part * SHARE, end = base_part_end(part, f->n_group, SHARE);
  (void)hand;
  group_diagonals(f, from, end, d);
  for (int i = f->row_start[from]; i < f->row_start[end] && f->shift != NULL; i++) {
    d[i] += csc_entry(f->shift, i, i);
  }
}

void lcp_matrix_diagonal(const lcp_matrix *M, double *d) {
  const size_t n = (size_t)M->n;
  if (M->storage == LCP_DENSE) {
    for (size_t i = 0; i < n; i++) {
      d[i] = M->val[i * n + i];
    }
    return;
  }
  if (M->storage == LCP_CSC) {
    for (int i = 0; i < M->n; i++) {
      d[i] = csc_entry(&M->csc, i, i);
    }
    return;
  }
  diagonal all = {M->factored, d};
  base_share(base_parts(M->factored->n_group, SHARE), share_diagonal, &all);
}

bool lcp_matrix_is_symmetric(const lcp_matrix *M) {
  if (M->storage == LCP_FACTORED && M->factored->shift == NULL) {
    return true;
  }
  if (M->storage == LCP_DENSE) {
    const size_t n = (size_t)M->n;
    for (size_t j = 0; j < n; j++) {
      for (size_t i = 0; i < j; i++) {
        if (M->val[j * n + i] != M->val[i * n + j]) {
          return false;
        }
      }
    }
    return true;
  }
  const lcp_csc *m = (M->storage == LCP_CSC) ? &M->csc : M->factored->shift;
  for (int j = 0; j < M->n; j++) {
    const lcp_column c = lcp_csc_column(m, j);
    for (int k = 0; k < c.count; k++) {
      if (csc_entry(m, j, c.row[k]) != c.val[k]) {
        return false;
      }
    }
  }
  return true;
}

void lcp_csc_free(lcp_csc *m) {
  union {
    const void *view;
    void *owned;
  } p[3] = {{m->colptr}, {m->rowind}, {m->val}};
  for (int i = 0; i < 3; i++) {
    free(p[i].owned);
  }
  *m = (lcp_csc){0};
}

/* A CSC copy as it grows. */
typedef struct copy {
  int *colptr, *rowind;
  double *val;
  size_t used, cap;
} copy;

/* Room for `count` more entries. */
static bool reserve(copy *to, int count) {
  if (to->used + (size_t)count > to->cap) {
    to->cap = 2 * to->cap + (size_t)count;
    int *row = realloc(to->rowind, to->cap * sizeof *row);
    to->rowind = (row != NULL) ? row : to->rowind;
    double *val = realloc(to->val, to->cap * sizeof *val);
    to->val = (val != NULL) ? val : to->val;
    return row != NULL && val != NULL && to->cap <= INT32_MAX;
  }
  return true;
}

static void append(copy *to, int row, double val) {
  if (val != 0.0) {
    to->rowind[to->used] = row;
    to->val[to->used++] = val;
  }
}

static bool copy_stored(const lcp_matrix *M, copy *to) {
  for (int j = 0; j < M->n; j++) {
    const lcp_column c = lcp_column_of(M, j);
    if (!reserve(to, c.count)) {
      return false;
    }
    for (int k = 0; k < c.count; k++) {
      append(to, lcp_column_row(&c, k), c.val[k]);
    }
    to->colptr[j + 1] = (int)to->used;
  }
  return true;
}

/* Entries in double, as lcp_matrix_to_dense computes them. */
static bool copy_factored(const lcp_matrix *M, lcp_wide_columns *columns, copy *to) {
  const lcp_factored *f = M->factored;
  const int *group = columns->group_of;
  group_rows row = {.group = -1}, column = {.group = -1};
  for (int j = 0; j < M->n; j++) {
    const int count = lcp_wide_columns_rows(columns, j);
    const lcp_column shift = lcp_csc_column(f->shift, j);
    int met = 0; /* entries of S above row i */
    if (!reserve(to, count)) {
      return false;
    }
    if (group[j] != column.group) {
      read_group(f, group[j], &column);
    }
    for (int k = 0; k < count; k++) {
      const int i = columns->row[k];
      if (group[i] != row.group) {
        read_group(f, group[i], &row);
      }
      double v =
          factored_entry(f, &row, i - f->row_start[group[i]], &column, j - f->row_start[group[j]]);
      if (met < shift.count && shift.row[met] == i) {
        v += shift.val[met++];
      }
      append(to, i, v);
    }
    to->colptr[j + 1] = (int)to->used;
  }
  return true;
}

base_status lcp_matrix_to_csc(const lcp_matrix *M, lcp_csc *out, base_error *err) {
  copy to = {.colptr = calloc((size_t)M->n + 1, sizeof *to.colptr)};
  lcp_wide_columns columns = {0};
  bool ok = to.colptr != NULL;
  if (M->storage == LCP_FACTORED) {
    ok = ok && lcp_wide_columns_open(&columns, M, NULL) == BASE_OK &&
         copy_factored(M, &columns, &to);
    lcp_wide_columns_close(&columns);
  } else {
    ok = ok && copy_stored(M, &to);
  }
  *out = (lcp_csc){M->n, M->n, to.colptr, to.rowind, to.val};
  if (!ok) {
    lcp_csc_free(out);
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a sparse copy of a matrix of size %d", M->n);
  }
  assert(lcp_csc_is_sorted(out));
  return BASE_OK;
}

void lcp_matrix_to_dense(const lcp_matrix *M, double *out) {
  const size_t n = (size_t)M->n;
  if (M->storage == LCP_DENSE) {
    memcpy(out, M->val, n * n * sizeof *out);
    return;
  }
  memset(out, 0, n * n * sizeof *out);
  for (int j = 0; j < M->n; j++) {
    const lcp_column c = lcp_column_of(M, j);
    for (int k = 0; k < c.count; k++) {
      out[(size_t)j * n + (size_t)c.row[k]] = c.val[k];
    }
  }
  if (M->storage == LCP_CSC) {
    return;
  }
  const lcp_factored *f = M->factored;
  group_rows row, column;
  for (int g = 0; g < f->n_group; g++) {
    read_group(f, g, &column);
    for (int h = 0; h < f->n_group; h++) {
      read_group(f, h, &row);
      for (int s = f->row_start[g]; s < f->row_start[g + 1]; s++) {
        for (int r = f->row_start[h]; r < f->row_start[h + 1]; r++) {
          out[(size_t)s * n + (size_t)r] +=
              factored_entry(f, &row, r - f->row_start[h], &column, s - f->row_start[g]);
        }
      }
    }
  }
}
