/* lcp/lcp_mixture.h - the rows of J of a matrix in factors, as they are stored or mixed of those that are, for solvers and what stands
 * below them. The judge mixes for itself (lcp_wide_column.c). */
#pragma once

#include "lcp/base/clones.h"
#include "lcp/lcp_problem.h"

/* out = sum of c_k times row k of n. Products with zeros too: they change nothing and cost less than to ask. */
BASE_INLINE void lcp_mix(const double *c, int n, int dof, const double *restrict stored,
                         double *restrict out) {
  for (int d = 0; d < dof; d++) {
    out[d] = 0.0;
  }
  for (int k = 0; k < n; k++) {
    for (int d = 0; d < dof; d++) {
      out[d] += c[k] * stored[k * dof + d];
    }
  }
}

/* Row i of one side, `dof` numbers, from those stored; all of them. A contact of bodies in space as constants. */
BASE_INLINE void lcp_mixture_row(const lcp_mixture *m, int i, int dof, const double *stored,
                                 double *out) {
  const double *c = m->c + (ptrdiff_t)i * m->stored;
  if (dof == 6 && m->stored == 3) {
    lcp_mix(c, 3, 6, stored, out);
  } else {
    lcp_mix(c, m->stored, dof, stored, out);
  }
}

BASE_INLINE void lcp_mixture_side(const lcp_mixture *m, int dof, const double *stored,
                                  double *out) {
  for (int i = 0; i < m->rows; i++) {
    lcp_mixture_row(m, i, dof, stored, out + (ptrdiff_t)dof * i);
  }
}

/* out += c_k x over the n stored rows k, */
BASE_INLINE void lcp_mixture_add(const double *c, int n, double x, double *out) {
  for (int k = 0; k < n; k++) {
    out[k] += c[k] * x;
  }
}

/* and what row c of a mixture has of them. */
BASE_INLINE double lcp_mixture_dot(const double *c, int n, const double *stored) {
  double sum = 0.0;
  for (int k = 0; k < n; k++) {
    sum += c[k] * stored[k];
  }
  return sum;
}

/* What the stored rows have in all of x, which is by row of the group, and y += what the rows have of them. Three stored rows, those of
 * a contact in space, as a constant. */
BASE_INLINE void lcp_mixture_gather(const lcp_mixture *m, const double *x,
                                    double out[LCP_STORED_MAX]) {
  const double *c = m->c;
  double sum[LCP_STORED_MAX] = {0};
  if (m->stored == 3) {
    for (int i = 0; i < m->rows; i++, c += 3) {
      lcp_mixture_add(c, 3, x[i], sum);
    }
  } else {
    for (int i = 0; i < m->rows; i++, c += m->stored) {
      lcp_mixture_add(c, m->stored, x[i], sum);
    }
  }
  for (int k = 0; k < LCP_STORED_MAX; k++) {
    out[k] = sum[k];
  }
}

BASE_INLINE void lcp_mixture_spread(const lcp_mixture *m, const double *stored, double *y) {
  const double *c = m->c;
  if (m->stored == 3) {
    for (int i = 0; i < m->rows; i++, c += 3) {
      y[i] += lcp_mixture_dot(c, 3, stored);
    }
  } else {
    for (int i = 0; i < m->rows; i++, c += m->stored) {
      y[i] += lcp_mixture_dot(c, m->stored, stored);
    }
  }
}

/* The rows of J of group g, rows x dofs of side 0 (row-major), then of side 1: a view, or made in `room`. */
BASE_INLINE const double *lcp_factored_rows(const lcp_factored *f, int g,
                                            double room[LCP_MIXED_MAX]) {
  const lcp_mixture *m = lcp_mixture_of(f, g);
  const double *from = f->jac + lcp_factored_at(f, g);
  if (m == NULL) {
    return from;
  }
  double *to = room;
  for (int side = 0; side < 2; side++) {
    const int dof = lcp_factored_dof(f, g, side);
    if (dof > 0) {
      lcp_mixture_side(m, dof, from, to);
    }
    from += (ptrdiff_t)m->stored * dof;
    to += (ptrdiff_t)m->rows * dof;
  }
  return room;
}
