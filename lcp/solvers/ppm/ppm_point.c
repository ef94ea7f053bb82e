/* ppm_point.c - residuals of a point of ppm and the corrections of its basic part. */
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
    const double zj = z[j];
    if (zj == 0) {
      continue;
    }
    if (p->M.storage == LCP_DENSE) {
      const double *col = p->M.val + (ptrdiff_t)j * n;
      for (int i = 0; i < n; i++) {
        const double term = col[i] * zj;
        s->w[i] += term;
        s->bound[i] += fabs(term);
      }
    } else {
      for (int k = p->M.csc.colptr[j]; k < p->M.csc.colptr[j + 1]; k++) {
        const double term = p->M.csc.val[k] * zj;
        s->w[p->M.csc.rowind[k]] += term;
        s->bound[p->M.csc.rowind[k]] += fabs(term);
      }
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

/* sum = M z + q in long double. */
static void extended_w(const ppm *s, const lcp_problem *p, const double *z) {
  const int n = p->M.n;
  const bool dense = p->M.storage == LCP_DENSE;
  if (p->M.storage == LCP_FACTORED) {
    lcp_ppm_extended_factored(s, p, z);
    return;
  }
  for (int i = 0; i < n; i++) {
    s->sum[i] = p->q[i];
  }
  for (int j = 0; j < n; j++) {
    const long double zj = z[j];
    const int first = dense ? 0 : p->M.csc.colptr[j];
    const int last = dense ? n : p->M.csc.colptr[j + 1];
    const double *val = dense ? p->M.val + (ptrdiff_t)j * n : p->M.csc.val;
    for (int k = first; zj != 0 && k < last; k++) {
      s->sum[dense ? k : p->M.csc.rowind[k]] += zj * val[k];
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
    extended_w(s, p, z);
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
