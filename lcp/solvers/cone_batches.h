/* cone_batches.h - the sweep of cone_sweep.h over contacts of rigid bodies, matrix-free, four at a time.
 *
 * For J W J' with one cone of three rows (normal, two tangents) a contact: the local problem of contact_lanes.h's frame whose
 * tangents are the axes of the Schur complement S = A_tt - A_tn A_nt / A_nn, so that with w = A r + b
 *
 *   c = b_t - A_tn b_n / A_nn = w_t - g w_n - S r_t,   rho = -b_n / A_nn = r_n + g.r_t - w_n / A_nn,   g = A_tn / A_nn
 *   open   rho <= 0:  r = 0
 *   stick  r_t = -S^-1 c,  r_n = rho - g.r_t,  where |r_t| <= mu r_n
 *   slip   r_t(a) = -(S + a)^-1 c,  a > 0 with |r_t(a)| = mu r_n(a): Newton's method on r_n / |r_t| = 1 / mu, which is linear
 *          in a where S is a multiple of the identity; from the a of the last sweep. What does not get there goes to
 *          lcp_cone_solve (cone_block.h).
 *
 * Order: that of contact_batches.h. */
#pragma once

#include "lcp/lcp_solver.h"
#include "lcp/solvers/contact_batches.h"

typedef struct lcp_cone_batch lcp_cone_batch; /* four contacts, 1 kB */

typedef struct lcp_cone_batches {
  lcp_cone_batch *batch; /* in.n_batch */
  double *body;          /* lcp_contact_bodies */
  lcp_batches in;
  double *axis; /* 3 per contact: cosine and sine of the turn to the axes of S, handedness */
} lcp_cone_batches;

void lcp_cone_batches_layout(lcp_cone_batches *s, const lcp_capacity *cap, base_arena *a);

/* True where p has the form above, with S regular. */
bool lcp_cone_batches_prepare(lcp_cone_batches *s, const lcp_problem *p);

/* Sweeps z so many times; what comes depends on z alone. The friction is in the cone to the last bit. */
void lcp_cone_batches_run(lcp_cone_batches *s, const lcp_problem *p, double omega, long sweeps,
                          double *z);
