/* facet_fold.h - friction over facets as friction over a polygon: fewer unknowns, the same law.
 *
 * A block of a polyhedral problem is (n, beta_1 .. beta_f, sigma) a part, in the rows
 *
 *   w_beta_k = d_k'u + c sigma,    w_sigma = a n - b sum beta_k,    d_k = (cos 2 pi k/f, sin 2 pi k/f)
 *
 * (Stewart & Trinkle 1996). Its conditions say that t = sum beta_k d_k is the point of the polygon with corners (a/b) n d_k
 * that works most against u, so that (n, t) with rows (u_n, u) hold all of it: a cone with a polygon for its disc. From
 * these beta is t by the two corners beside it, and sigma = max_k(-d_k'u, 0)/c. Two facets are an interval, of one row.
 *
 * Folds matrices in factors whose S holds nothing else in those rows and whose facets are the regular ones; other blocks,
 * and S of normal rows, stay as they are. */
#pragma once

#include "lcp/lcp_problem.h"

typedef struct lcp_fold {
  bool done; /* the last begin folded something */
  lcp_problem
      p; /* the folded problem; views of the arrays below and of the factors it is made from */
  lcp_factored factored;
  lcp_csc shift;
  lcp_block *block; /* n_block */
  int *facets;      /* n, folded rows: facets of the part that begins there, 0 elsewhere */
  const lcp_problem *of;
  int *row_start;              /* n+1, as all of them of the folded problem */
  int *jac_start;              /* n+1 */
  double *jac;                 /* n_jac_folded; unused where J has the rows of the cones already */
  const lcp_mixture **mixture; /* n_block: of rows that stay what they are there, */
  bool mixed;                  /* some are mixed */
  double *q, *lo, *hi;         /* n */
  double *unit;                /* n, folded rows: c of the part that begins there */
  int *colptr, *rowind;        /* n+1, nnz: S */
  double *val;
} lcp_fold;

void lcp_fold_layout(lcp_fold *s, const lcp_capacity *cap, base_arena *a);

/* Folds p; s->done tells whether there was anything to fold that can be. p stays where it is while s is used. */
void lcp_fold_begin(lcp_fold *s, const lcp_problem *p);

/* x (folded) from z, and back: z from x and w = M x + q of the folded problem. x_n below zero counts as zero. unit: scale of
 * x, n entries; sigma is zero where t - unit^2 u is inside the polygon, for there the contact sticks, and u is the error of
 * that. A sigma of rounding beside a row w_sigma that is not zero would be an error of its own. */
void lcp_fold_in(const lcp_fold *s, const double *z, double *x);
void lcp_fold_out(const lcp_fold *s, const double *x, const double *w, const double *unit,
                  double *z);

/* z = x in the normal rows and those that were not folded, zero in facets and sigmas. */
void lcp_fold_out_rows(const lcp_fold *s, const double *x, double *z);

/* The point of the regular polygon of f corners radius d_k nearest to v, 2 entries each; its derivatives by v (2 x 2) and by
 * the radius (2). Returns whether v is inside; then `to` is v. */
bool lcp_polygon_project(int f, double radius, const double *v, double *to, double *by_v,
                         double *by_radius);
