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

/* x onto the disc of the given radius. */
static void disc_project(double radius, int dim, double *x) {
  double t = 0;
  for (int k = 0; k < dim; k++) {
    t += x[k] * x[k];
  }
  for (int k = 0; k < dim && t > radius * radius; k++) {
    x[k] *= radius / sqrt(t);
  }
}

/* lambda_n <- max(0, lambda_n - w_n / a), then each part onto its disc mu lambda_n: fixed points are
 * Coulomb's law. */
static double cone_update(const lcp_problem *p, const double *M, const lcp_block *b, double *z) {
  const int n = p->M.n;
  int row = b->start;
  const double own = M[(ptrdiff_t)row * n + row];
  const double normal = fmax(0, z[row] - row_product(M, n, p->q, z, row) / own);
  double change = own * fabs(normal - z[row]);
  z[row++] = normal;
  for (int part = 0; part < b->n_part; part++) {
    double x[2];
    double a = 0;
    for (int k = 0; k < b->part_dim[part]; k++) {
      a = fmax(a, 1.5 * M[(ptrdiff_t)(row + k) * n + row + k]);
    }
    for (int k = 0; k < b->part_dim[part]; k++) {
      x[k] = z[row + k] - row_product(M, n, p->q, z, row + k) / a;
    }
    disc_project(b->part_mu[part] * normal, b->part_dim[part], x);
    for (int k = 0; k < b->part_dim[part]; k++, row++) {
      change = fmax(change, a * fabs(x[k] - z[row]));
      z[row] = x[k];
    }
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
