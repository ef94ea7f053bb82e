#include "lcp/linear/tableau.h"

#include "lcp/base/clones.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { LANES = 4 };

static int padded(int n) {
  return (n + LANES - 1) / LANES * LANES;
}

void lin_tableau_layout(lin_tableau *b, int cap, base_arena *a) {
  const size_t n = (size_t)cap;
  *b = (lin_tableau){.cap = cap};
  b->block = BASE_ARRAY(a, double, (size_t)padded(cap) * (n + 3));
  b->var = BASE_ARRAY(a, int, n + 1);
  b->column = BASE_ARRAY(a, int, 2 * n + 1);
  b->head = BASE_ARRAY(a, int, n);
  b->where = BASE_ARRAY(a, int, 2 * n + 1);
  b->entry = BASE_ARRAY(a, double, n);
  b->at = BASE_ARRAY(a, int, n);
  b->rhs = BASE_ARRAY(a, double, n);
}

#ifndef NDEBUG
/* Every variable is either in a position or in a column, and the lists name each other. */
static bool consistent(const lin_tableau *b) {
  const int n = b->n;
  bool good = true;
  for (int i = 0; i < n; ++i) {
    const int v = b->head[i];
    good = good && v >= 0 && v <= 2 * n && b->where[v] == i && b->column[v] < 0;
  }
  for (int c = 0; c < n + b->covered; ++c) {
    const int v = b->var[c];
    good = good && v >= 0 && v <= 2 * n && b->column[v] == c && b->where[v] < 0;
  }
  for (int c = -1 - b->generic; c < n + b->covered; ++c) {
    for (int i = n; i < b->stride && i < padded(n); ++i) {
      good = good && lin_tableau_entries(b, c)[i] == 0;
    }
  }
  return good && (b->covered || (b->where[2 * n] < 0 && b->column[2 * n] < 0));
}
#endif

/* Clears what stands beyond row n of column c: most often less than LANES entries, for which memset is not worth a call. */
static void clear_tail(const lin_tableau *b, int c) {
  double *tail = lin_tableau_entries(b, c) + b->n;
  const int count = b->stride - b->n;
  if (count >= LANES) {
    memset(tail, 0, sizeof *tail * (size_t)count);
    return;
  }
  for (int k = 0; k < LANES - 1; ++k) {
    if (k < count) {
      tail[k] = 0;
    }
  }
}

void lin_tableau_start(lin_tableau *b, int n) {
  assert(n <= b->cap);
  b->n = n;
  b->stride = padded((n > 0) ? n : b->cap);
  b->delta = b->block;
  b->x = b->delta + b->stride;
  b->a = b->x + b->stride;
  b->covered = false;
  b->generic = false;
  b->least_pivot = HUGE_VAL;
  b->due = -1;
  clear_tail(b, -2);
  clear_tail(b, -1);
  for (int j = 0; j < n; ++j) {
    clear_tail(b, j);
    b->var[j] = n + j;
    b->column[j] = -1;
    b->column[n + j] = j;
    b->head[j] = j;
    b->where[j] = j;
    b->where[n + j] = -1;
  }
  b->column[2 * n] = -1;
  b->where[2 * n] = -1;
}

static void uncover(lin_tableau *b) {
  const int n = b->n;
  const int c = b->column[2 * n];
  assert(c >= 0);
  if (c < n) {
    memcpy(lin_tableau_entries(b, c), lin_tableau_entries(b, n), sizeof *b->a * (size_t)b->stride);
    b->var[c] = b->var[n];
    b->column[b->var[n]] = c;
  }
  b->column[2 * n] = -1;
  b->covered = false;
}

/* One more row moves the numbers of all z by one. */
static void renumber(lin_tableau *b) {
  const int n = b->n;
  for (int c = 0; c < n; ++c) {
    b->var[c] += b->var[c] >= n;
    b->head[c] += b->head[c] >= n;
  }
  memmove(b->column + n + 1, b->column + n, sizeof *b->column * (size_t)n);
  memmove(b->where + n + 1, b->where + n, sizeof *b->where * (size_t)n);
  b->column[2 * n + 2] = -1;
  b->where[2 * n + 2] = -1;
}

/* Lists the basic z_i with a nonzero entry of the new row: positions in at, entries in entry. */
static int list_basic(lin_tableau *b, const double *row) {
  int count = 0;
  for (int i = 0; i < b->n; ++i) {
    const int at = b->where[b->n + 1 + i];
    if (row[i] != 0 && at >= 0) {
      b->at[count] = at;
      b->entry[count++] = row[i];
    }
  }
  return count;
}

static double dot(const lin_tableau *b, int count, const double *x) {
  double sum[2] = {0, 0}; /* two chains run side by side */
  int k = 0;
  for (; k + 1 < count; k += 2) {
    sum[0] += b->entry[k] * x[b->at[k]];
    sum[1] += b->entry[k + 1] * x[b->at[k + 1]];
  }
  return sum[0] + sum[1] + ((k < count) ? b->entry[k] * x[b->at[k]] : 0);
}

/* x <- x + B^-1 r over the first n rows. */
static void add_solution(const lin_tableau *b, int n, const double *r, double *x) {
  for (int i = 0; i < n; ++i) {
    const int at = b->where[i];
    if (r[i] == 0) {
      continue;
    }
    if (at >= 0) { /* a unit vector */
      x[at] += r[i];
      continue;
    }
    const double *unit = lin_tableau_column(b, i);
    for (int p = 0; p < n; ++p) {
      x[p] += r[i] * unit[p];
    }
  }
}

void lin_tableau_correct(const lin_tableau *b, const double *r) {
  add_solution(b, b->n, r, b->x);
}

void lin_tableau_append(lin_tableau *b, const double *column, const double *row, double q) {
  if (b->covered) {
    uncover(b);
  }
  const int n = b->n;
  b->generic = false;
  assert(n < b->cap && b->stride >= b->cap);
  renumber(b);
  const int count = list_basic(b, row);
  for (int c = 0; c < n; ++c) { /* the row of w_n: 0 = w_n - sum M_ni z_i */
    const int var = b->var[c];
    double *a = lin_tableau_entries(b, c);
    a[n] = dot(b, count, a) - ((var > n) ? row[var - n - 1] : 0);
  }
  double *y = lin_tableau_entries(b, n);
  memset(y, 0, sizeof *y * (size_t)b->stride);
  for (int i = 0; i < n; ++i) {
    b->rhs[i] = -column[i];
  }
  add_solution(b, n, b->rhs, y);
  y[n] = dot(b, count, y) - column[n];
  b->var[n] = 2 * n + 1;
  b->column[2 * n + 1] = n;
  b->column[n] = -1;
  b->head[n] = n;
  b->where[n] = n;
  b->where[2 * n + 1] = -1;
  b->n = n + 1;
  b->x[n] = q + dot(b, count, b->x);
  assert(consistent(b));
}

void lin_tableau_cover(lin_tableau *b, const double *d) {
  if (b->covered) {
    uncover(b);
  }
  const int n = b->n;
  assert(b->where[2 * n] < 0);
  memcpy(lin_tableau_entries(b, n), d, sizeof *d * (size_t)n);
  clear_tail(b, n);
  b->var[n] = 2 * n;
  b->column[2 * n] = n;
  b->covered = true;
}

/* Entry p of `columns` columns from a on, but for `skip`, becomes a_p / d_p, the others a_i - d_i a_p / d_p. Column `skip`, if it
 * is one of them, is d and becomes -d_i / d_p, and 1 / d_p. */
BASE_CLONES static void eliminate(double *restrict a, int stride, int columns, int n, int skip,
                                  int p, double *restrict d) {
  const double pivot = d[p];
  for (int c = 0; c < columns; ++c, a += stride) {
    if (c == skip || a[p] == 0) {
      continue;
    }
    const double share = a[p] / pivot;
    for (int i = 0; i < n; i += LANES) {
      for (int k = 0; k < LANES; ++k) {
        a[i + k] -= d[i + k] * share;
      }
    }
    a[p] = share;
  }
  for (int i = 0; i < n && skip < columns; i += LANES) {
    for (int k = 0; k < LANES; ++k) {
      d[i + k] = -d[i + k] / pivot;
    }
  }
  d[p] = (skip < columns) ? 1 / pivot : pivot;
}

/* Column of `entering`, which takes position p. */
static int exchange(lin_tableau *b, int p, int entering) {
  const int c = b->column[entering];
  const int left = b->head[p];
  const double size = fabs(lin_tableau_entries(b, c)[p]);
  b->least_pivot = (size < b->least_pivot) ? size : b->least_pivot;
  b->var[c] = left;
  b->column[left] = c;
  b->column[entering] = -1;
  b->where[left] = -1;
  b->head[p] = entering;
  b->where[entering] = p;
  return c;
}

void lin_tableau_replace(lin_tableau *b, int p, int entering) {
  assert(b->due < 0);
  const int c = exchange(b, p, entering);
  const int values = 1 + b->generic;
  eliminate(b->a - (ptrdiff_t)values * b->stride, b->stride, values + b->n + b->covered,
            padded(b->n), values + c, p, lin_tableau_entries(b, c));
  assert(consistent(b));
}

void lin_tableau_replace_last(lin_tableau *b, int p, int entering) {
  assert(b->due < 0);
  const int c = exchange(b, p, entering);
  const int values = 1 + b->generic;
  eliminate(b->a - (ptrdiff_t)values * b->stride, b->stride, values, padded(b->n), values, p,
            lin_tableau_entries(b, c));
  b->due = p;
  b->due_column = c;
  assert(consistent(b));
}

void lin_tableau_finish(lin_tableau *b) {
  if (b->due >= 0) {
    const int p = b->due;
    const int c = b->due_column;
    b->due = -1;
    eliminate(b->a, b->stride, b->n + b->covered, padded(b->n), c, p, lin_tableau_entries(b, c));
  }
}
