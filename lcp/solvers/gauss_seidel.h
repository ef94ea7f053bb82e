/* gauss_seidel.h - one projected Gauss-Seidel sweep, point by point or contact by contact.
 *
 *   point   z_i <- P_i( z_i - omega w_i / M_ii )                             M_ii > 0
 *   block   z_b <- z_b + omega (x - z_b),  x solves the LCP (M_bb, w_b - M_bb z_b)
 *
 * with w = M z + q current at every change. A block is solved as a whole where it has a zero on its
 * diagonal (sigma of the polyhedral contact LCP). */
#pragma once

#include "lcp/lcp_solver.h"
#include "lcp/solvers/lemke/block.h"
#include "lcp/solvers/sweep.h"

typedef struct lcp_gs {
  lcp_sweep sweep;
  double *lo, *hi;       /* n */
  unsigned char *whole;  /* n_block: solved block by block */
  double *Mbb, *qb, *xb; /* of one block */
  double *kept;          /* M_bb of small blocks, LEMKE_KEPT_MAX a row */
  double *inverse;       /* as long: what lemke_block_stays keeps of them */
  lemke_kept *basis;     /* n_block */
  lemke_block lemke;     /* solves it */
  bool by_block;         /* some block is solved as a whole */
} lcp_gs;

void lcp_gs_layout(lcp_gs *s, const lcp_capacity *cap, base_arena *a);

/* BASE_EUNSUPPORTED for a negative diagonal, and for a zero diagonal outside orthant blocks of 2 to
 * LEMKE_BLOCK_MAX rows. */
base_status lcp_gs_prepare(lcp_gs *s, const lcp_problem *p, base_error *err);

/* Clips z into K and makes w current; counts the product. */
void lcp_gs_start(lcp_gs *s, const lcp_problem *p, double *z, lcp_work *work);

/* One sweep in the order of the unknowns. A block whose LCP ends on a ray keeps its z and is counted
 * in work.fallbacks. */
void lcp_gs_sweep(lcp_gs *s, const lcp_problem *p, double omega, double *z, lcp_result *res);
