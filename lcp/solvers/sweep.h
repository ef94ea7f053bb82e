/* sweep.h - what a Gauss-Seidel method sees of M z + q: one row now, one change of z at a time.
 *
 * Dense and CSC keep w = M z + q and update it by columns. The factored form J W J' + S is never
 * formed: with W = L L' (Cholesky by body) and G = J L the sweep keeps mass-weighted body velocities
 * u = G' z, of which row i sees G_i u, so one array G serves both the residual and the update; S z
 * is kept by columns beside it. Memory is linear in rows. */
#pragma once

#include "lcp/lcp_solver.h"

typedef struct lcp_sweep {
  double *w;  /* n: M z + q; factored: S z + q [m/s] */
  double *d;  /* n: diagonal of M [1/kg] */
  double *G;  /* n_jac: J L, laid out as jac */
  double *u;  /* n_dof: G' z, mass-weighted velocity change */
  double *L;  /* n_weight: Cholesky factors of the W blocks, lower, column-major */
  int *group; /* n: group of each row */
} lcp_sweep;

void lcp_sweep_layout(lcp_sweep *s, const lcp_capacity *cap, base_arena *a);

/* L and the groups of the factored form alone. BASE_EINVAL where a W block is not positive semidefinite. */
base_status lcp_sweep_weigh_bodies(lcp_sweep *s, const lcp_factored *f, base_error *err);

/* Diagonal, and for the factored form G. BASE_EINVAL where a W block is not positive semidefinite. */
base_status lcp_sweep_prepare(lcp_sweep *s, const lcp_problem *p, base_error *err);

/* Everything from z; counts the product M z where there is one. */
void lcp_sweep_refresh(lcp_sweep *s, const lcp_problem *p, const double *z, lcp_work *work);

double lcp_sweep_row(const lcp_sweep *s, const lcp_problem *p, int i); /* (M z + q)_i */
void lcp_sweep_add(lcp_sweep *s, const lcp_problem *p, int j, double dz);

/* M_bb of rows first .. first+size-1, column-major, into out[size*size]. */
void lcp_sweep_block(const lcp_sweep *s, const lcp_problem *p, int first, int size, double *out);

/* One side of one row: `dof` entries of G and the velocities they multiply. */
typedef struct lcp_sweep_side {
  double *g, *u;
  int body, dof; /* body < 0: fixed, dof = 0 */
} lcp_sweep_side;

static inline lcp_sweep_side lcp_sweep_side_of(const lcp_sweep *s, const lcp_factored *f, int i,
                                               int which) {
  const int g = s->group[i];
  const int *body = &f->body[2 * (ptrdiff_t)g];
  int dof[2];
  for (int k = 0; k < 2; k++) {
    dof[k] = (body[k] >= 0) ? f->dof_start[body[k] + 1] - f->dof_start[body[k]] : 0;
  }
  const int rows = f->row_start[g + 1] - f->row_start[g], row = i - f->row_start[g];
  const int at = f->jac_start[g] + ((which == 0) ? row * dof[0] : rows * dof[0] + row * dof[1]);
  lcp_sweep_side out = {.g = s->G + at, .body = body[which], .dof = dof[which]};
  out.u = (body[which] >= 0) ? s->u + f->dof_start[body[which]] : s->u;
  return out;
}
