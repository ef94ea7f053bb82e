/* solvers/ppm.h - the state of ppm and what it computes of a point; included by solver_ppm.c and ppm_*.c
 * only. */
#pragma once

#include "lcp/lcp_farkas.h"
#include "lcp/lcp_rho.h"
#include "lcp/lcp_solver.h"
#include "lcp/linear/packed_chol.h"
#include "lcp/solvers/loop.h"
#include "lcp/solvers/sweep.h"

/* INSIDE: between its bounds and not basic, where it started. */
typedef enum place { AT_LO, AT_HI, BASIC, INSIDE } place;

typedef struct ppm {
  lcp_loop loop;
  lcp_sweep sweep;      /* factored M: G and velocities */
  double *dof;          /* n_dof */
  long double *wide;    /* n_dof */
  int m, m_max;         /* |F|; what L holds: of J W J' alone no more than the rank */
  int *order, *pos;     /* F in the order of L; place of i in F or -1 */
  unsigned char *where; /* place of z_i */
  unsigned char *is_free;
  bool boxes; /* some rows have a box: rows may stay INSIDE, as no basis is a certificate there */
  unsigned char *tries; /* times a violation near round-off was driven */
  double *L, *cs;
  double *d, *unit;      /* diagonal; sqrt |M_ii| (1 where zero) */
  double *share;         /* 1 / unit */
  double *lo, *hi;       /* bounds of every row */
  double *w, *bound;     /* M z + q; |q| + |M||z| */
  double *x, *y;         /* L^-1 M_Fr; direction of z_F, by place */
  double *ray;           /* by row */
  double *e;             /* n: z is rounded from z + e; 0 until lcp_ppm_rounded */
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

extern const lcp_ppm_share lcp_ppm_relative;

typedef enum lcp_ppm_end {
  LCP_PPM_JOINED,
  LCP_PPM_BOUNDED,
  LCP_PPM_UNBLOCKED,
  LCP_PPM_SPENT
} lcp_ppm_end;

/* How far w of row i, which is not basic, has the wrong sign [m/s]; negative: it has not. ppm_basis.c */
double lcp_ppm_violation(const ppm *s, int i);

/* x = L^-1 M_Fr, y = -M_FF^-1 M_Fr; returns the Schur complement, dw_r/dz_r. Row r then joins F by its root. */
double lcp_ppm_direction(ppm *s, const lcp_matrix *M, int r, lcp_work *work);
void lcp_ppm_enter(ppm *s, int r, double root);

/* Basic variable k of F stops at the bound `where`. */
void lcp_ppm_leave(ppm *s, double *z, int k, place where);

/* Smallest step along sign * (y, 1) at which a basic z + e meets a bound; ties: the largest pivot. top: size
 * of the driving entry, 0 where none drives. -1: none does. */
int lcp_ppm_first_block(const ppm *s, const double *z, double top, double sign, double *step);

/* Drives row r until w_r = 0, a bound of z_r, or nothing blocks. What moves is x, which is z or e. */
lcp_ppm_end lcp_ppm_drive(ppm *s, const lcp_problem *p, double *z, double *x, int r, long limit,
                          lcp_work *work);

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

/* sum = M (z + e) + q in long double; e may be NULL. */
void lcp_ppm_extended(const ppm *s, const lcp_problem *p, const double *z, const double *e);

/* For a z of the last basis that does not pass data_test.h: pivots on from there with w in long double. True where that
 * ends at a z + e that passes and whose rounding, z on return, meets tol. ppm_rounded.c */
bool lcp_ppm_rounded(ppm *s, const lcp_problem *p, const lcp_stop *stop, double *z,
                     lcp_result *res);

/* The same for a factored M; x = M_Fr by place in F; sum = M (z + e) + q. ppm_factored.c */
void lcp_ppm_evaluate_factored(const ppm *s, const lcp_problem *p, const double *z);
void lcp_ppm_gather_factored(const ppm *s, const lcp_factored *f, int r, double *x);
void lcp_ppm_extended_factored(const ppm *s, const lcp_problem *p, const double *z,
                               const double *e);
