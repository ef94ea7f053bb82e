#include "lcp/lcp_rho_factored.h"

#include "lcp/lcp_column.h"

void lcp_rho_factored_layout(lcp_rho_factored *s, const lcp_capacity *cap, base_arena *a) {
  s->wj = BASE_ARRAY(a, double, cap->n_jac);
  s->first = BASE_ARRAY(a, int, cap->n_body);
  s->next = BASE_ARRAY(a, int, (cap->n_body > 0) ? 2 * (size_t)cap->n : 0);
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

/* M_ij of row i of group g and row j of group h. */
static double entry(const lcp_rho_factored *s, const lcp_factored *f, int g, int i, int h, int j) {
  double sum = 0.0;
  for (int a = 0; a < 2; a++) {
    for (int b = 0; b < 2; b++) {
      const int body = f->body[2 * g + a], n = dofs(f, body);
      if (body != f->body[2 * h + b]) {
        continue;
      }
      const double *left = f->jac + side_at(f, g, a) + (ptrdiff_t)(i - f->row_start[g]) * n;
      const double *right = s->wj + side_at(f, h, b) + (ptrdiff_t)(j - f->row_start[h]) * n;
      for (int k = 0; k < n; k++) {
        sum += left[k] * right[k];
      }
    }
  }
  const lcp_column c = lcp_csc_column(f->shift, j);
  for (int k = 0; k < c.count; k++) {
    sum += (c.row[k] == i) ? c.val[k] : 0.0;
  }
  return sum;
}

static void add_pair(const lcp_rho_factored *s, const lcp_factored *f, int g, int h,
                     const double *x, double *size) {
  for (int j = f->row_start[h]; j < f->row_start[h + 1]; j++) {
    for (int i = f->row_start[g]; i < f->row_start[g + 1] && x[j] != 0.0; i++) {
      size[i] += fabs(entry(s, f, g, i, h, j) * x[j]);
    }
  }
}

static bool touches(const lcp_factored *f, int g, int body) {
  return f->body[2 * g] == body || f->body[2 * g + 1] == body;
}

void lcp_rho_factored_product(lcp_rho_factored *s, const lcp_problem *p, const double *x,
                              double *size) {
  const lcp_factored *f = p->M.factored;
  if (!s->ready) {
    begin(s, f);
  }
  for (int i = 0; i < p->M.n; i++) {
    size[i] = fabs(p->q[i]);
  }
  for (int g = 0; g < f->n_group; g++) {
    const int *body = f->body + 2 * (ptrdiff_t)g;
    add_pair(s, f, g, g, x, size);
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
}
