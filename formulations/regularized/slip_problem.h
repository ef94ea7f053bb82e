/* formulations/regularized/slip_problem.h - contact forces when the direction of sliding friction is given by the
 * motion (Coulomb at acceleration level; Pfeiffer & Glocker 1996, Baraff 1991).
 *
 * Every contact is in one of two modes:
 *   slip   lambda_t = -mu lambda_n d, d the direction of sliding: one unknown lambda_n,
 *          w = u_n                                          (nonsymmetric column J_n - mu d J_t)
 *   stick  a faceted cone: lambda_n, beta_1..nd, sigma as in `velocity`, so that a contact at rest
 *          may hold or start to slide in any direction
 * With frozen slip the problem may have no solution, or several (Painleve): that is the model's
 * answer, and it is handed on.
 */
#pragma once

#include "formulations/assembly.h"

enum { SLIP_FACETS_MAX = 64 };

typedef struct slip_problem {
  int facets;        /* directions of a spatial contact; planar ones have 2 */
  int distribution;  /* form_distribution */
  int n;             /* unknowns */
  int *first;        /* n_contact+1 */
  double *direction; /* 2 n_contact: d, zero where the contact sticks or has no friction */
  double *mu;        /* n_contact */
  double *turn;      /* n_contact: angle of the first facet from the first tangent [rad] */
  double *
      given; /* n_contact: normal impulse that acts besides the unknown one, which the caller writes; 0 by slip_begin */
  double *unit; /* n_contact: 1/kg, scales sigma to an impulse and the cone row to a velocity */
  double *C;    /* n_row^2 */
  double *M, *q, *z0; /* n^2, n, n zeros */
  double *column;     /* n_row, scratch */
  lcp_block *block;   /* n_contact */
  int cap_contact, cap_row, cap_n;
  void *mem; /* owned */
} slip_problem;

/* Room for the contacts of a; reads C. Directions, turns and given impulses are zeroed. */
base_status slip_begin(slip_problem *s, const form_assembly *a, int facets, int distribution,
                       base_error *err);
void slip_close(slip_problem *s);

/* Poses the problem for the present directions: w = M z + q with u = u0 + C lambda, of which lambda the given impulses are a
 * part; u0 has n_row entries, the bias added to the normals. */
void slip_pose(slip_problem *s, const form_assembly *a, const double *u0, lcp_problem *out);

/* Contact i has a faceted cone: it may hold or start to slide. */
bool slip_at_rest(const slip_problem *s, const form_assembly *a, int i);
/* Tangential part of u0 + C lambda at contact i, zeros where it has fewer than two tangents. */
void slip_departure(const slip_problem *s, const form_assembly *a, int i, const double *u0,
                    const double *lambda, double along[2]);

/* lambda (n_row) of a solution z, with the given impulses. */
void slip_impulses(const slip_problem *s, const form_assembly *a, const double *z, double *lambda);
