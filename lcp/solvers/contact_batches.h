/* contact_batches.h - contacts of rigid bodies in batches of four that share no moving body, and what a sweep in lanes
 * needs to know of J W J': frames, arms, masses.
 *
 * Order: nearly that of the contacts as given. A contact goes into a batch as soon as the one before it of either body is in
 * an earlier one (Kahn's order, within a window). Where fewer than four can go, the next contacts that share no body with the
 * batch join it out of turn: few in a pile, most in a tower. The iterates are those of a plain sweep in that order. */
#pragma once

#include "lcp/lcp_problem.h"
#include "lcp/solvers/contact_lanes.h"

enum { LCP_STRETCH = 16 }; /* batches that one thread sweeps before it says so (batch_waves.h) */

typedef struct lcp_batches {
  int *order;          /* contact in place k, lane k % 4 of its batch; -1 where the lane is idle */
  int *last;           /* bodies: the contact that touches it last, of those met */
  int *before, *after; /* 2 a contact: its neighbours among the contacts of either body, -1 */
  int *waits;          /* contacts: for how many others, of two */
  int *ready;          /* contacts that wait for none, in the order in which they are taken */
  int n_contact, n_batch;
  bool shared; /* ordered by a thread with a crew: */
  int *until;  /* stretches: the last one with a contact at a body of this one */
} lcp_batches;

/* Rows of one frame: orthonormal directions, and arms from the bodies to the point. */
typedef struct lcp_contact_frame {
  double d[3][3], arm[2][3];
  double hand; /* of the frame: d_2 = hand d_0 x d_1 */
} lcp_contact_frame;

void lcp_batches_layout(lcp_batches *s, size_t contacts, size_t bodies, base_arena *a);

/* Bodies of lcp_contact_bodies: those that move, and for every stretch one that is fixed, so that no two threads write to one. */
size_t lcp_batches_bodies(size_t contacts, size_t bodies);

void lcp_batches_order(lcp_batches *s, const lcp_factored *f);

/* Every contact has one place, and no batch has two of one body. Writes to waits. */
bool lcp_batches_are_partitioned(lcp_batches *s, const lcp_factored *f);

/* True where every W is diag(I/m, inertia^-1) of six velocities. */
bool lcp_contact_rigid(const lcp_factored *f);

/* rows[side]: 3 x 6, (sign d_k, sign r x d_k), NULL where that side is fixed. False where they are not of that form, to
 * rounding. */
bool lcp_contact_frame_of(const double *const rows[2], lcp_contact_frame *out);

/* The same of a group of three rows. */
bool lcp_contact_frame_of_group(const lcp_factored *f, int g, lcp_contact_frame *out);

/* The rows of both sides of a group of `rows` rows. */
void lcp_contact_rows(const lcp_factored *f, int g, int rows, double room[LCP_MIXED_MAX],
                      const double *side[2]);

/* A = J W J' of group g of three rows, column by column, for the bodies of lcp_contact_bodies. */
void lcp_contact_block(const lcp_factored *f, int g, const double *body, double A[9]);

/* Place k, in its batch: contact g in the frame, directions over root[0..1] (NULL: 1); without a frame, an idle lane. */
void lcp_contact_place(lcp_lane_frame *at, int k, const lcp_factored *f, int g,
                       const lcp_contact_frame *frame, const double *root);

/* 16 numbers a body: v (3), 1/m, o (3), 0, inertia^-1 (6), 0; behind those that move the fixed ones. At rest. The second stops those that move, and
 * nothing ever moves the others. */
void lcp_contact_bodies(const lcp_factored *f, double *body);
void lcp_contact_stop_bodies(const lcp_factored *f, double *body);
