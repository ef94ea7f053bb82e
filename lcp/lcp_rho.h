/* lcp/lcp_rho.h - rho of lcp_judge.h as the solvers compute it, in double: products, scales, terms of rows.
 *
 * One home for every stopping test. The judge has a copy of its own in long double, on purpose: a solver and
 * its judge that shared this arithmetic would agree on a wrong scale or a wrong sign, and no row of a result
 * could show it. */
#pragma once

#include "lcp/lcp_problem.h"

/* x / scale; where the scale is zero nothing but zero can stand above it. */
static inline double lcp_rho_over(double x, double scale) {
  if (scale > 0.0) {
    return x / scale;
  }
  return (x == 0.0) ? 0.0 : copysign(HUGE_VAL, x);
}

/* The term of one row of an orthant, a box [lo, hi] or a free row, from z, w = (M z + q)_i and their scales.
 * lo and hi are read for boxes only. */
static inline double lcp_rho_row(lcp_set set, double z, double w, double lo, double hi, double zref,
                                 double tau) {
  const double x = lcp_rho_over(z, zref), y = lcp_rho_over(w, tau);
  if (set == LCP_FREE) {
    return fabs(y);
  }
  if (set == LCP_BOX) {
    return fabs(x - fmin(fmax(x - y, lcp_rho_over(lo, zref)), lcp_rho_over(hi, zref)));
  }
  return fabs(fmin(x, y));
}

/* The larger of two residuals. fmax would drop NaN; a residual must not. */
static inline double lcp_rho_worse(double worst, double r) {
  return (r > worst || r != r) ? r : worst;
}

/* size_i = |q_i| + sum_j |M_ij||x_j|, which is tau0 at x = z and tau at x = zref, and w = q + M x unless w is
 * NULL; of the factored form with S alone in the place of M. One pass over what is stored. */
void lcp_rho_product(const lcp_problem *p, const double *x, double *w, double *size);

/* zref from tau0 and the diagonal d of M: tau0_i / |d_i|; where d_i = 0 the largest tau0_j / |M_ji| of the
 * column, 1 where it is zero. (A zero diagonal of the factored form means a zero row of J: its column is that
 * of S.) zref must not alias tau0. */
void lcp_rho_references(const lcp_problem *p, const double *d, const double *tau0, double *zref);

/* max over the blocks at z, w = M z + q, with zref and tau as they stand; NaN where a term is. */
double lcp_rho(const lcp_problem *p, const double *d, const double *z, const double *w,
               const double *zref, const double *tau);
