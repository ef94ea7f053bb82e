/* linear/direct.h - direct solution of  ( diag(a) + diag(r) M diag(c) )_SS x = b  for a set S of rows
 * and columns: dense by LU with partial pivoting (LAPACK), CSC by KLU.
 *
 * KLU's ordering and symbolic analysis are kept while the pattern stays what it was: one analysis serves all
 * steps of a Newton or interior-point run (S = all rows), and of pivoting steps with the same S.
 *
 * The dense form works in the arena only; KLU calls malloc, so a solver that uses this declares
 * `allocates` and calls lcp_direct_release. A matrix that is singular to working precision is
 * reported, never solved. */
#pragma once

#include "lcp/lcp_problem.h"

typedef struct lcp_direct {
  int n;         /* |S| */
  bool dense;    /* as M of the last factorisation */
  double *a;     /* dense: n*n, column-major; CSC: values */
  int *pivot;    /* dense: n; CSC: row indices */
  int *colptr;   /* CSC: n+1 */
  int *place;    /* cap n: place in S or -1 */
  int kept_n;    /* CSC: the pattern of KLU's symbolic analysis; 0: none */
  int *kept_ptr; /* n+1 */
  int *kept_row;
  long analyses; /* CSC: symbolic analyses since lcp_direct_begin */
  double *x;     /* cap n */
  void *library; /* KLU objects */
} lcp_direct;

void lcp_direct_layout(lcp_direct *s, const lcp_capacity *cap, base_arena *arena);

/* Once after layout and before the first factorisation of a solver's life (its prepare). */
void lcp_direct_begin(lcp_direct *s);

/* Factors for S = { i: member[i] } (NULL: all). a, r, c of length n (NULL: a = 0, r = c = 1). False:
 * singular to working precision (reciprocal condition below 1e-15 by the pivots). M: dense or CSC.
 * BASE_ENOMEM through *status. */
bool lcp_direct_factor(lcp_direct *s, const lcp_matrix *M, const unsigned char *member,
                       const double *a, const double *r, const double *c, base_status *status);

/* b[n of M] in, x in its place; entries outside S are left alone. */
void lcp_direct_solve(lcp_direct *s, int n, double *b);

void lcp_direct_release(lcp_direct *s); /* accepts what lcp_direct_begin left */
