#include "lcp/lcp_rho_factored.h"

#include "lcp/base/clones.h"
#include "lcp/lcp_column.h"

enum { LANES = 8 }; /* entries of a row that are made together */

void lcp_rho_factored_layout(lcp_rho_factored *s, const lcp_capacity *cap, base_arena *a) {
  s->wj = BASE_ARRAY(a, double, cap->n_jac);
  s->first = BASE_ARRAY(a, int, cap->n_body);
  s->next = BASE_ARRAY(a, int, (cap->n_body > 0) ? 2 * (size_t)cap->n : 0);
  s->whole = BASE_ARRAY(a, unsigned char, (cap->n_body > 0) ? cap->n : 0);
}

static int dofs(const lcp_factored *f, int b) {
  return (b < 0) ? 0 : f->dof_start[b + 1] - f->dof_start[b];
}

/* J and J W of the rows of group g at one of its sides: rows x dofs, row-major. */
static ptrdiff_t side_at(const lcp_factored *f, int g, int side) {
  const int rows = f->row_start[g + 1] - f->row_start[g];
  return f->jac_start[g] + ((side == 1) ? (ptrdiff_t)rows * dofs(f, f->body[2 * g]) : 0);
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

static void begin(lcp_rho_factored *s, const lcp_factored *f) {
  for (int b = 0; b < f->n_body; b++) {
    s->first[b] = -1;
  }
  for (int g = 0; g < f->n_group; g++) {
    const int rows = f->row_start[g + 1] - f->row_start[g];
    for (int side = 0; side < 2; side++) {
      const int b = f->body[2 * g + side];
      if (b >= 0) {
        weigh(f->jac + side_at(f, g, side), f->weight + f->weight_start[b], rows, dofs(f, b),
              s->wj + side_at(f, g, side));
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

static meeting meet(const lcp_rho_factored *s, const lcp_factored *f, int g, int h) {
  meeting m = {0};
  for (int a = 0; a < 2; a++) {
    for (int b = 0; b < 2; b++) {
      const int body = f->body[2 * g + a];
      if (body >= 0 && body == f->body[2 * h + b]) {
        m.left[m.n] = f->jac + side_at(f, g, a);
        m.right[m.n] = s->wj + side_at(f, h, b);
        m.dof[m.n++] = dofs(f, body);
      }
    }
  }
  return m;
}

/* entry_j += sum over n velocities of x times column j of y, `wide` numbers a row. */
static inline void add_dots(const double *x, const double *y, int n, int wide, int count,
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
static inline void entries(const meeting *m, int i, int from, int count, int wide, double *entry) {
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

/* Some columns of S, read from their first row on. */
typedef struct shift_reader {
  lcp_column column[LANES];
  int at[LANES];
} shift_reader;

static void read_from(shift_reader *r, const lcp_csc *S, int column, int count) {
  for (int j = 0; j < count; j++) {
    r->column[j] = lcp_csc_column(S, column + j);
    r->at[j] = 0;
  }
}

/* entry += row i of the columns; rows rise from call to call. */
static void add_shift(shift_reader *r, int i, int count, double *entry) {
  for (int j = 0; j < count; j++) {
    const lcp_column *c = &r->column[j];
    while (r->at[j] < c->count && c->row[r->at[j]] < i) {
      r->at[j]++;
    }
    if (r->at[j] < c->count && c->row[r->at[j]] == i) {
      entry[j] += c->val[r->at[j]];
    }
  }
}

/* `count` rows from `from` on, of the `wide` of a group. */
typedef struct strip {
  int from, count, wide;
} strip;

/* size_i += |M_ij x_j| over some rows j of group h; M_ij has S inside a group. */
static inline void add_columns(const lcp_factored *f, const meeting *m, int g, int h, strip some,
                               const double *x, double *size) {
  const int from = some.from, count = some.count;
  const bool own = g == h && f->shift != NULL;
  const int first = f->row_start[g], rows = f->row_start[g + 1] - first;
  const int other = f->row_start[h] + from;
  shift_reader shift;
  if (own) {
    read_from(&shift, f->shift, other, count);
  }
  for (int i = 0; i < rows; i++) {
    double entry[LANES] = {0}, sum = size[first + i];
    entries(m, i, from, count, some.wide, entry);
    if (own) {
      add_shift(&shift, first + i, count, entry);
    }
    for (int j = 0; j < count; j++) {
      sum += (x[other + j] != 0.0) ? fabs(entry[j] * x[other + j]) : 0.0;
    }
    size[first + i] = sum;
  }
}

BASE_CLONES static void add_pair(const lcp_rho_factored *s, const lcp_factored *f, int g, int h,
                                 const double *x, double *size) {
  const meeting m = meet(s, f, g, h);
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

void lcp_rho_factored_product(lcp_rho_factored *s, const lcp_problem *p, const unsigned char *whole,
                              const double *x, double *size) {
  const lcp_factored *f = p->M.factored;
  if (!s->ready) {
    begin(s, f);
  }
  for (int i = 0; i < p->M.n; i++) {
    size[i] = fabs(p->q[i]);
  }
  for (int g = 0; g < f->n_group; g++) {
    bool all = whole == NULL;
    for (int i = f->row_start[g]; i < f->row_start[g + 1] && !all; i++) {
      all = whole[i] != 0;
    }
    add_pair(s, f, g, g, x, size);
    if (all) {
      add_neighbours(s, f, g, x, size);
    }
  }
}
