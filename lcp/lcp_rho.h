/* lcp/lcp_rho.h - rho of lcp_judge.h as the solvers compute it, in double: products, scales, terms of rows.
 *
 * One home for every stopping test. The judge has a copy of its own in long double, on purpose: a solver and
 * its judge that shared this arithmetic would agree on a wrong scale or a wrong sign, and no row of a result
 * could show it. */
#pragma once

#include "lcp/lcp_column.h"

#include <float.h>

/* x / scale; where the scale is zero, or has overflowed, which it does before z and w do, nothing but zero can stand above
 * it. */
static inline double lcp_rho_over(double x, double scale) {
  if (scale > 0.0 && scale <= DBL_MAX) {
    return x / scale;
  }
  return (x == 0.0) ? 0.0 : copysign(HUGE_VAL, x);
}

/* The smaller and the larger of x and a bound, which is a number; NaN where x is NaN. */
static inline double lcp_rho_below(double x, double bound) {
  return (x > bound) ? bound : x;
}
static inline double lcp_rho_above(double x, double bound) {
  return (x < bound) ? bound : x;
}

/* The term of one row of an orthant, a box [lo, hi] or a free row, from z, w = (M z + q)_i and their scales.
 * lo and hi are read for boxes only. Not a number where z or w is none: w of a z so large that it overflows. */
static inline double lcp_rho_row(lcp_set set, double z, double w, double lo, double hi, double zref,
                                 double tau) {
  const double x = lcp_rho_over(z, zref), y = (w == w) ? lcp_rho_over(w, tau) : w;
  if (set == LCP_FREE) {
    return fabs(y);
  }
  if (set == LCP_BOX) {
    const double low = lcp_rho_over(lo, zref), high = lcp_rho_over(hi, zref);
    return fabs(x - lcp_rho_below(lcp_rho_above(x - y, low), high));
  }
  return fabs((x < y || x != x) ? x : y);
}

/* The larger of two residuals. fmax would drop NaN; a residual must not. */
static inline double lcp_rho_worse(double worst, double r) {
  return (r > worst || r != r) ? r : worst;
}

/* size_i = |q_i| + sum_j |M_ij||x_j|, which is tau0 at x = z and tau at x = zref, and w = q + M x unless w is
 * NULL; of the factored form with S alone in the place of M. One pass over what is stored. */
void lcp_rho_product(const lcp_problem *p, const double *x, double *w, double *size);

/* zref_i of one unknown from its tau0_i and diagonal entry d: tau0_i / |d|; where d = 0 the largest tau0_j / |M_ji|
 * of its column, 1 where that is zero. */
static inline double lcp_rho_reference(double d, double own, lcp_column column,
                                       const double *tau0) {
  if (d != 0.0) {
    return own / fabs(d);
  }
  double ref = 0.0;
  bool empty = true;
  for (int k = 0; k < column.count; k++) {
    if (column.val[k] != 0.0) {
      ref = fmax(ref, tau0[lcp_column_row(&column, k)] / fabs(column.val[k]));
      empty = false;
    }
  }
  return empty ? 1.0 : ref;
}

/* zref of all unknowns from tau0 and the diagonal d of M. (A zero diagonal of the factored form means a zero row of
 * J: its column is that of S.) zref must not alias tau0. */
void lcp_rho_references(const lcp_problem *p, const double *d, const double *tau0, double *zref);

/* max over the blocks at z, w = M z + q, with zref and tau as they stand; NaN where a term is. */
double lcp_rho(const lcp_problem *p, const double *d, const double *z, const double *w,
               const double *zref, const double *tau);

/* Is it at most tol? Ends at the first block that is not. */
bool lcp_rho_within(const lcp_problem *p, double tol, const double *d, const double *z,
                    const double *w, const double *zref, const double *tau);

/* above[i] (n): the term of row i's block is not within tol. */
void lcp_rho_above_tol(const lcp_problem *p, double tol, const double *d, const double *z,
                       const double *w, const double *zref, const double *tau,
                       unsigned char *above);
