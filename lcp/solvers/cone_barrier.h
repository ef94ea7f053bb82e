/* cone_barrier.h - the complementarity of a problem over cones and intervals as pairs of points inside their cones.
 *
 * In the scaled variables x, y of cone_scaled.h a pair (a, b) obeys a o b = tau e on the central path, in the algebra of the
 * half-line or of the second-order cone; tau -> 0 is the problem:
 *
 *   interval    (x - lo, y) and (hi - x, t), of the bounds that are finite; y - t is the velocity of the row
 *   cone        of part k: ((mu_k x_n, x_k), (t_k, y_k)), with an unknown slip speed t_k, and of the normal row
 *     LCP_LAW_COULOMB    (x_n, y_n): Coulomb's law as it is told (Kanno, Martins & Pinto da Costa 2006)
 *     LCP_LAW_DE_SAXCE   y_n = sum mu_k (t_k - |y_k|): De Saxce's change of variable y_n + sum mu_k |y_k|, which the t_k
 *                        add up to, with |y_k| inside the Newton system
 *     With mu_k = 0 everywhere the two are one, and x_k = 0.
 *
 * Linearised with their scaling (Nesterov & Todd 1998), W a = W^-1 b, H = W^2: a pair gives db = g - H da, so that of every row
 *
 *   dy = g - X dx,     X block diagonal, one block a piece. */
#pragma once

#include "lcp/solvers/cone_scaled.h"

typedef enum lcp_law { LCP_LAW_DE_SAXCE, LCP_LAW_COULOMB } lcp_law;

/* W of one part: root [w0 w1'; w1 I + w1 w1'/(1 + w0)], H = root^2 (2 w w' - J). */
typedef struct lcp_nt {
  double root, w[3];
} lcp_nt;

typedef struct lcp_barrier {
  lcp_law law;
  int pairs;
  double point;  /* an interval of this length is one */
  double *x, *y; /* n */
  double *t;     /* n: of a part at its first row; of an upper bound */
  double *dx, *dy, *dt;
  double *g, *gt; /* n: dy = g - X dx, and the same of t */
  double *r;      /* n: s (M z + q) - y */
  lcp_nt *nt;     /* n: of a part at its first row */
} lcp_barrier;

void lcp_barrier_layout(lcp_barrier *b, const lcp_capacity *cap, base_arena *a);

/* A point inside, of this size. */
void lcp_barrier_start(lcp_barrier *b, const lcp_cone_scaled *c, lcp_law law, double size);

/* r = w - y of every row, w scaled; returns the largest |r|. */
double lcp_barrier_residual(lcp_barrier *b, const lcp_cone_scaled *c, const double *w);

/* The mean product of the pairs after a step t; 0 without pairs. */
double lcp_barrier_gap(const lcp_barrier *b, const lcp_cone_scaled *c, double step);

/* X and Y of the step at this point, the scalings. Rows of a piece are divided by the largest of its X, and Y with them. */
void lcp_barrier_linearise(lcp_barrier *b, lcp_cone_scaled *c);

/* g for pairs of product tau, c->F = Y (r - g); `corrected`: less the product of the directions that stand in dx, dy, dt
 * (Mehrotra 1992). */
void lcp_barrier_target(lcp_barrier *b, lcp_cone_scaled *c, double tau, bool corrected);

/* dy, dt of dx. */
void lcp_barrier_directions(lcp_barrier *b, const lcp_cone_scaled *c);

/* The longest step that keeps every pair in its cones, HUGE_VAL without bound. */
double lcp_barrier_longest(const lcp_barrier *b, const lcp_cone_scaled *c);

void lcp_barrier_move(lcp_barrier *b, int n, double step);
