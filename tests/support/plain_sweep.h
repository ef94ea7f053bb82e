/* tests/support/plain_sweep.h - a contact bed of any size, and Gauss-Seidel sweeps over it written the
 * straightforward way: the baseline that lcp/solvers/contact_sweep.h is measured against.
 *
 * Both work on body velocities v, one contact after the other, one row after the other:
 *   w = q + J v,  x = clip(z - w / d),  v += W J' (x - z)
 *   rows    J and W J' stored, 12 + 12 numbers a row (664 bytes a contact)
 *   frames  two directions and two arms stored, J built on the way, mass and inertia per body
 *           (208 bytes a contact)
 * Friction rows have constant symmetric bounds. */
#pragma once

#include "lcp/lcp_problem.h"

/* A cubic lattice of rigid bodies of varied mass and full inertia, contacts to the neighbours in x, y
 * and z and to a fixed floor, in lattice order; frames, arms and q random but seeded. */
typedef struct contact_bed {
  int n_body, n_contact;
  lcp_problem p; /* LCP_FACTORED, 3 rows a contact: orthant, box, box */
  double *memory;
  int *index;
  double *arm;   /* 6 per contact: from the body to the point, side 0 then 1 */
  double *frame; /* 9 per contact: n, t1, t2 */
} contact_bed;

contact_bed contact_bed_open(int n_contact, unsigned long seed); /* memory NULL: no memory */
void contact_bed_close(contact_bed *bed);

typedef struct plain_contact_rows {
  double J[3][12], B[3][12]; /* B = W J' */
  double q[3], z[3], inverse[3], bound[3];
  int body[2];
} plain_contact_rows;

typedef struct plain_contact_frames {
  double n[3], t[3], arm[2][3];
  double q[3], z[3], inverse[3], bound[2];
  int body[2];
} plain_contact_frames;

typedef struct plain_body {
  double inverse_mass, inverse_inertia[9];
} plain_body;

/* v: 6 per body and 6 more for the floor (index n_body), which stays at zero. */
void plain_rows_fill(const contact_bed *bed, const int *order, plain_contact_rows *c);
void plain_rows_sweep(plain_contact_rows *c, int n, double *v);
void plain_frames_fill(const contact_bed *bed, const int *order, plain_contact_frames *c,
                       plain_body *body);
void plain_frames_sweep(plain_contact_frames *c, int n, const plain_body *body, double *v);
