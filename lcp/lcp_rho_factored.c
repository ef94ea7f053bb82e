#include "lcp/lcp_rho_factored.h"

#include "lcp/base/clones.h"
#include "lcp/lcp_column.h"
#include "lcp/lcp_mixture.h"

enum { LANES = 8 }; /* entries of a row, and rows, that are made together */

void lcp_rho_factored_layout(lcp_rho_factored *s, const lcp_capacity *cap, base_arena *a) {
  s->wj = BASE_ARRAY(a, double, cap->n_jac);
  s->first = BASE_ARRAY(a, int, cap->n_body);
  s->next = BASE_ARRAY(a, int, (cap->n_body > 0) ? 2 * (size_t)cap->n : 0);
  s->whole = BASE_ARRAY(a, unsigned char, (cap->n_body > 0) ? cap->n : 0);
  s->again = BASE_ARRAY(a, unsigned char, (cap->n_body > 0) ? cap->n : 0);
}

static int dofs(const lcp_factored *f, int b) {
  return (b < 0) ? 0 : f->dof_start[b + 1] - f->dof_start[b];
}

/* Where a side of group g begins in the rows of both: rows x dofs, row-major. */
static ptrdiff_t side_at(const lcp_factored *f, int g, int side) {
  const int rows = f->row_start[g + 1] - f->row_start[g];
  return (side == 1) ? (ptrdiff_t)rows * dofs(f, f->body[2 * (ptrdiff_t)g]) : 0;
}

/* out = W J' of n velocities: n x rows, row-major. */
static void weigh(const double *J, const double *W, int rows, int n, double *out) {
  for (int r = 0; r < rows; r++) {
    for (int c = 0; c < n; c++) {
      double sum = 0.0;
      for (int k = 0; k < n; k++) {
        sum += W[(ptrdiff_t)c * n + k] * J[r * n + k];
      }
      out[c * rows + r] = sum;
    }
  }
}

/* The same of six velocities, side by side. */
BASE_INLINE void weigh_six(const double *J, const double *W, int rows, double *out) {
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
      out[c * rows + r] = sum[c];
    }
  }
}

BASE_CLONES static void begin(lcp_rho_factored *s, const lcp_factored *f) {
  for (int b = 0; b < f->n_body; b++) {
    s->first[b] = -1;
  }
  for (int g = 0; g < f->n_group; g++) {
    const int rows = f->row_start[g + 1] - f->row_start[g];
    double room[LCP_MIXED_MAX];
    const double *all = lcp_factored_rows(f, g, room);
    for (int side = 0; side < 2; side++) {
      const int b = f->body[2 * g + side];
      if (b >= 0) {
        const double *J = all + side_at(f, g, side), *W = f->weight + f->weight_start[b];
        double *out = s->wj + f->jac_start[g] + side_at(f, g, side);
        if (dofs(f, b) == 6) {
          weigh_six(J, W, rows, out);
        } else {
          weigh(J, W, rows, dofs(f, b), out);
        }
        s->next[2 * g + side] = s->first[b];
        s->first[b] = 2 * g + side;
      }
    }
  }
  s->ready = true;
}

/* The sides over which two groups meet: J of the one and W J' of the other, and how many velocities there are. */
typedef struct meeting {
  int n;
  const double *left[4], *right[4];
  int dof[4];
} meeting;

static meeting meet(const lcp_rho_factored *s, const lcp_factored *f, int g, int h, double *room) {
  meeting m = {0};
  const double *rows = lcp_factored_rows(f, g, room);
  for (int a = 0; a < 2; a++) {
    for (int b = 0; b < 2; b++) {
      const int body = f->body[2 * g + a];
      if (body >= 0 && body == f->body[2 * h + b]) {
        m.left[m.n] = rows + side_at(f, g, a);
        m.right[m.n] = s->wj + f->jac_start[h] + side_at(f, h, b);
        m.dof[m.n++] = dofs(f, body);
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

/* (J W J')_ij of row i of one group and `count` rows of the other from `from` on, of `wide`. */
BASE_INLINE void entries(const meeting *m, int i, int from, int count, int wide, double *entry) {
  for (int k = 0; k < m->n; k++) {
    const int n = m->dof[k];
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

/* `count` rows from `from` on, of the `wide` of a group. */
typedef struct strip {
  int from, count, wide;
} strip;

/* size_i += |M_ij x_j| over some rows j of group h; M_ij has S inside a group. */
BASE_INLINE void add_columns(const lcp_factored *f, const meeting *m, int g, int h, strip some,
                             const double *x, double *size) {
  const int other = f->row_start[h] + some.from, end = f->row_start[g + 1];
  for (int first = f->row_start[g]; first < end; first += LANES) {
    const int rows = (end - first < LANES) ? end - first : LANES;
    double entry[LANES * LANES] = {0};
    for (int i = 0; i < rows; i++) {
      entries(m, first - f->row_start[g] + i, some.from, some.count, some.wide,
              entry + (ptrdiff_t)LANES * i);
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
  const int wide = f->row_start[h + 1] - f->row_start[h];
  if (wide == 6) { /* the commonest: a contact over four facets, and over a cone */
    add_columns(f, &m, g, h, (strip){0, 6, 6}, x, size);
  } else if (wide == 3) {
    add_columns(f, &m, g, h, (strip){0, 3, 3}, x, size);
  } else {
    for (int from = 0; from < wide; from += LANES) {
      const int count = (wide - from < LANES) ? wide - from : LANES;
      add_columns(f, &m, g, h, (strip){from, count, wide}, x, size);
    }
  }
}

static bool touches(const lcp_factored *f, int g, int body) {
  return f->body[2 * g] == body || f->body[2 * g + 1] == body;
}

/* size += the terms of group g's rows over the groups that share a body with it. */
static void add_neighbours(const lcp_rho_factored *s, const lcp_factored *f, int g, const double *x,
                           double *size) {
  const int *body = f->body + 2 * (ptrdiff_t)g;
  for (int side = 0; side < 2; side++) {
    for (int at = (body[side] >= 0) ? s->first[body[side]] : -1; at >= 0; at = s->next[at]) {
      const int h = at / 2;
      const bool again = (side == 1 && body[0] >= 0 && touches(f, h, body[0])) ||
                         (at % 2 == 1 && f->body[2 * h] == body[side]);
      if (h != g && !again) { /* every pair once, over all bodies that it shares */
        add_pair(s, f, g, h, x, size);
      }
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

void lcp_rho_factored_product(lcp_rho_factored *s, const lcp_problem *p, const unsigned char *some,
                              const unsigned char *whole, const double *x, double *size) {
  const lcp_factored *f = p->M.factored;
  if (!s->ready) {
    begin(s, f);
  }
  for (int g = 0; g < f->n_group; g++) {
    if (!any_of(some, f, g)) {
      continue;
    }
    for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
      size[i] = fabs(p->q[i]);
    }
    add_pair(s, f, g, g, x, size);
    if (any_of(whole, f, g)) {
      add_neighbours(s, f, g, x, size);
    }
  }
}
