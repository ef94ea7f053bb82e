/* cone_step.h - the linear system of a Newton step on the equations of cone_scaled.h,
 *
 *   (X + Y (s M s + weight I)) dx = -F
 *
 * X and Y block diagonal. Pieces with Y = 0 (open contacts, rows at a bound) leave the system first.
 *   dense   LU of the rest (LAPACK)
 *   CSC     KLU of the rest
 *   factored  by groups T = X + Y (s S s + weight I) and Y over the active rows, solved in the body velocities
 *           (linear/body_space.h): regular however redundant the contacts are, without an inverse of W; symmetric where
 *           nothing slips. The order of elimination stays while the same bodies meet */
#pragma once

#include "lcp/linear/body_space.h"
#include "lcp/linear/direct.h"
#include "lcp/solvers/cone_scaled.h"
#include "lcp/solvers/sweep.h"

typedef struct lcp_cone_step {
  lcp_sweep sweep;       /* factored: L and groups, */
  bool weighed;          /* and G, made by the first factorisation: an answer needs none */
  unsigned char *active; /* n: row of a piece with Y != 0 */
  int *piece_of;         /* n */
  double *dz, *t;        /* n */
  double *v;             /* 2 n_dof: a product's own */
  void *mem;             /* owned, made by the first factorisation; NULL before */
  lcp_matrix A;          /* the system, views of the arrays in mem: */
  size_t entries;
  double *val;
  int *colptr, *rowind;
  lcp_direct direct;
  lin_body_space body; /* factored: the system */
} lcp_cone_step;

void lcp_cone_step_layout(lcp_cone_step *s, const lcp_capacity *cap, base_arena *a);
/* The same beside dz and t, n each, which nobody else needs while a step is made. */
void lcp_cone_step_layout_beside(lcp_cone_step *s, const lcp_capacity *cap, double *dz, double *t,
                                 base_arena *a);

/* BASE_EUNSUPPORTED: factored with a cone that spans groups, or with an S that couples groups. */
base_status lcp_cone_step_prepare(lcp_cone_step *s, const lcp_problem *p, const lcp_cone_scaled *c,
                                  base_error *err);

/* Factors with c->X, c->Y; overwrites them in the factored form. False: singular, or *status says no memory. */
bool lcp_cone_step_factor(lcp_cone_step *s, const lcp_problem *p, lcp_cone_scaled *c, double weight,
                          lcp_work *work, base_status *status);

/* dx from c->F; w and z of the problem are not touched. */
void lcp_cone_step_solve(lcp_cone_step *s, const lcp_problem *p, const lcp_cone_scaled *c,
                         double *dx, lcp_work *work);

void lcp_cone_step_release(lcp_cone_step *s);
