#include "lcp/lcp_rho_factored.h"

#include "lcp/base/clones.h"
#include "lcp/lcp_column.h"
#include "lcp/lcp_mixture.h"

#include <string.h>

enum { LANES = 8 }; /* entries of a row, and rows, that are made together */

void lcp_rho_factored_layout(lcp_rho_factored *s, const lcp_capacity *cap, base_arena *a) {
  const bool any = cap->n_body > 0;
  const size_t bodies = any ? (size_t)cap->n_body + 1 : 0, sides = any ? 2 * (size_t)cap->n : 0;
  s->wj = BASE_ARRAY(a, double, cap->n_jac);
  s->wj_start = BASE_ARRAY(a, int, bodies);
  s->start = BASE_ARRAY(a, int, bodies);
  s->side = BASE_ARRAY(a, int, sides);
  s->column = BASE_ARRAY(a, int, sides);
  s->by = BASE_ARRAY(a, double, any ? cap->n : 0);
  s->whole = BASE_ARRAY(a, unsigned char, any ? cap->n : 0);
  s->again = BASE_ARRAY(a, unsigned char, any ? cap->n : 0);
}

static int dofs(const lcp_factored *f, int b) {
  return (b < 0) ? 0 : f->dof_start[b + 1] - f->dof_start[b];
}

static int rows_of(const lcp_factored *f, int g) {
  return f->row_start[g + 1] - f->row_start[g];
}

/* Where a side of group g begins in the rows of both: rows x dofs, row-major. */
static ptrdiff_t side_at(const lcp_factored *f, int g, int side) {
  return (side == 1) ? (ptrdiff_t)rows_of(f, g) * dofs(f, f->body[2 * (ptrdiff_t)g]) : 0;
}

/* The body beyond a side's own, -1 for none. */
static int beyond(const lcp_factored *f, int side) {
  return f->body[side ^ 1];
}

/* The sides at every body, those towards one other body together: from a list at every body (`list`, `next`) of the sides that
 * lie there, whose other sides are dealt out body by body. */
static void deal(lcp_rho_factored *s, const lcp_factored *f, int *list, int *next) {
  for (int b = 0; b < f->n_body; b++) {
    list[b] = -1;
    s->start[b] = 0;
  }
  for (int at = 2 * f->n_group - 1; at >= 0; at--) {
    const int b = f->body[at];
    if (b >= 0) {
      s->start[b]++;
      next[at] = list[b];
      list[b] = at;
    }
  }
  for (int b = 0, before = 0; b <= f->n_body; b++) {
    const int here = (b < f->n_body) ? s->start[b] : 0;
    s->start[b] = before;
    before += here;
  }
  for (int at = 0; at < 2 * f->n_group; at++) {
    if (f->body[at] >= 0 && beyond(f, at) < 0) {
      s->side[s->start[f->body[at]]++] = at;
    }
  }
  for (int b = 0; b < f->n_body; b++) {
    for (int at = list[b]; at >= 0; at = next[at]) {
      if (beyond(f, at) >= 0) {
        s->side[s->start[beyond(f, at)]++] = at ^ 1;
      }
    }
  }
  for (int b = f->n_body; b > 0; b--) { /* every start has come to the next one's */
    s->start[b] = s->start[b - 1];
  }
  s->start[0] = 0;
}

/* out = W J' of n velocities: n x rows, `wide` numbers from one to the next. */
static void weigh(const double *J, const double *W, int rows, int n, int wide, double *out) {
  for (int r = 0; r < rows; r++) {
    for (int c = 0; c < n; c++) {
      double sum = 0.0;
      for (int k = 0; k < n; k++) {
        sum += W[(ptrdiff_t)c * n + k] * J[r * n + k];
      }
      out[(ptrdiff_t)c * wide + r] = sum;
    }
  }
}

/* The same of six velocities, side by side. */
BASE_INLINE void weigh_six(const double *J, const double *W, int rows, int wide, double *out) {
  double across[6 * 6];
  for (int e = 0; e < 6 * 6; e++) {
    across[e] = W[e % 6 * 6 + e / 6];
  }
  for (int r = 0; r < rows; r++) {
    double sum[6] = {0};
    for (int k = 0; k < 6; k++) {
      for (int c = 0; c < 6; c++) {
        sum[c] += across[6 * k + c] * J[6 * r + k];
      }
    }
    for (int c = 0; c < 6; c++) {
      out[(ptrdiff_t)c * wide + r] = sum[c];
    }
  }
}

/* Columns at a body: rows of the groups that have a side there. */
static int columns_at(const lcp_rho_factored *s, int b, int n) {
  return (n > 0) ? (s->wj_start[b + 1] - s->wj_start[b]) / n : 0;
}

/* Where the columns of every side begin among those of its body. */
static void number(lcp_rho_factored *s, const lcp_factored *f) {
  s->wj_start[0] = 0;
  for (int b = 0; b < f->n_body; b++) {
    int wide = 0;
    for (int k = s->start[b]; k < s->start[b + 1]; k++) {
      s->column[s->side[k]] = wide;
      wide += rows_of(f, s->side[k] / 2);
    }
    s->wj_start[b + 1] = s->wj_start[b] + dofs(f, b) * wide;
  }
}

BASE_CLONES static void begin(lcp_rho_factored *s, const lcp_factored *f) {
  deal(s, f, s->wj_start, s->column);
  number(s, f);
  for (int g = 0; g < f->n_group; g++) {
    double room[LCP_MIXED_MAX];
    const double *all = lcp_factored_rows(f, g, room);
    for (int side = 0; side < 2; side++) {
      const int at = 2 * g + side, b = f->body[at], n = dofs(f, b);
      if (n > 0) {
        const double *J = all + side_at(f, g, side), *W = f->weight + f->weight_start[b];
        double *out = s->wj + s->wj_start[b] + s->column[at];
        if (n == 6) {
          weigh_six(J, W, rows_of(f, g), columns_at(s, b, n), out);
        } else {
          weigh(J, W, rows_of(f, g), n, columns_at(s, b, n), out);
        }
      }
    }
  }
  s->ready = true;
}

/* The sides over which two groups meet: J of the one and W J' of the other, and how many velocities there are. */
typedef struct meeting {
  int n;
  const double *left[4], *right[4];
  int dof[4], wide[4];
} meeting;

static meeting meet(const lcp_rho_factored *s, const lcp_factored *f, int g, int h, double *room) {
  meeting m = {0};
  const double *rows = lcp_factored_rows(f, g, room);
  for (int a = 0; a < 2; a++) {
    for (int b = 0; b < 2; b++) {
      const int body = f->body[2 * g + a], n = dofs(f, body);
      if (n > 0 && body == f->body[2 * h + b]) {
        m.left[m.n] = rows + side_at(f, g, a);
        m.right[m.n] = s->wj + s->wj_start[body] + s->column[2 * h + b];
        m.wide[m.n] = columns_at(s, body, n);
        m.dof[m.n++] = n;
      }
    }
  }
  return m;
}

/* entry_j += sum over n velocities of x times column j of y, `wide` numbers a row. */
BASE_INLINE void add_dots(const double *x, const double *y, int n, int wide, int count,
                          double *entry) {
  double sum[LANES] = {0};
  for (int k = 0; k < n; k++) {
    for (int j = 0; j < count; j++) {
      sum[j] += x[k] * y[(ptrdiff_t)k * wide + j];
    }
  }
  for (int j = 0; j < count; j++) {
    entry[j] += sum[j];
  }
}

/* (J W J')_ij of row i of one group and `count` rows of the other from `from` on. */
BASE_INLINE void entries(const meeting *m, int i, int from, int count, double *entry) {
  for (int k = 0; k < m->n; k++) {
    const int n = m->dof[k], wide = m->wide[k];
    const double *x = m->left[k] + (ptrdiff_t)i * n, *y = m->right[k] + from;
    if (n == 6) {
      add_dots(x, y, 6, wide, count, entry);
    } else {
      add_dots(x, y, n, wide, count, entry);
    }
  }
}

/* entry += rows i .. end-1 of column j of S, LANES apart. */
static inline void add_shift(const lcp_csc *S, int i, int end, int j, double *entry) {
  const lcp_column c = lcp_csc_column(S, j);
  for (int k = 0; k < c.count && c.row[k] < end; k++) {
    if (c.row[k] >= i) {
      entry[LANES * (c.row[k] - i)] += c.val[k];
    }
  }
}

/* `count` rows of a group from `from` on. */
typedef struct strip {
  int from, count;
} strip;

/* size_i += |M_ij x_j| over some rows j of group h; M_ij has S inside a group. */
BASE_INLINE void add_columns(const lcp_factored *f, const meeting *m, int g, int h, strip some,
                             const double *x, double *size) {
  const int other = f->row_start[h] + some.from, end = f->row_start[g + 1];
  for (int first = f->row_start[g]; first < end; first += LANES) {
    const int rows = (end - first < LANES) ? end - first : LANES;
    double entry[LANES * LANES] = {0};
    for (int i = 0; i < rows; i++) {
      entries(m, first - f->row_start[g] + i, some.from, some.count, entry + (ptrdiff_t)LANES * i);
    }
    for (int j = 0; j < some.count; j++) {
      const double by = x[other + j];
      if (by == 0.0) {
        continue;
      }
      if (g == h && f->shift != NULL) {
        add_shift(f->shift, first, first + rows, other + j, entry + j);
      }
      for (int i = 0; i < rows; i++) {
        size[first + i] += fabs(entry[LANES * i + j] * by);
      }
    }
  }
}

BASE_CLONES static void add_pair(const lcp_rho_factored *s, const lcp_factored *f, int g, int h,
                                 const double *x, double *size) {
  double room[LCP_MIXED_MAX];
  const meeting m = meet(s, f, g, h, room);
  const int wide = rows_of(f, h);
  if (wide == 6) { /* the commonest: a contact over four facets, and over a cone */
    add_columns(f, &m, g, h, (strip){0, 6}, x, size);
  } else if (wide == 3) {
    add_columns(f, &m, g, h, (strip){0, 3}, x, size);
  } else {
    for (int from = 0; from < wide; from += LANES) {
      const int count = (wide - from < LANES) ? wide - from : LANES;
      add_columns(f, &m, g, h, (strip){from, count}, x, size);
    }
  }
}

static bool any_of(const unsigned char *rows, const lcp_factored *f, int g) {
  bool any = rows == NULL;
  for (int i = f->row_start[g]; i < f->row_start[g + 1] && !any; i++) {
    any = rows[i] != 0;
  }
  return any;
}

/* What is to be summed: x, and rows of which groups, those of which over all groups; NULL for all. */
typedef struct task {
  const double *x;
  const unsigned char *some, *whole;
} task;

static bool wants(const task *t, const lcp_factored *f, int side) {
  return any_of(t->some, f, side / 2) && any_of(t->whole, f, side / 2);
}

/* sum_j += |a' Y_j| by_j over `count` columns of Y, which has n rows of `wide`. */
BASE_INLINE void add_lanes(const double *a, const double *Y, int n, int wide, int count,
                           const double *by, double *sum) {
  double entry[LANES] = {0};
  for (int k = 0; k < n; k++) {
    for (int j = 0; j < count; j++) {
      entry[j] += a[k] * Y[(ptrdiff_t)k * wide + j];
    }
  }
  for (int j = 0; j < count; j++) {
    sum[j] += fabs(entry[j]) * by[j];
  }
}

BASE_INLINE double size_over(const double *a, const double *Y, int n, int wide, const double *by) {
  double sum[LANES] = {0};
  int from = 0;
  for (; from + LANES <= wide; from += LANES) {
    add_lanes(a, Y + from, n, wide, LANES, by + from, sum);
  }
  add_lanes(a, Y + from, n, wide, wide - from, by + from, sum);
  return ((sum[0] + sum[4]) + (sum[2] + sum[6])) + ((sum[1] + sum[5]) + (sum[3] + sum[7]));
}

/* size += the terms of the rows of a side over the columns at its body. */
BASE_CLONES static void add_row_terms(const lcp_rho_factored *s, const lcp_factored *f, int at,
                                      double *size) {
  double room[LCP_MIXED_MAX];
  const int g = at / 2, b = f->body[at], n = dofs(f, b), wide = columns_at(s, b, n);
  const double *J = lcp_factored_rows(f, g, room) + side_at(f, g, at % 2);
  const double *Y = s->wj + s->wj_start[b];
  for (int r = 0; r < rows_of(f, g); r++, J += n) {
    size[f->row_start[g] + r] +=
        (n == 6) ? size_over(J, Y, 6, wide, s->by) : size_over(J, Y, n, wide, s->by);
  }
}

/* |x| at the columns of the sides from `from` to `end`; x = NULL: zero, so that they are left out. */
static void weigh_columns(lcp_rho_factored *s, const lcp_factored *f, int from, int end,
                          const double *x) {
  for (int k = from; k < end; k++) {
    const int g = s->side[k] / 2;
    double *by = s->by + s->column[s->side[k]];
    for (int r = 0; r < rows_of(f, g); r++) {
      by[r] = (x != NULL) ? fabs(x[f->row_start[g] + r]) : 0.0;
    }
  }
}

/* The end of the sides from k on that have the same body beyond; one without stands alone. */
static int end_of_run(const lcp_rho_factored *s, const lcp_factored *f, int k, int end) {
  const int other = beyond(f, s->side[k]);
  int to = k + 1;
  while (other >= 0 && to < end && beyond(f, s->side[to]) == other) {
    to++;
  }
  return to;
}

/* The terms between different groups of a run at body b, whose entries are sums over two bodies: taken at the first of them. */
static void add_run(const lcp_rho_factored *s, const lcp_factored *f, int b, int from, int end,
                    const task *t, double *size) {
  const bool first = b < beyond(f, s->side[from]);
  for (int k = from; k < end && first; k++) {
    for (int l = from; l < end && wants(t, f, s->side[k]); l++) {
      if (l != k) {
        add_pair(s, f, s->side[k] / 2, s->side[l] / 2, t->x, size);
      }
    }
  }
}

static bool any_wanted(const lcp_rho_factored *s, const lcp_factored *f, int from, int end,
                       const task *t) {
  bool any = false;
  for (int k = from; k < end && !any; k++) {
    any = wants(t, f, s->side[k]);
  }
  return any;
}

/* size += the terms over body b, but for those of a group with itself. */
static void add_body(lcp_rho_factored *s, const lcp_factored *f, int b, const task *t,
                     double *size) {
  const int from = s->start[b], end = s->start[b + 1];
  if (dofs(f, b) == 0 || !any_wanted(s, f, from, end, t)) {
    return;
  }
  weigh_columns(s, f, from, end, t->x);
  for (int k = from, to; k < end; k = to) {
    to = end_of_run(s, f, k, end);
    if (any_wanted(s, f, k, to, t)) {
      weigh_columns(s, f, k, to, NULL);
      for (int l = k; l < to; l++) {
        if (wants(t, f, s->side[l])) {
          add_row_terms(s, f, s->side[l], size);
        }
      }
      weigh_columns(s, f, k, to, t->x);
      add_run(s, f, b, k, to, t, size);
    }
  }
}

void lcp_rho_factored_product(lcp_rho_factored *s, const lcp_problem *p, const unsigned char *some,
                              const unsigned char *whole, const double *x, double *size) {
  const lcp_factored *f = p->M.factored;
  const task t = {x, some, whole};
  if (!s->ready) {
    begin(s, f);
  }
  for (int g = 0; g < f->n_group; g++) {
    if (any_of(some, f, g)) {
      for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
        size[i] = fabs(p->q[i]);
      }
      add_pair(s, f, g, g, x, size);
    }
  }
  for (int b = 0; b < f->n_body; b++) {
    add_body(s, f, b, &t, size);
  }
}

void lcp_rho_factored_neighbours(const lcp_rho_factored *s, const lcp_factored *f,
                                 unsigned char *rows) {
  enum { ASKED = 1, BESIDE = 2 };
  for (int b = 0; b < f->n_body; b++) {
    bool asked = false;
    for (int k = s->start[b]; k < s->start[b + 1] && !asked; k++) {
      const int g = s->side[k] / 2;
      for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
        asked = asked || (rows[i] & ASKED) != 0;
      }
    }
    for (int k = s->start[b]; k < s->start[b + 1] && asked; k++) {
      const int g = s->side[k] / 2;
      for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
        rows[i] |= BESIDE;
      }
    }
  }
  for (int i = 0; i < f->row_start[f->n_group]; i++) {
    rows[i] = rows[i] != 0;
  }
}
