/* solvers/ppm.h - the state of ppm and what it computes of a point; included by solver_ppm.c and ppm_point.c
 * only. */
#pragma once

#include "lcp/lcp_solver.h"
#include "lcp/linear/packed_chol.h"

typedef enum place { AT_LO, AT_HI, BASIC } place;

typedef struct ppm {
  lcp_stop_state stop;
  int m;                /* |F| */
  int *order, *pos;     /* F in the order of L; place of i in F or -1 */
  unsigned char *where; /* place of z_i */
  unsigned char *is_free;
  unsigned char *tries; /* times a violation near round-off was driven */
  double *L, *cs;
  double *d, *unit;  /* diagonal; sqrt |M_ii| (1 where zero) */
  double *lo, *hi;   /* bounds of every row */
  double *w, *bound; /* M z + q; |q| + |M||z| */
  double *x, *y;     /* L^-1 M_Fr; direction of z_F, by place */
  double *ray;       /* by row */
  long double *sum;  /* n */
} ppm;

/* w = M z + q and |q| + |M||z|. */
void lcp_ppm_evaluate(const ppm *s, const lcp_problem *p, const double *z);

/* Corrects the drift of z_F: z_F -= M_FF^-1 w_F where w_F left round-off. w is evaluated again. */
void lcp_ppm_correct(ppm *s, const lcp_problem *p, double *z, lcp_work *work);

/* Two steps of iterative refinement of z_F, residuals in long double; z stays on K. */
void lcp_ppm_refine(ppm *s, const lcp_problem *p, double *z, lcp_work *work);
