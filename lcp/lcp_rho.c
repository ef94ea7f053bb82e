#include "lcp/lcp_rho.h"

#include "lcp/base/clones.h"
#include "lcp/lcp_cone.h"

BASE_CLONES void lcp_rho_product(const lcp_problem *p, const double *x, double *w, double *size) {
  for (int i = 0; i < p->M.n; i++) {
    size[i] = fabs(p->q[i]);
    if (w != NULL) {
      w[i] = p->q[i];
    }
  }
  for (int j = 0; j < p->M.n; j++) {
    if (x[j] == 0.0) {
      continue;
    }
    if (w != NULL) {
      lcp_column_add_sized(lcp_column_of(&p->M, j), x[j], w, size);
    } else {
      lcp_column_add_size(lcp_column_of(&p->M, j), x[j], size);
    }
  }
}

void lcp_rho_references(const lcp_problem *p, const double *d, const double *tau0, double *zref) {
  for (int i = 0; i < p->M.n; i++) {
    zref[i] = lcp_rho_reference(d[i], tau0[i], lcp_column_of(&p->M, i), tau0);
  }
}

/* Over the largest tau of the block, with the mean diagonal. A projection could lose a NaN of w, so it is looked for. */
static double cone(const lcp_block *b, const double *d, const double *z, const double *w,
                   const double *tau) {
  double moved[1 + 2 * LCP_PARTS_MAX], mean = 0.0, largest = 0.0, worst = 0.0;
  for (int i = 0; i < b->size; i++) {
    mean += d[i] / b->size;
    largest = fmax(largest, tau[i]);
    if (w[i] != w[i]) {
      return w[i];
    }
  }
  mean = (mean > 0.0) ? mean : 1.0;
  for (int i = 0; i < b->size; i++) {
    moved[i] = mean * z[i] - w[i];
  }
  moved[0] -= lcp_cone_shift(b, w);
  lcp_cone_project(b, moved, moved);
  for (int i = 0; i < b->size; i++) {
    worst = lcp_rho_worse(worst, lcp_rho_over(fabs(mean * z[i] - moved[i]), largest));
  }
  return worst;
}

/* The term of block b, which is no cone: the largest of its rows. */
static double rows_of(const lcp_problem *p, const lcp_block *b, const double *z, const double *w,
                      const double *zref, const double *tau) {
  const bool box = b->set == LCP_BOX;
  double worst = 0.0;
  for (int i = b->start; i < b->start + b->size; i++) {
    worst = lcp_rho_worse(worst, lcp_rho_row(b->set, z[i], w[i], box ? p->lo[i] : 0.0,
                                             box ? p->hi[i] : HUGE_VAL, zref[i], tau[i]));
  }
  return worst;
}

/* The blocks of p; without any, an orthant. */
static const lcp_block *blocks_of(const lcp_problem *p, lcp_block *whole, int *count) {
  *whole = (lcp_block){.start = 0, .size = p->M.n, .set = LCP_ORTHANT};
  *count = (p->block != NULL) ? p->n_block : 1;
  return (p->block != NULL) ? p->block : whole;
}

static double term(const lcp_problem *p, const lcp_block *b, const double *d, const double *z,
                   const double *w, const double *zref, const double *tau) {
  const int at = b->start;
  return (b->set == LCP_CONE) ? cone(b, d + at, z + at, w + at, tau + at)
                              : rows_of(p, b, z, w, zref, tau);
}

double lcp_rho(const lcp_problem *p, const double *d, const double *z, const double *w,
               const double *zref, const double *tau) {
  lcp_block whole;
  int count;
  const lcp_block *block = blocks_of(p, &whole, &count);
  double worst = 0.0;
  for (int b = 0; b < count; b++) {
    worst = lcp_rho_worse(worst, term(p, &block[b], d, z, w, zref, tau));
  }
  return worst;
}

bool lcp_rho_within(const lcp_problem *p, double tol, const double *d, const double *z,
                    const double *w, const double *zref, const double *tau) {
  lcp_block whole;
  int count;
  const lcp_block *block = blocks_of(p, &whole, &count);
  bool within = true;
  for (int b = 0; b < count && within; b++) {
    within = term(p, &block[b], d, z, w, zref, tau) <= tol;
  }
  return within;
}

void lcp_rho_above_tol(const lcp_problem *p, double tol, const double *d, const double *z,
                       const double *w, const double *zref, const double *tau,
                       unsigned char *above) {
  for (int i = 0; p->block == NULL && i < p->M.n; i++) {
    const lcp_block row = {.start = i, .size = 1, .set = LCP_ORTHANT};
    above[i] = !(rows_of(p, &row, z, w, zref, tau) <= tol);
  }
  for (int b = 0; p->block != NULL && b < p->n_block; b++) {
    const lcp_block *k = &p->block[b];
    const bool out = !(term(p, k, d, z, w, zref, tau) <= tol);
    for (int i = k->start; i < k->start + k->size; i++) {
      above[i] = out;
    }
  }
}
