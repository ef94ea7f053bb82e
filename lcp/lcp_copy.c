/* lcp_copy.c - diagonals, symmetry, and copies of a matrix in another storage. */
#include "lcp/lcp_problem.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static double csc_entry(const lcp_csc *m, int i, int j) {
  int lo = m->colptr[j], hi = m->colptr[j + 1];
  while (lo < hi) {
    const int mid = lo + (hi - lo) / 2;
    if (m->rowind[mid] < i) {
      lo = mid + 1;
    } else {
      hi = mid;
    }
  }
  return (lo < m->colptr[j + 1] && m->rowind[lo] == i) ? m->val[lo] : 0.0;
}

static int body_dofs(const lcp_factored *f, int b) {
  return f->dof_start[b + 1] - f->dof_start[b];
}

/* The rows of group g on body b, or NULL if it does not touch b. */
static const double *group_side(const lcp_factored *f, int g, int b) {
  const double *A = f->jac + f->jac_start[g];
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

/* sum over shared bodies of row r of group g times W times row s of group h. */
static double factored_entry(const lcp_factored *f, int g, int r, int h, int s) {
  double sum = 0.0;
  for (int side = 0; side < 2; side++) {
    const int b = f->body[2 * g + side];
    if (b < 0 || (side == 1 && b == f->body[2 * g])) {
      continue;
    }
    const double *A = group_side(f, g, b), *B = group_side(f, h, b);
    if (B == NULL) {
      continue;
    }
    const int n = body_dofs(f, b);
    const double *W = f->weight + f->weight_start[b];
    for (int j = 0; j < n; j++) {
      double wj = 0.0;
      for (int i = 0; i < n; i++) {
        wj += A[r * n + i] * W[j * n + i];
      }
      sum += wj * B[s * n + j];
    }
  }
  return sum;
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
  const lcp_factored *f = M->factored;
  for (int g = 0; g < f->n_group; g++) {
    const int first = f->row_start[g];
    for (int r = 0; r < f->row_start[g + 1] - first; r++) {
      const double shift = (f->shift != NULL) ? csc_entry(f->shift, first + r, first + r) : 0.0;
      d[first + r] = factored_entry(f, g, r, g, r) + shift;
    }
  }
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
  for (int j = 0; j < m->n_col; j++) {
    for (int k = m->colptr[j]; k < m->colptr[j + 1]; k++) {
      if (csc_entry(m, j, m->rowind[k]) != m->val[k]) {
        return false;
      }
    }
  }
  return true;
}

/* ---- columns of the factored form ---------------------------------------------------------- */

/* Which groups touch which body: group lists by body. */
typedef struct incidence {
  int *start, *group; /* n_body+1; one entry per side */
} incidence;

static bool incidence_build(const lcp_factored *f, incidence *inc) {
  inc->start = calloc((size_t)f->n_body + 2, sizeof *inc->start);
  inc->group = malloc((2 * (size_t)f->n_group + 1) * sizeof *inc->group);
  if (inc->start == NULL || inc->group == NULL) {
    return false;
  }
  for (int k = 0; k < 2 * f->n_group; k++) {
    if (f->body[k] >= 0) {
      inc->start[f->body[k] + 2]++;
    }
  }
  for (int b = 0; b < f->n_body; b++) {
    inc->start[b + 2] += inc->start[b + 1];
  }
  for (int k = 0; k < 2 * f->n_group; k++) {
    if (f->body[k] >= 0) {
      inc->group[inc->start[f->body[k] + 1]++] = k / 2;
    }
  }
  return true;
}

/* Column-by-column view of any storage: col[n] dense with `row`[count] its possible nonzeros. */
typedef struct columns {
  const lcp_matrix *M;
  incidence inc;
  double *col;
  int *row, *mark;
  int count;
} columns;

static void columns_close(columns *c) {
  free(c->inc.start);
  free(c->inc.group);
  free(c->col);
  free(c->row);
  free(c->mark);
}

static bool columns_open(columns *c, const lcp_matrix *M) {
  *c = (columns){.M = M};
  const size_t n = (size_t)M->n + 1;
  c->col = calloc(n, sizeof *c->col);
  c->row = malloc(n * sizeof *c->row);
  c->mark = malloc(n * sizeof *c->mark);
  for (size_t i = 0; c->mark != NULL && i < n; i++) {
    c->mark[i] = -1;
  }
  return c->col != NULL && c->row != NULL && c->mark != NULL &&
         (M->storage != LCP_FACTORED || incidence_build(M->factored, &c->inc));
}

static void touch(columns *c, int i, int j) {
  if (c->mark[i] != j) {
    c->mark[i] = j;
    c->row[c->count++] = i;
    c->col[i] = 0.0;
  }
}

static void factored_column(columns *c, int g, int s) {
  const lcp_factored *f = c->M->factored;
  const int j = f->row_start[g] + s;
  for (int side = 0; side < 2; side++) {
    const int b = f->body[2 * g + side];
    for (int k = (b >= 0) ? c->inc.start[b] : 0; b >= 0 && k < c->inc.start[b + 1]; k++) {
      const int h = c->inc.group[k];
      if (c->mark[f->row_start[h]] == j) {
        continue; /* met through the other body: both are summed in factored_entry */
      }
      for (int r = 0; r < f->row_start[h + 1] - f->row_start[h]; r++) {
        touch(c, f->row_start[h] + r, j);
        c->col[f->row_start[h] + r] = factored_entry(f, h, r, g, s);
      }
    }
  }
  const lcp_csc *S = f->shift;
  for (int k = (S != NULL) ? S->colptr[j] : 0; S != NULL && k < S->colptr[j + 1]; k++) {
    touch(c, S->rowind[k], j);
    c->col[S->rowind[k]] += S->val[k];
  }
}

static int by_value(const void *a, const void *b) {
  return *(const int *)a - *(const int *)b;
}

/* Fills column j; g is a cursor over groups that only moves forward. */
static void load_column(columns *c, int j, int *g) {
  const lcp_matrix *M = c->M;
  c->count = 0;
  if (M->storage == LCP_DENSE) {
    for (int i = 0; i < M->n; i++) {
      touch(c, i, j);
      c->col[i] = M->val[(size_t)j * (size_t)M->n + (size_t)i];
    }
  } else if (M->storage == LCP_CSC) {
    for (int k = M->csc.colptr[j]; k < M->csc.colptr[j + 1]; k++) {
      touch(c, M->csc.rowind[k], j);
      c->col[M->csc.rowind[k]] = M->csc.val[k];
    }
  } else {
    while (M->factored->row_start[*g + 1] <= j) {
      ++*g;
    }
    factored_column(c, *g, j - M->factored->row_start[*g]);
    qsort(c->row, (size_t)c->count, sizeof *c->row, by_value);
  }
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

base_status lcp_matrix_to_csc(const lcp_matrix *M, lcp_csc *out, base_error *err) {
  *out = (lcp_csc){0};
  columns c;
  int *colptr = calloc((size_t)M->n + 1, sizeof *colptr), *rowind = NULL;
  double *val = NULL;
  bool ok = columns_open(&c, M) && colptr != NULL;
  size_t used = 0, cap = 0;
  for (int j = 0, g = 0; ok && j < M->n; j++) {
    load_column(&c, j, &g);
    if (used + (size_t)c.count > cap) {
      cap = 2 * cap + (size_t)c.count;
      int *more_row = realloc(rowind, cap * sizeof *rowind);
      rowind = (more_row != NULL) ? more_row : rowind;
      double *more_val = realloc(val, cap * sizeof *val);
      val = (more_val != NULL) ? more_val : val;
      ok = more_row != NULL && more_val != NULL && cap <= INT32_MAX;
    }
    for (int k = 0; ok && k < c.count; k++) {
      if (c.col[c.row[k]] != 0.0) {
        rowind[used] = c.row[k];
        val[used++] = c.col[c.row[k]];
      }
    }
    if (ok) {
      colptr[j + 1] = (int)used;
    }
  }
  columns_close(&c);
  *out = (lcp_csc){M->n, M->n, colptr, rowind, val};
  if (!ok) {
    lcp_csc_free(out);
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a sparse copy of a matrix of size %d", M->n);
  }
  return BASE_OK;
}

void lcp_matrix_to_dense(const lcp_matrix *M, double *out) {
  const size_t n = (size_t)M->n;
  if (M->storage == LCP_DENSE) {
    memcpy(out, M->val, n * n * sizeof *out);
    return;
  }
  memset(out, 0, n * n * sizeof *out);
  const lcp_csc *m = (M->storage == LCP_CSC) ? &M->csc : M->factored->shift;
  for (int j = 0; m != NULL && j < m->n_col; j++) {
    for (int k = m->colptr[j]; k < m->colptr[j + 1]; k++) {
      out[(size_t)j * n + (size_t)m->rowind[k]] = m->val[k];
    }
  }
  if (M->storage == LCP_CSC) {
    return;
  }
  const lcp_factored *f = M->factored;
  for (int g = 0; g < f->n_group; g++) {
    for (int h = 0; h < f->n_group; h++) {
      for (int s = f->row_start[g]; s < f->row_start[g + 1]; s++) {
        for (int r = f->row_start[h]; r < f->row_start[h + 1]; r++) {
          out[(size_t)s * n + (size_t)r] +=
              factored_entry(f, h, r - f->row_start[h], g, s - f->row_start[g]);
        }
      }
    }
  }
}
