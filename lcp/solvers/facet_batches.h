/* facet_batches.h - the block sweep of gauss_seidel.h over contacts with faceted friction, matrix-free, four at a time.
 *
 * A block is (normal, K facets f_k = (c_k, s_k) in the tangent plane, slip speed sigma): with p = (z_n, sum f_k z_k) the impulse,
 * w = A p + b the velocity at the contact and alpha the unit of sigma,
 *
 *   z_n >= 0  _|_  w_n >= 0,   z_k >= 0  _|_  f_k.w_t + alpha sigma >= 0,   sigma >= 0  _|_  alpha (mu z_n - sum z_k) >= 0
 *
 * In a basis all 2 + K basic values and slacks are linear in b, three numbers each, which are kept from sweep to sweep: a contact
 * stays in its basis where no value is negative, and no slack by more than rounding. Elsewhere it is open (b_n >= 0, sigma the largest approach to
 * a facet) or solved by Lemke's path (lemke/block.h), whose last basis is kept then.
 *
 * Order: that of contact_batches.h. No relaxation. */
#pragma once

#include "lcp/solvers/contact_batches.h"
#include "lcp/solvers/facet_batches_kernel.h"
#include "lcp/solvers/gauss_seidel.h"

typedef struct lcp_facet_batches {
  lcp_facet_lanes lanes;
  lcp_batches in;
  double *sigma; /* 2 per contact: alpha, alpha mu */
  double *M;     /* of one block, LEMKE_KEPT_MAX squared, as its inverse */
  double *inverse;
  lemke_block *lemke; /* of the sweep it was prepared from */
  long rays;          /* blocks that Lemke's path did not solve, in the last run */
} lcp_facet_batches;

void lcp_facet_batches_layout(lcp_facet_batches *s, const lcp_capacity *cap, base_arena *a);

/* True where p has the form above, with the same facets at every contact. gs is prepared for p and lends its path. */
bool lcp_facet_batches_prepare(lcp_facet_batches *s, lcp_gs *gs, const lcp_problem *p);

/* Sweeps z >= 0 so many times; what comes depends on z alone. A block whose LCP ends on a ray keeps its z and is counted
 * in s->rays. */
void lcp_facet_batches_run(lcp_facet_batches *s, const lcp_problem *p, long sweeps, double *z);
