#include "lcp/solvers/data_test.h"

#include "lcp/lcp_cone.h"
#include "lcp/lcp_rho.h"
#include "lcp/solvers/sets.h"

#include <float.h>

/* fmax and fmin of numbers, without the calls. */
static double larger(double a, double b) {
  return (a > b) ? a : b;
}

static double smaller(double a, double b) {
  return (a < b) ? a : b;
}

/* Violation of row i of an interval set, as a velocity: the natural map d z - P(d z - w). */
static double violation(const lcp_problem *p, lcp_set set, int i, double d, double z, double w) {
  switch (set) {
  case LCP_ORTHANT:
    return larger(larger(-w, -d * z), smaller(w, d * z));
  case LCP_FREE:
    return fabs(w);
  case LCP_BOX:
    return larger(larger(d * (p->lo[i] - z), d * (z - p->hi[i])),
                  (w > 0.0) ? smaller(w, d * (z - p->lo[i])) : smaller(-w, d * (p->hi[i] - z)));
  case LCP_CONE: /* by its block */
    break;
  }
  return 0.0;
}

/* The same of a cone: the largest entry of d z - P_K(d z - w~). */
static double cone_violation(const lcp_block *b, double d, const double *z, const double *w) {
  double moved[1 + 2 * LCP_PARTS_MAX], worst = 0.0;
  for (int i = 0; i < b->size; i++) {
    moved[i] = d * z[i] - w[i];
  }
  moved[0] -= lcp_cone_shift(b, w);
  lcp_cone_project(b, moved, moved);
  for (int i = 0; i < b->size; i++) {
    worst = lcp_rho_worse(worst, fabs(d * z[i] - moved[i]));
  }
  return worst;
}

double lcp_data_size(const lcp_problem *p, const double *r) {
  double size = 0.0;
  for (int i = 0; i < p->M.n; i++) {
    size = larger(size, r[i] * fabs(p->q[i]));
  }
  for (int b = 0; p->block != NULL && b < p->n_block; b++) {
    const lcp_block *k = &p->block[b];
    for (int i = k->start; k->set == LCP_BOX && i < k->start + k->size; i++) {
      size = larger(size, fabs(lcp_set_clip(0.0, p->lo[i], p->hi[i])) / r[i]);
    }
  }
  return size;
}

/* What a row or a cone misses by, and what rounding may hide there. */
typedef struct miss {
  double seen, noise;
} miss;

static miss miss_of_row(const lcp_problem *p, lcp_set set, int i, const double *r, const double *z,
                        const double *w, const double *tau0) {
  return (miss){r[i] * violation(p, set, i, 1.0 / (r[i] * r[i]), z[i], w[i]),
                (tau0 != NULL) ? DBL_EPSILON * r[i] * tau0[i] : 0.0};
}

static miss miss_of_cone(const lcp_block *b, const double *r, const double *z, const double *w,
                         const double *tau0) {
  double d = 0.0, top = 0.0;
  for (int i = b->start; i < b->start + b->size; i++) {
    d += 1.0 / (r[i] * r[i] * b->size);
    top = (tau0 != NULL) ? larger(top, tau0[i]) : 0.0;
  }
  const double rb = 1.0 / sqrt(d);
  return (miss){rb * cone_violation(b, d, z + b->start, w + b->start), DBL_EPSILON * rb * top};
}

double lcp_data_limit(double tol, double size) {
  return 10.0 * tol * size;
}

double lcp_data_miss(const lcp_problem *p, const lcp_block *b, const double *r, const double *z,
                     const double *w) {
  double worst = 0.0;
  if (b->set == LCP_CONE) {
    return miss_of_cone(b, r, z, w, NULL).seen;
  }
  for (int i = b->start; i < b->start + b->size; i++) {
    worst = lcp_rho_worse(worst, miss_of_row(p, b->set, i, r, z, w, NULL).seen);
  }
  return worst;
}

bool lcp_data_allows(const lcp_problem *p, double tol, double size, const double *r,
                     const double *z, const double *w, const double *tau0) {
  const lcp_block whole = {.start = 0, .size = p->M.n, .set = LCP_ORTHANT};
  const lcp_block *block = (p->block != NULL) ? p->block : &whole;
  const int n_block = (p->block != NULL) ? p->n_block : 1;
  const double limit = lcp_data_limit(tol, size);
  for (int b = 0; b < n_block; b++) {
    const bool cone = block[b].set == LCP_CONE;
    for (int i = block[b].start; i < block[b].start + block[b].size;
         i += cone ? block[b].size : 1) {
      const miss m = cone ? miss_of_cone(&block[b], r, z, w, tau0)
                          : miss_of_row(p, block[b].set, i, r, z, w, tau0);
      if (!(m.noise <= 1e-6 * size && m.seen <= limit)) {
        return false;
      }
    }
  }
  return true;
}

bool lcp_data_met(const lcp_problem *p, double tol, const lcp_stop_state *s, const double *z,
                  double *r, double *tau0, lcp_work *work) {
  lcp_set_scaling(&p->M, s->d, r);
  lcp_rho_product(p, z, NULL, tau0);
  work->matvecs++;
  return lcp_data_allows(p, tol, lcp_data_size(p, r), r, z, s->w, tau0);
}
