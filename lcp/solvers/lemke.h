/* solvers/lemke.h - parts of the lemke solver; included by solver_lemke.c and lemke_*.c only. */
#pragma once

#include "lcp/lcp_farkas.h"
#include "lcp/lcp_solver.h"
#include "lcp/linear/basis.h"

/* The problem as the pivots see it: M in columns, scaled by powers of two, with the body
 * velocities of a factored M as extra free rows. Notes on scaling: lemke_system.c. */
typedef struct lemke_system {
  int n; /* rows of the problem */
  int rows;
  int *colptr, *rowind;
  double *val;      /* of a factored M the entries of S come first in a column */
  int *jptr, *jdof; /* J of a factored M by rows, n+1 and its entries, scaled as val */
  double *jval;
  double *q;
  int q_exp;              /* q' = 2^(row_exp - q_exp) q, max |q'| in [1, 2) */
  int *row_exp, *col_exp; /* M' = 2^row_exp M 2^col_exp, z = 2^(q_exp + col_exp) z' */
  int *row_top, *col_top; /* scratch */
  double *diagonal;       /* of M', n */
  long double *w;         /* rows: scratch of lemke_residual, as the next three */
  long double *row_sum;
  double *tau0, *zref;
  unsigned char *is_free; /* w_i = 0, z_i unbounded */
  lcp_farkas_sum *force;  /* n_dof: scratch of lemke_farkas */
} lemke_system;

void lemke_system_layout(lemke_system *s, const lcp_capacity *cap, base_arena *a);
void lemke_system_build(lemke_system *s, const lcp_problem *p);

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

/* rho of lcp_judge.h at the scaled point z (rows; velocities beyond n are recomputed); for a
 * factored M an upper bound of it. Any scaling gives the same rho. *defect is max |min(z, w)| of the
 * scaled problem, whose q is of size 1. */
double lemke_residual(const lemke_system *s, const double *z, double *defect);

/* Relative sizes below which a pivot is taken for zero and a ratio for a tie. */
typedef struct lemke_tolerance {
  double pivot, tie;
  bool
      local; /* the cover is zero in rows that the first basis satisfies: a short path, no theorem */
} lemke_tolerance;

typedef enum lemke_end {
  LEMKE_SOLVED,  /* z0 = 0 in a complementary basis */
  LEMKE_RAY,     /* the driving variable is not blocked */
  LEMKE_LIMIT,   /* pivots used up */
  LEMKE_TIMEOUT, /* time used up */
  LEMKE_CYCLE,   /* a basis came back: round-off */
  LEMKE_BROKEN,  /* a basis could not be factored */
} lemke_end;

/* A small basis as a condensed tableau: B^-1 of every nonbasic column is there to be read. A pivot is
 * n^2 operations of the fastest kind and nothing is ever factored, but round-off adds up from pivot
 * to pivot: the values of the basis it ends in are to be computed again (lemke_table.c). */
typedef struct lemke_table {
  int cap, n;
  bool covered; /* z0 takes part: column n is in use */
  double *a;    /* cap x (cap+1) by columns: B^-1 of variable var[c], by row position */
  int *var;     /* cap+1 */
  int *column;  /* 2 cap+1: column of a variable, -1 where basic */
  double *part; /* cap: scratch */
  int *at;      /* cap: scratch */
} lemke_table;

typedef struct lemke_path {
  lin_system sys;
  lin_basis basis; /* of a tableau: head and where only */
  lemke_table table;
  bool tabular; /* the basis is in the table */
  const lemke_system *system;
  lemke_tolerance tol;
  double *x;         /* rows: basic values by position */
  double *d;         /* rows: column of the entering variable; the ray after LEMKE_RAY */
  double *lex;       /* rows: one column of the lexicographic matrix */
  double *cover;     /* rows */
  bool generic;      /* delta takes part */
  double *delta;     /* rows: B^-1 delta_rhs */
  double *delta_rhs; /* rows */
  long double *sum;  /* rows */
  int *first;        /* rows: variable of pair i in the first basis: the lexicographic columns */
  int *tied;         /* rows */
  unsigned char *may_leave; /* rows: by position, false where the basic variable is free */
  unsigned char *tried;     /* rows: pairs already used in repairing the first basis */
  unsigned char *in_z;      /* rows: first basis on entry, last basis on return */
  double size_d;            /* max |d| */
  int entering;             /* variable that drives */
  uint64_t hash, noted;     /* of the present basis, of one met before */
  long period, until_note;
  double deadline; /* [s] */
  long pivot_limit;
  long pivots;
} lemke_path;

/* rows and nnz of the largest system; table: rows of the table, 0 for none. */
void lemke_path_layout(lemke_path *t, int rows, int nnz, int table, base_arena *a);

/* Pivots from the complementary basis in_z until the path ends. */
lemke_end lemke_path_run(lemke_path *t, const lemke_system *s, lemke_tolerance tol);

/* The same on the table, from its basis; of s only n, rows and is_free are read. LEMKE_BROKEN also
 * where a pivot is doubtful. After any end but LEMKE_SOLVED the table is lost. */
lemke_end lemke_path_run_table(lemke_path *t, const lemke_system *s, lemke_tolerance tol);

/* The path from the basis of all w on the table, which it fills: for a system of at most table.cap rows,
 * none of them free. LEMKE_BROKEN also where a pivot is doubtful; a ray is one of the table, not proved by
 * a factorisation. */
lemke_end lemke_path_run_small(lemke_path *t, const lemke_system *s, lemke_tolerance tol);

/* Makes z_i of the table basic in the place of w_i; false where that pivot is doubtful. */
bool lemke_path_take(lemke_path *t, const lemke_system *s, int i);

/* B^-1 of a nonbasic variable, by position; valid until the next call. */
const double *lemke_path_column(lemke_path *t, int var);

/* Solution of the basis in_z, refined in extended precision: values by position in t->x. False when
 * that basis is singular. */
bool lemke_path_settle(lemke_path *t, const lemke_system *s);

/* y >= 0, M'y <= 0, q'y < 0 from the ray of the path, into y (by row of the problem). True only when the
 * three hold exactly for the binary numbers of the problem. */
bool lemke_farkas(const lemke_path *t, const lemke_system *s, const lcp_problem *p, double *y);

/* lemke_table.c: a table grows by rows whose w is basic, between paths. */

void lemke_table_layout(lemke_table *b, int cap, base_arena *a);

/* The basis of all w of a system of at most cap rows, with its x. */
void lemke_table_fill(lemke_path *t, const lemke_system *s);
void lemke_table_clear(lemke_path *t);

/* Pair n: column[0..n] and row[0..n] are M_in and M_ni for i = 0..n, q is q_n. Updates x. Needs n < cap. */
void lemke_table_append(lemke_path *t, const double *column, const double *row, double q);

/* Brings z0 in, with B^-1 of its column in d; takes it out again once it is nonbasic. */
void lemke_table_cover(lemke_path *t, const double *d);
void lemke_table_uncover(lemke_path *t);

/* `entering`, whose column is d, takes position p. */
void lemke_table_replace(lemke_path *t, int p, int entering, const double *d);

/* lemke_ratio.c */

static inline double lemke_larger(double a, double b) { /* fmax, without its care for NaN */
  return (a > b) ? a : b;
}

double lemke_largest(const double *x, int n); /* max |x_i| */

/* Drops from t->tied[0..count) all but the lexicographically smallest row of [delta, B^-1 B_first] / d, which
 * it returns: any matrix with lexicographically positive rows ends the path (Cottle, Pang & Stone 1992,
 * 4.9). The generic column delta, used on larger problems, decides almost every tie in one comparison. */
int lemke_break_ties(lemke_path *t, int count);

/* Position of the basic variable that blocks the entering one, or -1 for a ray. Ratios that agree
 * up to the round-off in x are ties (the bound of Harris 1973). */
int lemke_ratio_test(lemke_path *t);

/* How far below zero basic variable i counts as zero; `common` where the path is not local. */
double lemke_slack(const lemke_path *t, int i, double common);
