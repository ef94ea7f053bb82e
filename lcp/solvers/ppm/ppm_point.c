/* ppm_point.c - residuals of a point of ppm and the corrections of its basic part. */
#include "lcp/lcp_column.h"
#include "lcp/solvers/ppm/ppm.h"

#include <float.h>

void lcp_ppm_evaluate(const ppm *s, const lcp_problem *p, const double *z) {
  const int n = p->M.n;
  if (p->M.storage == LCP_FACTORED) {
    lcp_ppm_evaluate_factored(s, p, z);
    return;
  }
  for (int i = 0; i < n; i++) {
    s->w[i] = p->q[i];
    s->bound[i] = fabs(p->q[i]);
  }
  for (int j = 0; j < n; j++) {
    if (z[j] != 0) {
      lcp_column_add_sized(lcp_column_of(&p->M, j), z[j], s->w, s->bound);
    }
  }
}

void lcp_ppm_correct(ppm *s, const lcp_problem *p, double *z, lcp_work *work) {
  double worst = 0;
  for (int k = 0; k < s->m; k++) {
    s->y[k] = -s->w[s->order[k]];
    worst = fmax(worst, fabs(s->y[k]) / s->bound[s->order[k]]);
  }
  if (!(worst > 1e-12)) {
    return;
  }
  lin_chol_forward(s->L, s->m, s->y);
  lin_chol_backward(s->L, s->m, s->y);
  for (int k = 0; k < s->m; k++) {
    z[s->order[k]] += s->y[k];
  }
  lcp_ppm_evaluate(s, p, z);
  work->refinements++;
  work->matvecs++;
}

void lcp_ppm_extended(const ppm *s, const lcp_problem *p, const double *z, const double *e) {
  const int n = p->M.n;
  if (p->M.storage == LCP_FACTORED) {
    lcp_ppm_extended_factored(s, p, z, e);
    return;
  }
  for (int i = 0; i < n; i++) {
    s->sum[i] = p->q[i];
  }
  for (int j = 0; j < n; j++) {
    const long double zj = (long double)z[j] + ((e != NULL) ? (long double)e[j] : 0);
    const lcp_column c = lcp_column_of(&p->M, j);
    for (int k = 0; zj != 0 && k < c.count; k++) {
      s->sum[lcp_column_row(&c, k)] += zj * c.val[k];
    }
  }
}

/* z + y; a sum that cancels down to rounding is zero, so that a row whose answer is zero, driven there
 * from a bound of its box, ends at zero and not at noise that a scale-invariant residual sees. */
static double added(double z, double y) {
  const double sum = z + y;
  return (fabs(sum) <= 4 * DBL_EPSILON * fabs(y)) ? 0 : sum;
}

void lcp_ppm_refine(ppm *s, const lcp_problem *p, double *z, lcp_work *work) {
  for (int round = 0; round < 2; round++) {
    lcp_ppm_extended(s, p, z, NULL);
    for (int k = 0; k < s->m; k++) {
      s->y[k] = (double)-s->sum[s->order[k]];
    }
    lin_chol_forward(s->L, s->m, s->y);
    lin_chol_backward(s->L, s->m, s->y);
    for (int k = 0; k < s->m; k++) {
      const int i = s->order[k];
      z[i] = fmin(fmax(added(z[i], s->y[k]), s->lo[i]), s->hi[i]); /* on K; the residual decides */
    }
    work->refinements++;
  }
}
