/* lcp/share/lcp_share.h - one answer where the problem has many: impulses of redundant rows as equal springs share them.
 *
 * Rigid bodies on more contacts than degrees of freedom leave the normal impulses undetermined, and with sliding
 * friction the motion follows them. Blocks with compliance c_i > 0 (`soft` in lcp_block, the block's first row)
 * ask for the limit
 *
 *   z = lim z(eps),   z(eps) solves  w = (M + eps C) z + q,   C = diag(c_i), zero elsewhere        (eps -> 0)
 *
 * which is the answer of rigid bodies on ever stiffer springs (MATHEMATICS 2.8). It is made from a solver's answer z in
 * three steps, and it solves the problem with eps = 0 to rounding:
 *
 *   1. the normal rows that touch are factored, with the free ones of joints; without a zero pivot that the free ones do
 *      not have by themselves z is unique and is left alone, bit for bit;
 *   2. the active rows of M + delta C are found by pivoting in blocks from those of the last step's choice or of z (cones: by
 *      Newton's method), delta = 1e-7 of the diagonal;
 *   3. with their factor, z <- (M + delta C)^-1 (-q + delta C z) is repeated until delta C z no longer moves. From zero
 *      this proximal iteration never leaves the C-orthogonal complement of what M does not see, so that it ends in
 *      the limit and not near it. Its roundings do leave it, by 1e-16 over delta: they are projected out.
 *
 * Of M = J W J' + S in factors all three are done in the body velocities (lcp_share_bodies.h): nothing grows with the square
 * of the contacts, and the rank is counted, not guessed from pivots: not again while the same contacts touch and the last choice is at
 * hand. Of more than 2000 contacts it is not counted: the choice is made from the contacts that carry, and z is unique where the
 * choice is z to 1e-8.
 *
 * Where active rows are not found, or the result does not solve the problem, z stays as it was and the outcome is
 * LCP_SHARE_MISSED. */
#pragma once

#include "lcp/lcp_problem.h"

typedef enum lcp_share_outcome {
  LCP_SHARE_UNIQUE, /* nothing to choose */
  LCP_SHARE_MADE,   /* z is the limit */
  LCP_SHARE_MISSED, /* z is the solver's */
} lcp_share_outcome;

enum { LCP_SHARE_UNCOUNTED = -1 };

typedef struct lcp_share_result {
  lcp_share_outcome outcome;
  int deficit; /* touching normal rows less their rank, or LCP_SHARE_UNCOUNTED; with `start` that of the last count while the same
                  contacts touch */
  int rounds;  /* changes of active rows, Newton steps of cones included */
  long factorizations, backsolves;
} lcp_share_result;

typedef struct lcp_share lcp_share; /* opaque: owns the workspace, reusable step after step */

base_status lcp_share_open(lcp_share **out, base_error *err);
void lcp_share_close(lcp_share *s); /* accepts NULL */

/* Gives the workspace back, but for orders of elimination, until the next apply. */
void lcp_share_rest(lcp_share *s);

/* z[n], an answer of p, in; the chosen answer out. start[n]: what the last step chose, unknown by unknown, whose active rows are
 * tried first; NULL: nothing is taken from earlier calls. BASE_ENOMEM only. */
base_status lcp_share_apply(lcp_share *s, const lcp_problem *p, const double *start, double *z,
                            lcp_share_result *out, base_error *err);
