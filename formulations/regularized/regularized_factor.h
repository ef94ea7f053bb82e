/* formulations/regularized/regularized_factor.h - the two factorisations of M_hat behind regularized_mass.c; private to
 * it. Each takes the lower triangle by body blocks, dofs in the order reg_mass.place, and gives L^-1
 * on many right sides and L'^-1 on one. */
#pragma once

#include "formulations/regularized/regularized.h"

/* regularized_envelope.c: L in its envelope, no heap in a step. */
void reg_envelope_plan(const contact_set *c, reg_mass *m);
void reg_envelope_mass(const contact_set *c, reg_mass *m);
/* The compliant directions of one contact, over the dofs of both sides. */
typedef struct reg_springs {
  int rank, n[2], place[2];
  const double *e[2]; /* rank x n, row-major */
  double stiffness[REG_ROWS_MAX];
} reg_springs;

/* M_hat += sum of stiffness e_x' e_y over the directions: the rows of side x, the columns of side y. */
typedef void (*reg_add)(reg_mass *m, const reg_springs *s, int x, int y);
void reg_envelope_add(reg_mass *m, const reg_springs *s, int x, int y);
/* L L' = M_hat in place; false if it is not positive definite. */
bool reg_envelope_factor(const contact_set *c, reg_mass *m);
/* Y <- L^-1 Y, Y row-major with `all` right sides: c, `sets` sets of p columns of which `from` and `to` say
 * where they begin, the rest full. */
void reg_envelope_forward(const contact_set *c, reg_mass *m, int p, int sets, int all);
/* A = N B', p x p by columns, N the columns 1 .. p of Y as a p x n matrix and B the p behind them; without slip
 * B = N, and only the lower part is written. Joints have not been projected out. */
void reg_envelope_multiply(const contact_set *c, const reg_mass *m, int p, bool slip, int all,
                           double *A);
/* x <- L'^-1 x. */
void reg_envelope_backward(reg_mass *m, int n, double *x);

/* regularized_sparse.c: the same by CHOLMOD, whose ordering and symbolic analysis stand as long as the same
 * bodies share contacts. */
base_status reg_sparse_plan(const contact_set *c, reg_mass *m, base_error *err);
void reg_sparse_mass(const contact_set *c, reg_mass *m);
void reg_sparse_add(reg_mass *m, const reg_springs *p, int x, int y);
bool reg_sparse_factor(reg_mass *m);
bool reg_sparse_forward(reg_mass *m, int n, int width);
/* NaN without memory: the step's residual then shows it. */
void reg_sparse_backward(reg_mass *m, int n, double *x);
void reg_sparse_close(reg_mass *m);

/* regularized_sides.c: zeroes Y, `all` columns wide, and fills [c | J_n' | J' B | J_b'], the third only where
 * some part slips; adds the springs to M_hat. */
void reg_sides_fill(regularized *s, int all);
/* u = r + J delta over the rows in use. */
void reg_sides_motion(const regularized *s, const double *delta, double *u);

/* regularized_joint.c: joints behind the contacts, after the forward substitution of all columns. width:
 * columns before those of the joints. */
base_status reg_joint_begin(regularized *s, int width, base_error *err);
bool reg_joint_factor(regularized *s, int width);
void reg_joint_project(regularized *s, int width);
void reg_joint_impulses(const regularized *s, int first, const double *lambda_n, double *lambda);
