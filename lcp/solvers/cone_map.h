/* cone_map.h - the complementarity of one block as equations F(x, y) = 0 with derivatives.
 *
 * x and y = w are scaled (x = z / s, y = s w, one s for all rows of a part), coefficients mu with them.
 *
 *   LCP_MAP_MIN      Alart & Curnier 1991:  F_n = x_n - max(0, p_n),
 *                    F_k = x_k - proj(p_k, |.| <= mu_k max(0, p_n)),  p = x - y
 *   LCP_MAP_FISCHER  Fukushima, Luo & Tseng 2002, on De Saxce's pair a = (mu x_n, x_t),
 *                    b = (y_n + mu |y_t|, mu y_t), both divided by sqrt(mu): a + b - (a^2 + b^2)^1/2 in
 *                    the algebra of the second-order cone. Cones of one part with mu > 0; others by LCP_MAP_MIN.
 *   interval rows    interval_map.h
 *
 * Of a folded problem (facet_fold.h) the disc of a part is a polygon; its cones take LCP_MAP_MIN always.
 *
 * Alart & Curnier's map is smooth while no row changes its mode: of an interval, the normal row of a cone (LOW: the contact
 * is open) and the first row of a part (LOW: nothing to carry with). */
#pragma once

#include "lcp/lcp_problem.h"
#include "lcp/solvers/cone_block.h"
#include "lcp/solvers/interval_map.h"

enum { LCP_MODE_LOW, LCP_MODE_HIGH, LCP_MODE_HELD, LCP_MODE_SLIP };

/* mode[b->size] at (x, y), from p = x - y; other rows of a part are LOW. */
void lcp_cone_modes(const lcp_block *b, double lo, double hi, const double *x, const double *y,
                    unsigned char *mode);

/* The smooth map of these modes: LOW x = lo, HIGH x = hi, HELD y = 0, SLIP as above whatever the sign of p_n (y = 0 where p_k = 0). X, Y as below. */
void lcp_cone_smooth(const lcp_block *b, double lo, double hi, const unsigned char *mode,
                     const double *x, const double *y, double *F, double *X, double *Y);

/* F[b->size] of block b, lo and hi read where it is an interval (of one row), and dF = X dx + Y dy, size x size,
 * column-major (X and Y may be NULL: F alone). facets[b->size]: corners of the part that begins in a row, NULL: all round. */
void lcp_cone_map(lcp_map map, const lcp_block *b, const int *facets, double lo, double hi,
                  const double *x, const double *y, double *F, double *X, double *Y);
