/* ppm_factored.c - what ppm needs of M = G G' + S, G = J L with W = L L' (sweep.h): a column is the product of
 * G with one row of it, a residual the product of G with the body velocities. n x n is never formed. */
#include "lcp/lcp_column.h"
#include "lcp/solvers/ppm/ppm.h"

#include <string.h>

void lcp_ppm_evaluate_factored(const ppm *s, const lcp_problem *p, const double *z) {
  const lcp_factored *f = p->M.factored;
  const int n_dof = f->dof_start[f->n_body];
  double *u = s->sweep.u;
  double *size = s->dof; /* |G|' |z| */
  memset(u, 0, sizeof *u * (size_t)n_dof);
  memset(size, 0, sizeof *size * (size_t)n_dof);
  for (int i = 0; i < p->M.n; i++) {
    s->w[i] = p->q[i];
    s->bound[i] = fabs(p->q[i]);
  }
  for (int j = 0; j < p->M.n; j++) {
    for (int k = 0; k < 2 && z[j] != 0; k++) {
      const lcp_sweep_side a = lcp_sweep_side_of(&s->sweep, f, j, k);
      for (int c = 0; c < a.dof; c++) {
        a.u[c] += a.g[c] * z[j];
        size[a.u - u + c] += fabs(a.g[c] * z[j]);
      }
    }
    if (z[j] != 0) {
      lcp_column_add_sized(lcp_csc_column(f->shift, j), z[j], s->w, s->bound);
    }
  }
  for (int i = 0; i < p->M.n; i++) {
    for (int k = 0; k < 2; k++) {
      const lcp_sweep_side a = lcp_sweep_side_of(&s->sweep, f, i, k);
      const double *own = size + (a.u - u);
      double w = 0;
      double bound = 0;
      for (int c = 0; c < a.dof; c++) {
        w += a.g[c] * a.u[c];
        bound += fabs(a.g[c]) * own[c];
      }
      s->w[i] += w;
      s->bound[i] += bound;
    }
  }
}

/* Puts row r of G into s->dof. */
static void spread(const ppm *s, const lcp_factored *f, int r) {
  for (int k = 0; k < 2; k++) {
    const lcp_sweep_side a = lcp_sweep_side_of(&s->sweep, f, r, k);
    for (int c = 0; c < a.dof; c++) {
      s->dof[a.u - s->sweep.u + c] = a.g[c];
    }
  }
}

void lcp_ppm_gather_factored(const ppm *s, const lcp_factored *f, int r, double *x) {
  memset(s->dof, 0, sizeof *s->dof * (size_t)f->dof_start[f->n_body]);
  spread(s, f, r);
  for (int k = 0; k < s->m; k++) {
    double sum = 0;
    for (int side = 0; side < 2; side++) {
      const lcp_sweep_side a = lcp_sweep_side_of(&s->sweep, f, s->order[k], side);
      const double *own = s->dof + (a.u - s->sweep.u);
      for (int c = 0; c < a.dof; c++) {
        sum += a.g[c] * own[c];
      }
    }
    x[k] = sum;
  }
  const lcp_column shift = lcp_csc_column(f->shift, r);
  for (int k = 0; k < shift.count; k++) {
    if (s->pos[shift.row[k]] >= 0) {
      x[s->pos[shift.row[k]]] += shift.val[k];
    }
  }
}

void lcp_ppm_extended_factored(const ppm *s, const lcp_problem *p, const double *z,
                               const double *e) {
  const lcp_factored *f = p->M.factored;
  long double *u = s->wide;
  memset(u, 0, sizeof *u * (size_t)f->dof_start[f->n_body]);
  for (int i = 0; i < p->M.n; i++) {
    s->sum[i] = p->q[i];
  }
  for (int j = 0; j < p->M.n; j++) {
    const long double zj = (long double)z[j] + ((e != NULL) ? (long double)e[j] : 0);
    for (int k = 0; k < 2 && zj != 0; k++) {
      const lcp_sweep_side a = lcp_sweep_side_of(&s->sweep, f, j, k);
      for (int c = 0; c < a.dof; c++) {
        u[a.u - s->sweep.u + c] += (long double)a.g[c] * zj;
      }
    }
    const lcp_column shift = lcp_csc_column(f->shift, j);
    for (int k = 0; k < shift.count; k++) {
      s->sum[shift.row[k]] += (long double)shift.val[k] * zj;
    }
  }
  for (int i = 0; i < p->M.n; i++) {
    for (int k = 0; k < 2; k++) {
      const lcp_sweep_side a = lcp_sweep_side_of(&s->sweep, f, i, k);
      for (int c = 0; c < a.dof; c++) {
        s->sum[i] += a.g[c] * u[a.u - s->sweep.u + c];
      }
    }
  }
}
