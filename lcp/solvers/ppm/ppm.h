/* solvers/ppm.h - the state of ppm and what it computes of a point; included by solver_ppm.c and ppm_*.c
 * only. */
#pragma once

#include "lcp/lcp_farkas.h"
#include "lcp/lcp_rho.h"
#include "lcp/lcp_solver.h"
#include "lcp/linear/packed_chol.h"
#include "lcp/solvers/loop.h"
#include "lcp/solvers/sweep.h"

typedef enum place { AT_LO, AT_HI, BASIC } place;

typedef struct ppm {
  lcp_loop loop;
  lcp_sweep sweep;      /* factored M: G and velocities */
  double *dof;          /* n_dof */
  long double *wide;    /* n_dof */
  int m, m_max;         /* |F|; what L holds: of J W J' alone no more than the rank */
  int *order, *pos;     /* F in the order of L; place of i in F or -1 */
  unsigned char *where; /* place of z_i */
  unsigned char *is_free;
  unsigned char *tries; /* times a violation near round-off was driven */
  double *L, *cs;
  double *d, *unit;      /* diagonal; sqrt |M_ii| (1 where zero) */
  double *share;         /* 1 / unit */
  double *lo, *hi;       /* bounds of every row */
  double *w, *bound;     /* M z + q; |q| + |M||z| */
  double *x, *y;         /* L^-1 M_Fr; direction of z_F, by place */
  double *ray;           /* by row */
  lcp_farkas_sum *force; /* n_dof: scratch of lcp_farkas_prove */
  long double *sum;      /* n */
  bool small;            /* rows of an orthant with positive diagonals, few enough for `table` */
  double *table;         /* lcp_ppm_table_size */
  int stride;            /* of its columns */
  double *side;          /* n: -1 where z_i is basic, 1 elsewhere */
} ppm;

enum { PPM_TABLE_MAX = 64 }; /* rows of a table */

/* Sizes in the metric of unit: a Schur complement below `rank` of its diagonal is zero, an entry of a direction below
 * `faint` of the largest one too. */
typedef struct lcp_ppm_share {
  double rank, faint;
} lcp_ppm_share;

/* Doubles that the tableau of n <= PPM_TABLE_MAX rows takes. */
size_t lcp_ppm_table_size(int n);

/* The pivots of a small problem from z = 0 on a tableau. True: z is right to rounding, res->residual an upper bound of its
 * rho, where[] the basis. False: left to the factored path, with z and the lists of s in any state. ppm_table.c */
bool lcp_ppm_table_solve(ppm *s, const lcp_problem *p, const lcp_stop *stop,
                         const lcp_ppm_share *share, double *z, lcp_result *res);

/* w = M z + q and |q| + |M||z|. */
void lcp_ppm_evaluate(const ppm *s, const lcp_problem *p, const double *z);

/* Corrects the drift of z_F: z_F -= M_FF^-1 w_F where w_F left round-off. w is evaluated again. */
void lcp_ppm_correct(ppm *s, const lcp_problem *p, double *z, lcp_work *work);

/* Two steps of iterative refinement of z_F, residuals in long double; z stays on K. */
void lcp_ppm_refine(ppm *s, const lcp_problem *p, double *z, lcp_work *work);

/* The same for a factored M; x = M_Fr by place in F; sum = M z + q. ppm_factored.c */
void lcp_ppm_evaluate_factored(const ppm *s, const lcp_problem *p, const double *z);
void lcp_ppm_gather_factored(const ppm *s, const lcp_factored *f, int r, double *x);
void lcp_ppm_extended_factored(const ppm *s, const lcp_problem *p, const double *z);
