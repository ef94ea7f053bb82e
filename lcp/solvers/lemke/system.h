/* solvers/lemke/system.h - the problem as Lemke's pivots see it, and the residual of its points.
 *
 * The pivots solve  w' - M' z' = q'  with M' = R M C, q' = R q / Q, z = Q C z', where R, C and Q are powers of two, so
 * that no digit changes. A built system holds M' and q' by columns, with the body velocities of a factored M as
 * extra free rows. A view reads M and q where the problem has them and applies the powers on the way. */
#pragma once

#include "lcp/lcp_column.h"
#include "lcp/lcp_farkas.h"
#include "lcp/lcp_problem.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct lemke_system {
  int n;                        /* rows of the problem */
  int rows;                     /* with those of the velocities */
  int edition;                  /* changes with the content */
  bool view;                    /* val and q are the problem's own numbers */
  bool scaled_rows;             /* R was lemke_system_build's choice */
  bool any_free;                /* else is_free is zero everywhere */
  const int *colptr, *rowind;   /* NULL where every column is full */
  const double *val;            /* of a factored M the entries of S come first in a column */
  const double *q;              /* rows */
  const unsigned char *is_free; /* rows: w_i = 0, z_i unbounded */
  const int *row_exp, *col_exp; /* rows: R = 2^row_exp, C = 2^col_exp; row_exp NULL: R = I */
  int q_exp;                    /* Q = 2^q_exp: max |q'| is in [1, 2) */

  /* For the residual; a system that is solved but not judged leaves them out. */
  const int *jptr, *jdof; /* J of a factored M by rows, n+1 and its entries, scaled as val */
  const double *jval;
  const double *diagonal; /* n: of the M that val holds */
  long double *w;         /* rows: scratch, as the next five */
  long double *row_sum;
  double *tau0, *zref;
  int *row_top;
  lcp_farkas_sum *force; /* n_dof */
} lemke_system;

/* The arrays behind a built system, named as there. */
typedef struct lemke_store {
  int n, rows;
  int *colptr, *rowind, *jptr, *jdof, *row_exp, *col_exp;
  int *row_top; /* rows: scratch, as the next two */
  double *scratch, *sum;
  double *val, *q, *jval, *diagonal;
  unsigned char *is_free;
} lemke_store;

void lemke_system_layout(lemke_system *s, lemke_store *m, const lcp_capacity *cap, base_arena *a);

/* Columns scaled to maximum 1..2 and the rows as they are; or, where `rows` asks for it or the rows' maxima then differ by more
 * than 2^20, both to geometric mean 1. */
void lemke_system_build(lemke_system *s, lemke_store *m, const lcp_problem *p, bool rows);

/* A view of an orthant problem, dense or CSC, with the columns scaled to maximum 1..2 and the rows as they are. False
 * where rows or columns are too far apart for that: such a problem is to be built. */
bool lemke_system_view(lemke_system *s, lemke_store *m, const lcp_problem *p);

/* A view of the dense n x n matrix M (column-major) and q with powers of the caller's, |exponents| <= 500. Only to be
 * solved. False where q is too far from 1 for them. */
bool lemke_system_over(lemke_system *s, int n, const double *M, const double *q, const int *row_exp,
                       const int *col_exp);

/* Column j: of val, with the rows of the velocities. */
static inline lcp_column lemke_system_column(const lemke_system *s, int j) {
  if (s->rowind == NULL) {
    return (lcp_column){s->rows, NULL, s->val + (ptrdiff_t)j * s->rows};
  }
  const int first = s->colptr[j];
  const int count = s->colptr[j + 1] - first;
  return (lcp_column){count, s->rowind + first, s->val + first};
}

static inline bool lemke_is_free(const lemke_system *s, int i) {
  return s->any_free && s->is_free[i] != 0;
}

/* 2^e, |e| <= 1022. */
static inline double lemke_power(int e) {
  const uint64_t bits = (uint64_t)(e + 1023) << 52;
  double power;
  memcpy(&power, &bits, sizeof power);
  return power;
}

/* ilogb without the call; a subnormal number takes the long way. */
static inline int lemke_exponent(double v) {
  uint64_t bits;
  memcpy(&bits, &v, sizeof bits);
  const int e = (int)(bits >> 52 & 0x7ff);
  return (e == 0) ? ilogb(v) : e - 1023;
}

static inline double lemke_larger(double a, double b) { /* fmax, without its care for NaN */
  return (a > b) ? a : b;
}

static inline double lemke_smaller(double a, double b) {
  return (a < b) ? a : b;
}

double lemke_largest_of_many(const double *x, int n);

/* max |x_i|; of a few without a call. */
static inline double lemke_largest(const double *x, int n) {
  if (n > 8) {
    return lemke_largest_of_many(x, n);
  }
  double top = 0;
  for (int i = 0; i < n; ++i) {
    top = lemke_larger(fabs(x[i]), top);
  }
  return top;
}

/* (J u)_i of a factored M, scaled. Two chains run side by side. */
static inline double lemke_row_speed(const lemke_system *s, int i, const double *u) {
  double w[2] = {0, 0};
  int p = s->jptr[i];
  for (; p + 1 < s->jptr[i + 1]; p += 2) {
    w[0] += s->jval[p] * u[s->jdof[p]];
    w[1] += s->jval[p + 1] * u[s->jdof[p + 1]];
  }
  return w[0] + w[1] + ((p < s->jptr[i + 1]) ? s->jval[p] * u[s->jdof[p]] : 0);
}

/* r <- q' - (w' - M' z') by row, in extended precision, at the values x of the basic variables head (by position; z0
 * is no part of it); `sum` is scratch (rows). */
void lemke_system_defect(const lemke_system *s, const int *head, const double *x, long double *sum,
                         double *r);

/* rho of lcp_judge.h at a point: z' (rows; velocities beyond n are recomputed), of a view z itself. Of a factored M an
 * upper bound of it. Any scaling gives the same rho. *defect is max |min(z', w')|: q' is of size 1. */
double lemke_residual(const lemke_system *s, const double *z, double *defect);
