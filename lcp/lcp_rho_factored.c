#include "lcp/lcp_rho_factored.h"

#include "lcp/lcp_column.h"

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

/* out = J W of n velocities: rows x n, row-major. */
static void weigh(const double *J, const double *W, int rows, int n, double *out) {
  for (int r = 0; r < rows; r++) {
    for (int c = 0; c < n; c++) {
      double sum = 0.0;
      for (int k = 0; k < n; k++) {
        sum += W[(ptrdiff_t)c * n + k] * J[r * n + k];
      }
      out[r * n + c] = sum;
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

/* The sides over which two groups meet: rows of J of the one and of J W of the other, and how long they are. */
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

static inline double dot(const double *x, const double *y, int n) {
  double sum = 0.0;
  for (int k = 0; k < n; k++) {
    sum += x[k] * y[k];
  }
  return sum;
}

/* (J W J')_ij for rows i and j of the two groups, each counted in its own. */
static inline double entry(const meeting *m, int i, int j) {
  double sum = 0.0;
  for (int k = 0; k < m->n; k++) {
    const int n = m->dof[k];
    const double *x = m->left[k] + (ptrdiff_t)i * n, *y = m->right[k] + (ptrdiff_t)j * n;
    sum += (n == 6) ? dot(x, y, 6) : dot(x, y, n);
  }
  return sum;
}

static double shift(const lcp_factored *f, int i, int j) {
  const lcp_column c = lcp_csc_column(f->shift, j);
  double sum = 0.0;
  for (int k = 0; k < c.count; k++) {
    sum += (c.row[k] == i) ? c.val[k] : 0.0;
  }
  return sum;
}

static void add_pair(const lcp_rho_factored *s, const lcp_factored *f, int g, int h,
                     const double *x, double *size) {
  const meeting m = meet(s, f, g, h);
  const bool own = g == h && f->shift != NULL;
  const int rows = f->row_start[g + 1] - f->row_start[g];
  double *to = size + f->row_start[g];
  for (int j = f->row_start[h]; j < f->row_start[h + 1]; j++) {
    for (int i = 0; i < rows && x[j] != 0.0; i++) {
      const double e = entry(&m, i, j - f->row_start[h]);
      to[i] += fabs((e + (own ? shift(f, f->row_start[g] + i, j) : 0.0)) * x[j]);
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
