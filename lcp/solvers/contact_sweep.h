/* contact_sweep.h - the matrix-free Gauss-Seidel sweep for frictional contacts, four at a time.
 *
 * For J W J' with three rows a contact (a normal impulse >= 0, two friction impulses in symmetric
 * boxes) between rigid bodies, W = diag(I/m, inertia^-1), rows J = (d_k, r_a x d_k, -d_k, -r_b x d_k)
 * with an orthonormal frame d_k. Rows are divided by the root of their diagonal (t = d / sqrt(M_ii),
 * x = z sqrt(M_ii)), and a contact is swept through the relative velocity of its point:
 *
 *   y = v_a + o_a x r_a - v_b - o_b x r_b
 *   w_k = q_k + t_k.y + sum_j<k A_kj dx_j,   x_k <- clip(x_k - omega w_k),   k = 0, 1, 2
 *   p = sum t_k dx_k,   v_a += p / m_a,   o_a += inertia_a^-1 (r_a x p),   b likewise with -p
 *
 * with A the scaled 3 x 3 block of M. Stored: two directions, two arms, three entries of A, q, x and
 * bounds, 200 bytes a contact, read once per sweep, and two cache lines a body.
 *
 * Order: that of contact_batches.h. The iterates are those of a plain sweep in that order, up to the rounding of the
 * scaling. */
#pragma once

#include "lcp/lcp_solver.h"
#include "lcp/solvers/contact_batches.h"
#include "lcp/solvers/gauss_seidel.h"

typedef struct lcp_contact_batch lcp_contact_batch; /* four contacts, 800 bytes */

typedef struct lcp_contact_sweep {
  lcp_contact_batch *batch; /* as many as contacts, for the longest chain */
  double *body;             /* lcp_contact_bodies */
  lcp_batches in;
  double *root; /* n, square roots of the diagonal */
} lcp_contact_sweep;

void lcp_contact_sweep_layout(lcp_contact_sweep *s, const lcp_capacity *cap, base_arena *a);

/* True where p has the form above, to rounding. gs is prepared for p (diagonal, bounds). */
bool lcp_contact_sweep_prepare(lcp_contact_sweep *s, const lcp_gs *gs, const lcp_problem *p);

void lcp_contact_sweep_import(lcp_contact_sweep *s, const lcp_problem *p, const double *z);
void lcp_contact_sweep_run(lcp_contact_sweep *s, double omega, int sweeps);
void lcp_contact_sweep_export(const lcp_contact_sweep *s, const lcp_problem *p, double *z);
