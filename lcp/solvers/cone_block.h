/* cone_block.h - exact Coulomb friction at one contact, solved to rounding.
 *
 *   r_n >= 0,  w_n >= 0,  r_n w_n = 0;   per part k (friction, torsion, rolling):
 *   |r_k| <= mu_k r_n,   w_k = 0 or ( |r_k| = mu_k r_n and w_k = -a_k r_k, a_k > 0 )
 *
 * with w = A r + b, which is w + (sum mu_k |w_k|) e_n in K* (De Saxce & Feng 1998). A positive
 * definite. */
#pragma once

#include "lcp/lcp_problem.h"

enum { LCP_CONE_MAX = 1 + 2 * LCP_PARTS_MAX }; /* rows of one block; a part has one or two */

/* Solves the block into r[k->size]; A column-major. One part: take-off, stick, else the sliding
 * branch r(a) = stick of A + diag(0, a, a) has |r_t(a)| - mu r_n(a) > 0 at a = 0 and < 0 for large a,
 * so a root exists and is bracketed (the scalar form of Bonnefon & Daviet 2011, quartic there). More
 * parts: Newton's method (cone_parts.h). Where that does not end, the normal impulse by bracketing on w_n, inside it the convex disc
 * problems by block coordinate descent. */
void lcp_cone_solve(const lcp_block *k, const double *A, const double *b, double *r);

/* The same by brackets, for several parts and b[0] < 0. */
void lcp_cone_solve_by_brackets(const lcp_block *k, const double *A, const double *b, double *r);
