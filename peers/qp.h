/* qp.h - a symmetric LCP as a convex quadratic programme, for the peers that solve one:
 *
 *   min 1/2 z'Mz + q'z   subject to   lo <= z <= hi
 *
 * With M symmetric and positive semidefinite its conditions of optimality are the LCP, w = Mz + q
 * being the multipliers of the bounds; hence every peer that includes this declares the needs
 * LCP_PLUGIN_SYMMETRIC and LCP_PLUGIN_PSD. */
#ifndef LCPBENCH_PEERS_QP_H
#define LCPBENCH_PEERS_QP_H

#include <lcpbench/lcp_plugin.h>
#include <math.h>
#include <stdlib.h>

/* One triangle of M by columns, diagonal included. */
typedef struct qp_triangle {
  int *colptr;  /* n+1 */
  int *rowind;  /* colptr[n], increasing inside a column */
  double *val;  /* colptr[n] */
  double *real; /* as many numbers as qp_bytes was asked for */
} qp_triangle;

typedef enum qp_side { QP_UPPER, QP_LOWER } qp_side;

/* Bytes of workspace for a triangle of a matrix with so many entries, and so many numbers more. */
static inline size_t qp_bytes(int n, size_t entries, size_t reals) {
  return (entries + reals) * sizeof(double) + (entries + (size_t)n + 1) * sizeof(int);
}

/* Copies a triangle of M, which is stored by columns, into workspace of qp_bytes(n, its entries,
 * reals). The numbers behind it are not cleared. */
static inline qp_triangle qp_take(void *work, const lcp_plugin_problem *p, qp_side side,
                                  size_t reals) {
  const size_t entries = (size_t)p->colptr[p->n];
  qp_triangle t;
  int count = 0;
  t.real = (double *)work;
  t.val = t.real + reals;
  t.rowind = (int *)(void *)(t.val + entries);
  t.colptr = t.rowind + entries;
  for (int j = 0; j < p->n; j++) {
    t.colptr[j] = count;
    for (int k = p->colptr[j]; k < p->colptr[j + 1]; k++) {
      if (side == QP_UPPER ? p->rowind[k] <= j : p->rowind[k] >= j) {
        t.rowind[count] = p->rowind[k];
        t.val[count++] = p->val[k];
      }
    }
  }
  t.colptr[p->n] = count;
  return t;
}

/* A bound in the words of a library that knows a number for infinity. */
static inline double qp_bound(double bound, double infinity) {
  return isinf(bound) ? copysign(infinity, bound) : bound;
}

/* The bounds of all rows so. */
static inline void qp_bounds(const lcp_plugin_problem *p, double infinity, double *lo, double *hi) {
  for (int i = 0; i < p->n; i++) {
    lo[i] = qp_bound(p->lo[i], infinity);
    hi[i] = qp_bound(p->hi[i], infinity);
  }
}

#endif
