/* lcp/lcp_problem.h - the problem every solver in the suite receives.
 *
 *   find z, w in R^n:   w = M z + q,   z in K,  w in K* ,  z _|_ w
 *
 * with K a product of simple sets, one per block:
 *
 *   LCP_ORTHANT  z_i >= 0                                   (all of it: the standard LCP)
 *   LCP_BOX      lo_i <= z_i <= hi_i;  w_i > 0 only at lo_i, w_i < 0 only at hi_i
 *   LCP_FREE     z_i unbounded, w_i = 0                     (bilateral rows: a mixed LCP)
 *   LCP_CONE     z = (r_n, r_1, r_2, ...): |r_k| <= mu_k r_n for each part k, and the exact
 *                Coulomb law: w + (sum_k mu_k |w_k|) e_n  in K*  (De Saxce & Feng 1998)
 *
 * (Cottle, Pang & Stone 1992, eq. 1.1.1; Acary, Bremond & Huber 2018 for the cone.)
 *
 * Contact reading (velocity level, one step of length h):
 *   z  impulse                   [N s]
 *   w  relative velocity         [m/s]
 *   M  Delassus matrix J W J'    [1/kg]
 */
#pragma once

#include "lcp/base/arena.h"
#include "lcp/base/status.h"

#include <math.h>
#include <stdbool.h>

/* ---- matrix ------------------------------------------------------------------------------- */

typedef enum lcp_storage {
  LCP_DENSE,    /* n*n, column-major */
  LCP_CSC,      /* compressed columns */
  LCP_FACTORED, /* J W J' + S, never formed (the operator form) */
} lcp_storage;

enum { LCP_PARTS_MAX = 3 }; /* friction, torsion, rolling */

/* Compressed columns; row indices strictly increasing inside a column. Views, not owned. */
typedef struct lcp_csc {
  int n_row, n_col;
  const int *colptr; /* n_col+1 */
  const int *rowind; /* colptr[n_col] */
  const double *val; /* colptr[n_col] */
} lcp_csc;

/* Rows of a group that are sums of fewer: row i is the sum over the `stored` rows k of c[i * stored + k] times row k. So the
 * facets of a contact are made of its two tangents where they are read. */
typedef struct lcp_mixture {
  int rows, stored;
  const double *c; /* rows x stored, row-major */
} lcp_mixture;

enum {
  LCP_STORED_MAX = 4,                 /* that others are mixed of */
  LCP_MIXED_ROWS = 66,                /* of such a group at most, */
  LCP_MIXED_MAX = 12 * LCP_MIXED_ROWS /* and their numbers in J */
};

/* M = J W J' + S with W block-diagonal (one dense SPD block per body) and every row of J touching
 * at most two bodies. Rows come in groups (a contact) that touch the same bodies.
 * Body k owns velocity dofs dof_start[k] .. dof_start[k+1]-1.
 * jac has per group: rows x dofs of side 0 (row-major), then of side 1. Of a group with a mixture it has the stored rows in their place,
 * so rows of J are read by lcp_factored_rows (lcp_mixture.h). */
typedef struct lcp_factored {
  int n_body;
  const int *dof_start;    /* n_body+1 */
  const int *weight_start; /* n_body+1, offsets into weight */
  const double *weight;    /* W blocks, dense column-major, symmetric [1/kg] */
  int n_group;
  const int *row_start; /* n_group+1 */
  const int *body;      /* 2*n_group; -1 where a side is fixed */
  const int
      *jac_start; /* n_group+1, offsets into jac, or into an array laid out like it of all rows */
  const double *jac;
  const lcp_csc *shift; /* S, n x n, or NULL for zero; rows of J may be zero where S acts alone */
  const int *stored_start;           /* n_group, offsets into jac; NULL: jac_start */
  const lcp_mixture *const *mixture; /* n_group; NULL: jac has the rows themselves */
} lcp_factored;

/* How the rows of group g are mixed; NULL: jac has them. */
static inline const lcp_mixture *lcp_mixture_of(const lcp_factored *f, int g) {
  return (f->mixture != NULL) ? f->mixture[g] : NULL;
}

/* Rows that jac has of group g, */
static inline int lcp_factored_stored(const lcp_factored *f, int g) {
  const lcp_mixture *m = lcp_mixture_of(f, g);
  return (m != NULL) ? m->stored : f->row_start[g + 1] - f->row_start[g];
}

/* and where they begin. */
static inline int lcp_factored_at(const lcp_factored *f, int g) {
  return (f->stored_start != NULL) ? f->stored_start[g] : f->jac_start[g];
}

static inline int lcp_factored_dof(const lcp_factored *f, int g, int side) {
  const int b = f->body[2 * (ptrdiff_t)g + side];
  return (b >= 0) ? f->dof_start[b + 1] - f->dof_start[b] : 0;
}

/* Square matrix, read-only view; does not own its arrays. Of val and csc the one of `storage` is filled. */
typedef struct lcp_matrix {
  lcp_storage storage;
  int n;             /* rows = columns */
  const double *val; /* LCP_DENSE: n*n, column-major */
  lcp_csc csc;       /* LCP_CSC */
  const lcp_factored
      *factored; /* LCP_FACTORED; beside another storage: the same matrix in factors, or NULL */
} lcp_matrix;

/* ---- sets --------------------------------------------------------------------------------- */

typedef enum lcp_set { LCP_ORTHANT, LCP_BOX, LCP_FREE, LCP_CONE } lcp_set;

/* One block of unknowns, normally one contact or one joint. Parts are those of a cone, size = 1 + sum part_dim; or, on an
 * orthant, its facets: the normal impulse, part_dim[k] facets of each part, then one slip speed a part,
 * size = 1 + sum part_dim + n_part. Solvers of orthants need not know of parts; lcp_share does. */
typedef struct lcp_block {
  int start, size;
  lcp_set set;
  int n_part;
  int part_dim[LCP_PARTS_MAX];
  double part_mu[LCP_PARTS_MAX]; /* LCP_CONE: >= 0 [1], or [m] for torsion and rolling */
  double
      soft; /* relative compliance of the first row where M leaves it undetermined (lcp_share.h); 0: any answer */
} lcp_block;

/* ---- problem ------------------------------------------------------------------------------ */

/* What is known about a problem. A formulation sets only what it can prove. */
typedef enum lcp_trait {
  LCP_SYMMETRIC = 1u << 0,
  LCP_PSD = 1u << 1,             /* z'Mz >= 0; M need not be symmetric */
  LCP_PD = 1u << 2,              /* z'Mz > 0 */
  LCP_COPOSITIVE = 1u << 3,      /* z'Mz >= 0 for z >= 0 */
  LCP_COPOSITIVE_PLUS = 1u << 4, /* and z'Mz = 0, z >= 0 implies (M + M')z = 0 */
  LCP_P_MATRIX = 1u << 5,        /* all principal minors positive */
  LCP_ZERO_DIAGONAL = 1u << 6,   /* some M_ii = 0: point sweeps are not defined */
} lcp_trait;

typedef struct lcp_problem {
  lcp_matrix M;           /* [1/kg] */
  const double *q;        /* n, [m/s] */
  const double *lo, *hi;  /* n, used on LCP_BOX blocks only; NULL when there are none [N s] */
  const lcp_block *block; /* n_block blocks in order, covering 0..n-1; NULL: one orthant */
  int n_block;
  unsigned traits; /* lcp_trait bits */
} lcp_problem;

/* Bits 1u << set of the sets that occur in p. */
unsigned lcp_problem_sets(const lcp_problem *p);

/* Upper bounds a workspace is sized for; a time-stepping run shares one. */
typedef struct lcp_capacity {
  int n;       /* unknowns */
  int n_block; /* blocks */
  int nnz;     /* stored entries; n*n for LCP_DENSE, entries of S for LCP_FACTORED */
  int n_body;  /* LCP_FACTORED: bodies, velocity dofs, entries of jac and of weight */
  int n_dof;
  int n_jac;
  int n_weight;
  int n_folded; /* n and n_jac once the facets of LCP_FACTORED are folded (solvers/facet_fold.h); without any the same, */
  int n_jac_folded; /* which 0 stands for */
} lcp_capacity;

/* Rows of block b once its facets are folded: one or two a part, and no sigma. Other blocks keep theirs. */
int lcp_block_folded(const lcp_block *b);

lcp_capacity lcp_problem_capacity(const lcp_problem *p); /* exactly what p needs */
bool lcp_capacity_holds(const lcp_capacity *c, const lcp_capacity *need);

/* Checks shapes, index ranges, finiteness of every number, lo <= hi, mu >= 0, blocks that cover
 * 0..n-1 in order. Cost O(nnz). Called by readers, harness and tests, never by a solver. */
base_status lcp_problem_check(const lcp_problem *p, base_error *err);

/* Invariants for assert, which look at no number of M or q. Of columns: offsets do not decrease, row indices increase
 * and are in range. Of a problem: its columns (or those of S) are such, its groups and its blocks cover 0..n-1 in
 * order. */
bool lcp_csc_is_sorted(const lcp_csc *m);
bool lcp_problem_is_shaped(const lcp_problem *p);

/* M as its factors, which it must have. */
static inline lcp_matrix lcp_matrix_in_factors(const lcp_matrix *M) {
  return (lcp_matrix){.storage = LCP_FACTORED, .n = M->n, .factored = M->factored};
}

/* ---- products ----------------------------------------------------------------------------- */

/* y = M x + b (b may be NULL). x, y and b have length n; y must not alias x. `scratch` holds
 * lcp_matrix_scratch(M) doubles (0 unless LCP_FACTORED). */
void lcp_matrix_apply(const lcp_matrix *M, const double *x, const double *b, double *y,
                      double *scratch);
size_t lcp_matrix_scratch(const lcp_matrix *M);

/* d_i = M_ii, zero where the diagonal entry is not stored. */
void lcp_matrix_diagonal(const lcp_matrix *M, double *d);

/* Dense copy, column-major, into out[n*n]. Any storage. */
void lcp_matrix_to_dense(const lcp_matrix *M, double *out);

/* M_ij = M_ji to the last bit; of LCP_FACTORED, which is symmetric iff S is, S is compared. */
bool lcp_matrix_is_symmetric(const lcp_matrix *M);

/* Owning CSC copy of any storage (entries that are exactly zero are dropped); free with
 * lcp_csc_free. */
base_status lcp_matrix_to_csc(const lcp_matrix *M, lcp_csc *out, base_error *err);
void lcp_csc_free(lcp_csc *m);
