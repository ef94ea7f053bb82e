/* lcp_share_system.c - assembles the active rows of M + delta C as sparse columns, and factors them. */
#include "lcp/share/lcp_share_system.h"

#include "lcp/lcp_column.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void lcp_share_system_close(share_system *s) {
  free(s->mem);
  free(s->nnz_mem);
  free(s->lu_mem);
  *s = (share_system){0};
}

static void layout_rows(share_system *s, base_arena *a) {
  const int n = s->cap_n;
  s->unknown = BASE_ARRAY(a, int, n);
  s->local = BASE_ARRAY(a, int, n);
  s->met = BASE_ARRAY(a, int, n);
  s->stamp = BASE_ARRAY(a, int, n);
  s->sum = BASE_ARRAY(a, double, n);
  s->x = BASE_ARRAY(a, double, n);
  s->colptr = BASE_ARRAY(a, int, n + 1);
}

static void layout_entries(share_system *s, base_arena *a) {
  s->rowind = BASE_ARRAY(a, int, s->cap_nnz);
  s->val = BASE_ARRAY(a, double, s->cap_nnz);
}

static void layout_factor(share_system *s, base_arena *a) {
  lin_lu_layout(&s->lu, s->cap_n, (int)s->cap_nnz, s->cap_fill, a);
}

/* One block of memory for a layout; what stood there before is lost. */
static base_status memory(share_system *s, void **mem, void (*layout)(share_system *, base_arena *),
                          base_error *err) {
  base_arena measure = base_arena_measuring();
  layout(s, &measure);
  free(*mem);
  *mem = measure.overflow ? NULL : base_alloc(measure.used > 0 ? measure.used : 1);
  if (*mem == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a system of %d shared impulses", s->cap_n);
  }
  base_arena a = base_arena_over(*mem, measure.used);
  layout(s, &a);
  return BASE_OK;
}

static base_status grow_rows(share_system *s, int n, base_error *err) {
  if (s->mem != NULL && n <= s->cap_n) {
    return BASE_OK;
  }
  s->cap_n = base_room(n);
  s->cap_fill = 0; /* the factor's arrays go by cap_n too */
  return memory(s, &s->mem, layout_rows, err);
}

/* Room for `need` entries; those already there are kept. */
static base_status grow_entries(share_system *s, size_t need, base_error *err) {
  if (s->nnz_mem != NULL && need <= s->cap_nnz) {
    return BASE_OK;
  }
  if (need > (size_t)INT32_MAX / 2) {
    return BASE_FAIL(err, BASE_ENOMEM, "a system of shared impulses has %zu entries", need);
  }
  void *old = s->nnz_mem;
  const int *row = s->rowind;
  const double *val = s->val;
  const size_t kept = s->cap_nnz;
  s->nnz_mem = NULL;
  s->cap_nnz = base_room_of(need);
  s->cap_fill = 0;
  const base_status done = memory(s, &s->nnz_mem, layout_entries, err);
  if (done == BASE_OK && kept > 0) {
    memcpy(s->rowind, row, kept * sizeof *row);
    memcpy(s->val, val, kept * sizeof *val);
  }
  free(old);
  return done;
}

/* Row `row` of column `column` of the system += v. */
static inline void add(share_system *s, int column, int row, double v, int *count) {
  const int at = s->local[row];
  if (s->stamp[at] != column) {
    s->stamp[at] = column;
    s->met[(*count)++] = at;
    s->sum[at] = 0;
  }
  s->sum[at] += v;
}

/* One entry of M in its column: to its own row, or to those of a slipping part. */
static inline void add_entry(share_system *s, const share_rows *r, int column, int i, double v,
                             int *count) {
  if (r->kind[i] == SHARE_ACTIVE) {
    add(s, column, i, v, count);
  } else if (r->kind[i] == SHARE_SLIP && r->part_dim[i] == 2) {
    const int first = share_first(r, i);
    for (int k = first; k < first + 2; k++) {
      add(s, column, k, r->gain[2 * k + (i - first)] * v, count);
    }
  }
}

static void add_column(share_system *s, const lcp_matrix *M, const share_rows *r, int column,
                       int *count) {
  const int j = s->unknown[column];
  const lcp_column c = lcp_column_of(M, j);
  if (c.row == NULL) { /* dense: the rows of the system only */
    for (int k = 0; k < s->count; k++) {
      const int i = s->unknown[k];
      if (c.val[i] != 0) {
        add_entry(s, r, column, i, c.val[i], count);
      }
    }
  } else {
    for (int k = 0; k < c.count; k++) {
      add_entry(s, r, column, c.row[k], c.val[k], count);
    }
  }
  if (r->kind[j] == SHARE_SLIP) {
    const int first = share_first(r, j);
    for (int k = first; k < first + r->part_dim[j]; k++) {
      add(s, column, k, r->own[2 * k + (j - first)] + r->gain[2 * k + (j - first)] * r->delta[j],
          count);
    }
  } else if (r->delta[j] != 0) {
    add(s, column, j, r->delta[j], count);
  }
  for (int i = j + 1; i < share_slips(r, j); i++) {
    if (r->kind[i] == SHARE_SLIP) {
      add(s, column, i, r->pull[i], count);
    }
  }
}

/* The same where M is dense and nothing slips: the entries stand where they belong, and the diagonal is one of them. */
static int copy_column(share_system *s, lcp_column c, double delta, int column, size_t at) {
  int count = 0;
  for (int k = 0; k < s->count; k++) {
    const double v = c.val[s->unknown[k]];
    s->rowind[at + (size_t)count] = k;
    s->val[at + (size_t)count] = (k == column) ? v + delta : v;
    count += v != 0;
  }
  return count;
}

base_status lcp_share_system_list(share_system *s, int n, const share_rows *r, base_error *err) {
  BASE_TRY(grow_rows(s, n, err));
  s->count = 0;
  s->slips = false;
  for (int i = 0; i < n; i++) {
    s->local[i] = -1;
    s->slips = s->slips || r->kind[i] == SHARE_SLIP;
    if (r->kind[i] != SHARE_FIXED) {
      s->local[i] = s->count;
      s->unknown[s->count++] = i;
    }
  }
  return BASE_OK;
}

static base_status build(share_system *s, const lcp_matrix *M, const share_rows *r,
                         base_error *err) {
  size_t at = 0;
  for (int c = 0; c < s->count; c++) {
    s->stamp[c] = -1;
  }
  for (int c = 0; c < s->count; c++) {
    int count = 0;
    s->colptr[c] = (int)at;
    const int j = s->unknown[c];
    const lcp_column own = lcp_column_of(M, j);
    if (own.row == NULL && !s->slips && own.val[j] != 0) {
      BASE_TRY(grow_entries(s, at + (size_t)s->count, err));
      at += (size_t)copy_column(s, own, r->delta[j], c, at);
      continue;
    }
    add_column(s, M, r, c, &count);
    BASE_TRY(grow_entries(s, at + (size_t)count, err));
    for (int k = 0; k < count; k++) {
      s->rowind[at] = s->met[k];
      s->val[at++] = s->sum[s->met[k]];
    }
  }
  s->colptr[s->count] = (int)at;
  return BASE_OK;
}

base_status lcp_share_system_factor(share_system *s, const lcp_matrix *M, const share_rows *r,
                                    bool *regular, base_error *err) {
  BASE_TRY(lcp_share_system_list(s, M->n, r, err));
  BASE_TRY(build(s, M, r, err));
  const lin_columns A = {s->count, s->colptr, s->rowind, s->val};
  const size_t nnz = (size_t)s->colptr[s->count];
  const size_t full = (size_t)s->count * (size_t)s->count;
  size_t want = 8 * nnz + 64;
  for (;;) {
    want = (want < full) ? want : full + 1;
    if (s->lu_mem == NULL || want > s->cap_fill) {
      const int ordering = (s->lu_mem != NULL) ? s->lu.ordering : LIN_BY_COUNT;
      s->cap_fill = want;
      BASE_TRY(memory(s, &s->lu_mem, layout_factor, err));
      s->lu.ordering = ordering;
    }
    s->factorizations++;
    *regular = s->count == 0 || lin_lu_factor(&s->lu, &A);
    if (*regular || s->lu.deficient > 0 || s->cap_fill > full) {
      return BASE_OK;
    }
    want = 4 * s->cap_fill; /* the factor filled in more than that */
  }
}

int lcp_share_system_small_pivots(const share_system *s, double small) {
  int count = 0;
  for (int k = 0; k < s->count; k++) {
    const double pivot =
        s->lu.dense ? s->lu.value[(size_t)k * (size_t)s->count + (size_t)k] : s->lu.pivot[k];
    count += fabs(pivot) <= small;
  }
  return count;
}

void lcp_share_system_solve(share_system *s, const double *right, double *x) {
  for (int k = 0; k < s->count; k++) {
    s->x[k] = right[s->unknown[k]];
  }
  if (s->count > 0) {
    lin_lu_solve(&s->lu, s->x);
    s->backsolves++;
  }
  for (int k = 0; k < s->count; k++) {
    x[s->unknown[s->lu.col[k]]] = s->x[s->lu.prow[k]];
  }
}
