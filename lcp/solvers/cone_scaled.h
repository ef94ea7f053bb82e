/* cone_scaled.h - a problem over cones and intervals in scaled variables, as nonsmooth equations.
 *
 *   x_i = z_i / s_i,  y_i = s_i w_i,   s_i = 1/sqrt(mean M_jj over the rows j of the part)
 *
 * so every unit drops out, M becomes s M s with mean diagonal 1 and mu_k becomes mu_k s_n / s_k. Blocks
 * that are no cones fall into pieces of one row. */
#pragma once

#include "lcp/solvers/cone_map.h"

typedef struct lcp_cone_scaled {
  lcp_block *piece; /* n_piece in order, cones with scaled mu */
  int n_piece;
  const int *facets; /* n: as of lcp_cone_map, or NULL */
  double *s;         /* n */
  double *lo, *hi;   /* n, in x; read where a piece is an interval */
  double *F;         /* n */
  int wide;          /* rows of the largest piece */
  double *X,
      *Y; /* size^2 a piece, at lcp_cone_scaled_at; the one behind the other, which each map with a slope fills anew */
} lcp_cone_scaled;

/* Where X and Y of a piece begin: side by side where all pieces are of one size, so that no memory between them is touched. */
static inline size_t lcp_cone_scaled_at(const lcp_cone_scaled *c, const lcp_block *piece) {
  return (size_t)piece->start * (size_t)c->wide;
}

void lcp_cone_scaled_layout(lcp_cone_scaled *c, const lcp_capacity *cap, base_arena *a);

/* d: diagonal of M; facets: n, borrowed, or NULL. BASE_EUNSUPPORTED: a cone of more than LCP_CONE_MAX rows, or with a diagonal that is not
 * positive. */
base_status lcp_cone_scaled_begin(lcp_cone_scaled *c, const lcp_problem *p, const double *d,
                                  const int *facets, base_error *err);

/* F at (x, y), with `slope` also X and Y; returns |F|^2. */
double lcp_cone_scaled_map(lcp_cone_scaled *c, lcp_map map, const double *x, const double *y,
                           bool slope);

/* to = the point of K nearest to z in x, cones as they are; both in the units of z. */
void lcp_cone_scaled_project(const lcp_cone_scaled *c, const double *z, double *to);
