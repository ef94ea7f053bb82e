#include "lcp/lcp_cone.h"

static double part_norm(const double *x, int dim) {
  return (dim == 1) ? fabs(x[0]) : hypot(x[0], x[1]);
}

double lcp_cone_shift(const lcp_block *b, const double *w) {
  double sum = 0.0;
  for (int k = 0, at = 1; k < b->n_part; at += b->part_dim[k++]) {
    sum += b->part_mu[k] * part_norm(w + at, b->part_dim[k]);
  }
  return sum;
}

double lcp_cone_violation(const lcp_block *b, const double *r) {
  double worst = fmax(0.0, -r[0]);
  for (int k = 0, at = 1; k < b->n_part; at += b->part_dim[k++]) {
    worst = fmax(worst, part_norm(r + at, b->part_dim[k]) - b->part_mu[k] * r[0]);
  }
  return worst;
}

/* Root of the increasing function g(r) = r - x_n - sum_k mu_k max(0, |x_k| - mu_k r), half the
 * derivative of the squared distance. Dropping max() can only raise g, so the root found with a set
 * of active parts is a lower bound: parts inside their bound there are inside at the true root too
 * and are dropped for good. A part with mu_k = 0 ends at zero and adds nothing. */
static double normal_part(const lcp_block *b, const double *x, const double *norm) {
  bool active[LCP_PARTS_MAX];
  for (int k = 0; k < b->n_part; k++) {
    active[k] = b->part_mu[k] > 0.0;
  }
  double r = 0.0;
  for (int pass = 0; pass <= b->n_part; pass++) {
    double top = x[0], bottom = 1.0;
    for (int k = 0; k < b->n_part; k++) {
      top += active[k] ? b->part_mu[k] * norm[k] : 0.0;
      bottom += active[k] ? b->part_mu[k] * b->part_mu[k] : 0.0;
    }
    r = top / bottom;
    bool changed = false;
    for (int k = 0; k < b->n_part; k++) {
      if (active[k] && norm[k] < b->part_mu[k] * r) {
        active[k] = false;
        changed = true;
      }
    }
    if (!changed) {
      break;
    }
  }
  return r;
}

void lcp_cone_project(const lcp_block *b, const double *x, double *out) {
  double norm[LCP_PARTS_MAX] = {0};
  for (int k = 0, at = 1; k < b->n_part; at += b->part_dim[k++]) {
    norm[k] = part_norm(x + at, b->part_dim[k]);
  }
  const double r = fmax(0.0, normal_part(b, x, norm));
  for (int k = 0, at = 1; k < b->n_part; at += b->part_dim[k++]) {
    const double bound = b->part_mu[k] * r;
    const double scale = (norm[k] > bound) ? bound / norm[k] : 1.0;
    for (int i = at; i < at + b->part_dim[k]; i++) {
      out[i] = scale * x[i];
    }
  }
  out[0] = r;
}
