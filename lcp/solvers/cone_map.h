/* cone_map.h - the complementarity of one block as equations F(x, y) = 0 with derivatives.
 *
 * x and y = w are scaled (x = z / s, y = s w, one s for all rows of a part), coefficients mu with them.
 *
 *   LCP_MAP_MIN      Alart & Curnier 1991:  F_n = x_n - max(0, p_n),
 *                    F_k = x_k - proj(p_k, |.| <= mu_k max(0, p_n)),  p = x - y
 *   LCP_MAP_FISCHER  Fukushima, Luo & Tseng 2002, on De Saxce's pair a = (mu x_n, x_t),
 *                    b = (y_n + mu |y_t|, mu y_t), both divided by sqrt(mu): a + b - (a^2 + b^2)^1/2 in
 *                    the algebra of the second-order cone. Cones of one part with mu > 0; others by LCP_MAP_MIN.
 *   interval rows    interval_map.h */
#pragma once

#include "lcp/lcp_problem.h"
#include "lcp/solvers/cone_block.h"
#include "lcp/solvers/interval_map.h"

/* F[b->size] of block b, lo and hi read where it is an interval (of one row), and dF = X dx + Y dy, size x size,
 * column-major (X and Y may be NULL: F alone). */
void lcp_cone_map(lcp_map map, const lcp_block *b, double lo, double hi, const double *x,
                  const double *y, double *F, double *X, double *Y);
