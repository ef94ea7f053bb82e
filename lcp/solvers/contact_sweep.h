/* contact_sweep.h - the matrix-free Gauss-Seidel sweep for frictional contacts, four at a time.
 *
 * For J W J' with three rows a contact (a normal impulse >= 0, two friction impulses in symmetric
 * boxes) and rigid bodies W = diag(I/m, inertia^-1). Everything is mass-weighted: with W = L L', body
 * velocities are kept as u = L^-1 v and rows are divided by the root of their diagonal, so that
 *
 *   w = q + t.(s_a u_a - s_b u_b) + g_a.o_a + g_b.o_b,   x = clip(z - omega w),
 *   u_a += s_a t (x - z),  u_b -= s_b t (x - z),  o_a += g_a (x - z),  o_b += g_b (x - z)
 *
 * with t the scaled direction of the row (3), g the scaled angular rows (3 + 3), s = 1/sqrt(m): 288
 * bytes a contact, read once per sweep, and one cache line a body.
 *
 * Order: contacts are gathered greedily, in the order given, into batches of four that share no moving
 * body (a colouring with a window of 64 open batches, repeated on what is left over); full batches
 * are swept first, in order, all four contacts at once; the rest follows one by one. Since contacts
 * of one batch do not touch each other, the iterates are those of a plain sweep in that order
 * (lcp_contact_sweep_order), up to the rounding of the scaling. */
#pragma once

#include "lcp/lcp_solver.h"
#include "lcp/solvers/gauss_seidel.h"

enum { LCP_LANES = 4 };

typedef struct lcp_contact_batch lcp_contact_batch; /* four contacts, 1152 bytes */

typedef struct lcp_contact_sweep {
  lcp_contact_batch *batch; /* n_batch; of four contacts each, the last may have fewer */
  double *body;             /* 8 per body: u (3), s, o (3), 0; one more for what is fixed */
  int *order;               /* contact swept in place k */
  int *left, *next_left;    /* n_contact, of the colouring */
  unsigned long long *open; /* n_body, batches that touch the body, while colouring */
  double *root;             /* n, square roots of the diagonal */
  int n_contact, n_full;    /* contacts; batches without a shared body */
} lcp_contact_sweep;

void lcp_contact_sweep_layout(lcp_contact_sweep *s, const lcp_capacity *cap, base_arena *a);

/* True where p has the form above. gs is prepared for p (G, diagonal, bounds). Builds everything. */
bool lcp_contact_sweep_prepare(lcp_contact_sweep *s, const lcp_gs *gs, const lcp_problem *p);

void lcp_contact_sweep_import(lcp_contact_sweep *s, const lcp_problem *p, const double *z);
void lcp_contact_sweep_run(lcp_contact_sweep *s, double omega, int sweeps);
void lcp_contact_sweep_export(const lcp_contact_sweep *s, const lcp_problem *p, double *z);

/* The contact (group) swept in place k. */
static inline int lcp_contact_sweep_order(const lcp_contact_sweep *s, int k) {
  return s->order[k];
}
