#include "tests/support/relax.h"

#include <stdlib.h>
#include <string.h>

static double row_product(const double *M, int n, const double *q, const double *z, int i) {
  double w = q[i];
  for (int j = 0; j < n; j++) {
    w += M[(ptrdiff_t)j * n + i] * z[j];
  }
  return w;
}

static void cone_project(double mu, int dim, double *x) {
  double t = 0;
  for (int k = 1; k <= dim; k++) {
    t += x[k] * x[k];
  }
  t = sqrt(t);
  if (t <= mu * x[0]) {
    return;
  }
  const double s = fmax(0, (x[0] + mu * t) / (1 + mu * mu));
  for (int k = 1; k <= dim; k++) {
    x[k] *= (t > 0) ? mu * s / t : 0;
  }
  x[0] = s;
}

/* One projection z <- P_K(z - (w + mu |w_t| e_n) / a) of a cone block. */
static double cone_update(const lcp_problem *p, const double *M, const lcp_block *b, double *z) {
  const int n = p->M.n;
  double w[4] = {0};
  double x[4] = {0};
  double speed = 0;
  double a = 0;
  for (int k = 0; k < b->size; k++) {
    w[k] = row_product(M, n, p->q, z, b->start + k);
    a = fmax(a, M[(ptrdiff_t)(b->start + k) * n + b->start + k]);
    speed += (k > 0) ? w[k] * w[k] : 0;
  }
  for (int k = 0; k < b->size; k++) {
    x[k] = z[b->start + k] - (w[k] + ((k == 0) ? b->part_mu[0] * sqrt(speed) : 0)) / (1.5 * a);
  }
  cone_project(b->part_mu[0], b->size - 1, x);
  double change = 0;
  for (int k = 0; k < b->size; k++) {
    change = fmax(change, a * fabs(x[k] - z[b->start + k]));
    z[b->start + k] = x[k];
  }
  return change;
}

static double point_update(const lcp_problem *p, const double *M, const lcp_block *b, double *z) {
  const int n = p->M.n;
  double change = 0;
  for (int i = b->start; i < b->start + b->size; i++) {
    const double a = M[(ptrdiff_t)i * n + i];
    double x = z[i] - row_product(M, n, p->q, z, i) / a;
    if (b->set == LCP_ORTHANT) {
      x = fmax(x, 0);
    } else if (b->set == LCP_BOX) {
      x = fmin(fmax(x, p->lo[i]), p->hi[i]);
    }
    change = fmax(change, a * fabs(x - z[i]));
    z[i] = x;
  }
  return change;
}

lcp_outcome relax_solve(const lcp_problem *p, double *z, double tol) {
  const int n = p->M.n;
  double *M = calloc((size_t)n * (size_t)n + 1, sizeof *M);
  lcp_matrix_to_dense(&p->M, M);
  memset(z, 0, (size_t)n * sizeof *z);
  lcp_outcome out = LCP_MAX_ITER;
  for (int sweep = 0; sweep < 200000 && out != LCP_SOLVED; sweep++) {
    double change = 0;
    for (int k = 0; k < p->n_block; k++) {
      const lcp_block *b = &p->block[k];
      const double c = (b->set == LCP_CONE) ? cone_update(p, M, b, z) : point_update(p, M, b, z);
      change = fmax(change, c);
    }
    out = (change <= tol) ? LCP_SOLVED : out;
  }
  free(M);
  return out;
}
