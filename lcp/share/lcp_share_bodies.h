/* lcp/share/lcp_share_bodies.h - the system of lcp_share_system.h for M = J W J' + S in factors, solved in the body velocities
 * (linear/body_space.h), so that nothing of the size of contact space squared is made. Private to lcp_share*.c. */
#pragma once

#include "lcp/linear/body_space.h"
#include "lcp/share/lcp_share_system.h"

typedef struct share_bodies {
  lin_body_space space;
  const lcp_problem *p;  /* of the last begin */
  double *L, *G;         /* lin_weigh_bodies, lin_weigh_stored */
  unsigned char *member; /* cap_n: rows in the system */
  double *scratch, *v;   /* of lcp_matrix_apply; cap_dof */
  size_t cap_weight, cap_jac, cap_scratch;
  int cap_dof, cap_n;
  void *mem; /* owned */
} share_bodies;

void lcp_share_bodies_close(share_bodies *s);

/* Gives its memory back, but for the order of elimination, until the next begin. */
void lcp_share_bodies_rest(share_bodies *s);

/* Factors of W and G for the matrix of p. BASE_EINVAL: a weight is not positive semidefinite; BASE_ENOMEM. */
base_status lcp_share_bodies_begin(share_bodies *s, const lcp_problem *p, base_error *err);

/* w = M z + q; size_i: the sum of what it is made of, in body velocities first (an upper bound of sum |M_ij z_j| + |q_i|), unless
 * NULL. */
void lcp_share_bodies_product(share_bodies *s, const double *z, double *w, double *size);

void lcp_share_bodies_diagonal(const share_bodies *s, double *d); /* of M */

/* The system for the kinds in r. *regular = false: singular. */
base_status lcp_share_bodies_factor(share_bodies *s, const share_rows *r, bool *regular,
                                    base_error *err);
