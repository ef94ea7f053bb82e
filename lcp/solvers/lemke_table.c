/* The condensed tableau of a small Lemke path (Dantzig 1963, ch. 8: one column for each nonbasic variable). */
#include "lcp/base/clones.h"
#include "lcp/solvers/lemke.h"

#include <string.h>

void lemke_table_layout(lemke_table *b, int cap, base_arena *a) {
  const size_t n = (size_t)cap;
  *b = (lemke_table){.cap = cap};
  b->a = BASE_ARRAY(a, double, n *(n + 1));
  b->var = BASE_ARRAY(a, int, n + 1);
  b->column = BASE_ARRAY(a, int, 2 * n + 1);
  b->part = BASE_ARRAY(a, double, n);
  b->at = BASE_ARRAY(a, int, n);
}

static double *entries(const lemke_table *b, int c) {
  return b->a + (ptrdiff_t)c * b->cap;
}

void lemke_table_clear(lemke_path *t) {
  t->table.n = 0;
  t->table.covered = false;
  t->table.column[0] = -1; /* z0 */
}

void lemke_table_fill(lemke_path *t, const lemke_system *s) {
  lemke_table *b = &t->table;
  const int n = s->rows;
  b->n = n;
  b->covered = false;
  for (int j = 0; j < n; ++j) {
    double *restrict a = entries(b, j);
    memset(a, 0, sizeof *a * (size_t)n);
    for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
      a[s->rowind[p]] = -s->val[p];
    }
    b->var[j] = n + j;
    b->column[j] = -1;
    b->column[n + j] = j;
    t->basis.head[j] = j;
    t->basis.where[j] = j;
    t->basis.where[n + j] = -1;
    t->x[j] = s->q[j];
  }
  b->column[2 * n] = -1;
  t->basis.where[2 * n] = -1;
}

/* Variables are numbered w_i = i, z_i = n+i, z0 = 2n: one more row moves the z by one. */
static void renumber(lemke_path *t) {
  lemke_table *b = &t->table;
  const int n = b->n;
  for (int c = 0; c < n; ++c) {
    b->var[c] += b->var[c] >= n;
    t->basis.head[c] += t->basis.head[c] >= n;
  }
  memmove(b->column + n + 1, b->column + n, sizeof *b->column * (size_t)n);
  memmove(t->basis.where + n + 1, t->basis.where + n, sizeof *t->basis.where * (size_t)n);
  b->column[2 * n + 2] = -1;
  t->basis.where[2 * n + 2] = -1;
}

/* Lists the basic z_i with a nonzero entry of the new row: positions in at, entries in part. */
static int list_basic(lemke_path *t, const double *row) {
  lemke_table *b = &t->table;
  int count = 0;
  for (int i = 0; i < b->n; ++i) {
    const int at = t->basis.where[b->n + 1 + i];
    if (row[i] != 0 && at >= 0) {
      b->at[count] = at;
      b->part[count++] = row[i];
    }
  }
  return count;
}

static double dot(const lemke_table *b, int count, const double *x) {
  double sum[2] = {0, 0}; /* two chains run side by side */
  int k = 0;
  for (; k + 1 < count; k += 2) {
    sum[0] += b->part[k] * x[b->at[k]];
    sum[1] += b->part[k + 1] * x[b->at[k + 1]];
  }
  return sum[0] + sum[1] + ((k < count) ? b->part[k] * x[b->at[k]] : 0);
}

/* B^-1 (-M_n) in the rows there were. */
static void new_column(lemke_path *t, const double *column, double *y) {
  const lemke_table *b = &t->table;
  const int n = b->n;
  memset(y, 0, sizeof *y * (size_t)n);
  for (int i = 0; i < n; ++i) {
    const int at = t->basis.where[i];
    if (column[i] == 0) {
      continue;
    }
    if (at >= 0) {
      y[at] -= column[i];
      continue;
    }
    const double *unit = entries(b, b->column[i]);
    for (int r = 0; r < n; ++r) {
      y[r] -= column[i] * unit[r];
    }
  }
}

void lemke_table_append(lemke_path *t, const double *column, const double *row, double q) {
  lemke_table *b = &t->table;
  const int n = b->n;
  renumber(t);
  const int count = list_basic(t, row);
  for (int c = 0; c < n; ++c) { /* the row of w_n: 0 = w_n - sum M_ni z_i */
    const int var = b->var[c];
    double *a = entries(b, c);
    a[n] = dot(b, count, a) - ((var > n) ? row[var - n - 1] : 0);
  }
  double *y = entries(b, n);
  new_column(t, column, y);
  y[n] = dot(b, count, y) - column[n];
  t->x[n] = q + dot(b, count, t->x);
  b->var[n] = 2 * n + 1;
  b->column[2 * n + 1] = n;
  b->column[n] = -1;
  t->basis.head[n] = n;
  t->basis.where[n] = n;
  t->basis.where[2 * n + 1] = -1;
  b->n = n + 1;
}

void lemke_table_cover(lemke_path *t, const double *d) {
  lemke_table *b = &t->table;
  memcpy(entries(b, b->n), d, sizeof *d * (size_t)b->n);
  b->var[b->n] = 2 * b->n;
  b->column[2 * b->n] = b->n;
  b->covered = true;
}

void lemke_table_uncover(lemke_path *t) {
  lemke_table *b = &t->table;
  const int n = b->n;
  const int free_column = b->column[2 * n];
  if (free_column < n) {
    memcpy(entries(b, free_column), entries(b, n), sizeof *b->a * (size_t)n);
    b->var[free_column] = b->var[n];
    b->column[b->var[n]] = free_column;
  }
  b->column[2 * n] = -1;
  b->covered = false;
}

/* Rows p of all columns but `skip` become a_p / d_p, the others a_i - d_i a_p / d_p. */
BASE_CLONES static void eliminate(double *restrict a, int cap, int columns, int n, int skip, int p,
                                  const double *restrict d) {
  for (int c = 0; c < columns; ++c, a += cap) {
    if (c == skip || a[p] == 0) {
      continue;
    }
    const double share = a[p] / d[p];
    for (int i = 0; i < n; ++i) {
      a[i] -= d[i] * share;
    }
    a[p] = share;
  }
}

void lemke_table_replace(lemke_path *t, int p, int entering, const double *d) {
  lemke_table *b = &t->table;
  const int n = b->n;
  const int c = b->column[entering];
  const int left = t->basis.head[p];
  double *own = entries(b, c);
  eliminate(b->a, b->cap, n + b->covered, n, c, p, d);
  for (int i = 0; i < n; ++i) {
    own[i] = -d[i] / d[p];
  }
  own[p] = 1 / d[p];
  b->var[c] = left;
  b->column[left] = c;
  b->column[entering] = -1;
  t->basis.where[left] = -1;
  t->basis.head[p] = entering;
  t->basis.where[entering] = p;
}
