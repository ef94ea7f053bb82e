#include "lcp/solvers/sweep.h"

#include "lcp/lcp_column.h"
#include "lcp/linear/body_space.h"

#include <string.h>

void lcp_sweep_layout(lcp_sweep *s, const lcp_capacity *cap, base_arena *a) {
  s->w = BASE_ARRAY(a, double, cap->n);
  s->d = BASE_ARRAY(a, double, cap->n);
  s->G = BASE_ARRAY(a, double, cap->n_jac);
  s->u = BASE_ARRAY(a, double, cap->n_dof);
  s->L = BASE_ARRAY(a, double, cap->n_weight);
  s->group = BASE_ARRAY(a, int, (cap->n_body > 0) ? cap->n : 0);
}

base_status lcp_sweep_weigh_bodies(lcp_sweep *s, const lcp_factored *f, base_error *err) {
  BASE_TRY(lin_weigh_bodies(f, s->L, err));
  for (int g = 0; g < f->n_group; g++) {
    for (int i = f->row_start[g]; i < f->row_start[g + 1]; i++) {
      s->group[i] = g;
    }
  }
  return BASE_OK;
}

base_status lcp_sweep_prepare(lcp_sweep *s, const lcp_problem *p, base_error *err) {
  if (p->M.storage == LCP_FACTORED) {
    BASE_TRY(lcp_sweep_weigh_bodies(s, p->M.factored, err));
    lin_weigh_rows(p->M.factored, s->L, s->G);
  }
  lcp_matrix_diagonal(&p->M, s->d);
  return BASE_OK;
}

void lcp_sweep_add(lcp_sweep *s, const lcp_problem *p, int j, double dz) {
  lcp_column_add(lcp_column_of(&p->M, j), dz, s->w);
  for (int k = 0; k < 2 && p->M.storage == LCP_FACTORED; k++) {
    const lcp_sweep_side a = lcp_sweep_side_of(s, p->M.factored, j, k);
    for (int i = 0; i < a.dof; i++) {
      a.u[i] += a.g[i] * dz;
    }
  }
}

double lcp_sweep_row(const lcp_sweep *s, const lcp_problem *p, int i) {
  double w = s->w[i];
  for (int k = 0; p->M.storage == LCP_FACTORED && k < 2; k++) {
    const lcp_sweep_side a = lcp_sweep_side_of(s, p->M.factored, i, k);
    for (int j = 0; j < a.dof; j++) {
      w += a.g[j] * a.u[j];
    }
  }
  return w;
}

void lcp_sweep_refresh(lcp_sweep *s, const lcp_problem *p, const double *z, lcp_work *work) {
  bool product = false;
  memcpy(s->w, p->q, (size_t)p->M.n * sizeof *s->w);
  if (p->M.storage == LCP_FACTORED) {
    const lcp_factored *f = p->M.factored;
    memset(s->u, 0, (size_t)f->dof_start[f->n_body] * sizeof *s->u);
  }
  for (int j = 0; j < p->M.n; j++) {
    if (z[j] != 0.0) {
      lcp_sweep_add(s, p, j, z[j]);
      product = true;
    }
  }
  work->matvecs += product;
}

/* out += rows first .. first+size-1 of a column. */
static void add_rows(lcp_column c, int first, int size, double *out) {
  if (c.row == NULL) {
    for (int i = 0; i < size; i++) {
      out[i] += c.val[first + i];
    }
    return;
  }
  for (int k = 0; k < c.count && c.row[k] < first + size; k++) {
    if (c.row[k] >= first) {
      out[c.row[k] - first] += c.val[k];
    }
  }
}

static double mass_weighted(const lcp_sweep *s, const lcp_factored *f, int i, int j) {
  double sum = 0.0;
  for (int a = 0; a < 2; a++) {
    for (int b = 0; b < 2; b++) {
      const lcp_sweep_side x = lcp_sweep_side_of(s, f, i, a), y = lcp_sweep_side_of(s, f, j, b);
      for (int k = 0; x.body >= 0 && x.body == y.body && k < x.dof; k++) {
        sum += x.g[k] * y.g[k];
      }
    }
  }
  return sum;
}

void lcp_sweep_block(const lcp_sweep *s, const lcp_problem *p, int first, int size, double *out) {
  memset(out, 0, (size_t)size * (size_t)size * sizeof *out);
  for (int j = 0; j < size; j++) {
    for (int i = 0; i < size && p->M.storage == LCP_FACTORED; i++) {
      out[i + j * size] = mass_weighted(s, p->M.factored, first + i, first + j);
    }
    add_rows(lcp_column_of(&p->M, first + j), first, size, out + (ptrdiff_t)j * size);
  }
}
