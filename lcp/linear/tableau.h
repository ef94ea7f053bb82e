/* linear/tableau.h - a small basis of  w - M z - d z0 = q  as a condensed tableau (Dantzig 1963, ch. 8): B^-1 of
 * every nonbasic column is there to be read.
 *
 * A pivot is n^2 operations of the fastest kind and nothing is ever factored, but round-off adds up from
 * pivot to pivot: values that a claim rests on are to be corrected by what the data say. A tableau grows by
 * rows whose w is basic. The counterpart for large bases is basis.h.
 */
#pragma once

#include "lcp/base/arena.h"

#include <stdbool.h>
#include <stddef.h>

/* Variables: w_i = i, z_j = n + j, z0 = 2n. */
typedef struct lin_tableau {
  int cap, n;
  int stride;   /* entries from one column to the next, a multiple of 4; those from n on are zero */
  bool covered; /* z0 takes part: column n is in use */
  bool generic; /* delta is carried */
  double least_pivot; /* smallest |pivot| since the start; HUGE_VAL before the first */
  int due;            /* position of a pivot that the columns still have to follow; -1: none */
  int due_column;     /* and the column it exchanged */
  double *a;          /* by columns: B^-1 of variable var[c], by row position */
  double *x;          /* cap: B^-1 q, the values of the basic variables; before a, and before it */
  double *delta;      /* cap: the values for another right-hand side */
  int *var;           /* cap + 1 */
  int *column;        /* 2 cap + 1: column of a variable, -1 where basic */
  int *head;          /* cap: variable in each row position */
  int *where;         /* 2 cap + 1: row position of a variable, -1 where nonbasic */
  double *entry;      /* cap: scratch */
  int *at;            /* cap: scratch */
  double *rhs;        /* cap: scratch */
  double *block;      /* where the columns lie */
} lin_tableau;

void lin_tableau_layout(lin_tableau *b, int cap, base_arena *a);

/* Entries of column c, writable. */
static inline double *lin_tableau_entries(const lin_tableau *b, int c) {
  return b->a + (ptrdiff_t)c * b->stride;
}

/* The basis of all w, n <= cap rows. Column j, of z_j, is the caller's to write: -M_j, in whole (n entries), as is
 * x = q. n = 0 begins a tableau that grows. */
void lin_tableau_start(lin_tableau *b, int n);

/* Pair n joins with w_n basic: column[0..n] and row[0..n] are M_in and M_ni for i = 0..n, q is q_n. Needs n < cap and a
 * tableau begun with n = 0. */
void lin_tableau_append(lin_tableau *b, const double *column, const double *row, double q);

/* Brings z0 in as a nonbasic variable, with B^-1 of its column in d; a z0 that is nonbasic already is replaced. */
void lin_tableau_cover(lin_tableau *b, const double *d);

/* B^-1 of the nonbasic variable `var`, by position. */
static inline const double *lin_tableau_column(const lin_tableau *b, int var) {
  return lin_tableau_entries(b, b->column[var]);
}

/* x <- x + B^-1 r, r by row. */
void lin_tableau_correct(const lin_tableau *b, const double *r);

/* The nonbasic variable `entering` takes position p. */
void lin_tableau_replace(lin_tableau *b, int p, int entering);

/* The same for the last pivot of a path, after which most often only the values are asked for: the columns follow in
 * lin_tableau_finish, which is to be called before any of them is read. */
void lin_tableau_replace_last(lin_tableau *b, int p, int entering);
void lin_tableau_finish(lin_tableau *b);
