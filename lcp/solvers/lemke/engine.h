/* solvers/lemke/engine.h - what a path asks of a basis of  w' - M' z' - d z0 = q',  and the two ways to hold one.
 *
 *   table   all of B^-1 N, updated in every pivot (linear/tableau.h): small systems without free rows
 *   basis   a factorisation of the kernel and product-form updates (linear/basis.h): any system
 *
 * Variables: w_i = i, z_j = n + j, z0 = 2n; a position is the row of the basis that a basic variable stands for.
 * Where an engine cannot go on it says so; who asked it decides on another, and counts that. */
#pragma once

#include "lcp/linear/basis.h"
#include "lcp/linear/tableau.h"
#include "lcp/solvers/lemke/system.h"

typedef struct lemke_engine lemke_engine;

typedef struct lemke_engine_kind {
  const char *word; /* in `variant` */

  /* The complementary basis of in_z, with its values; dependent columns are replaced, also in in_z. False where that is
   * not to be had. */
  bool (*fill)(lemke_engine *e, const lemke_system *s, unsigned char *in_z);

  /* Brings z0 in as nonbasic, with B^-1 of its column in d, and carries e->delta along if e->generic. */
  void (*open)(lemke_engine *e, const double *d);

  /* B^-1 of a nonbasic column by position: in `room` (n), or where the engine has it. Valid until the next
   * replace. */
  const double *(*column)(lemke_engine *e, int var, double *room);

  /* The variable `entering`, of column d, takes position p. False: the new basis could not be held. */
  bool (*replace)(lemke_engine *e, int p, int entering, const double *d);

  /* Pair n joins, w_n basic: column[0..n], row[0..n] of M' and q'_n. NULL: an engine that cannot grow. */
  void (*append)(lemke_engine *e, const double *column, const double *row, double q);

  /* x <- x + B^-1 r; r by row is overwritten. */
  void (*settle)(lemke_engine *e, double *r);
} lemke_engine_kind;

struct lemke_engine {
  const lemke_engine_kind *kind;
  const lemke_system *system; /* whose basis it is */
  int edition;
  int n;
  const int *head, *where; /* variable in a position; position of a variable or -1 */
  double *x;               /* values of the basic variables, by position */
  bool generic;
  double *delta; /* values by position for another right-hand side: breaks ties */
};

typedef struct lemke_table {
  lemke_engine engine; /* first: an engine is a table */
  lin_tableau tableau;
} lemke_table;

/* For systems of at most `rows` rows without free ones. */
void lemke_table_layout(lemke_table *t, int rows, base_arena *a);

/* Begins a system that grows by append. */
void lemke_table_clear(lemke_table *t);

typedef struct lemke_basis {
  lemke_engine engine; /* first: an engine is a basis */
  lin_basis basis;
  lin_system sys;
  double *cover;        /* rows */
  double *delta_rhs;    /* rows */
  double *work;         /* rows */
  long double *sum;     /* rows */
  unsigned char *tried; /* rows: pairs already used in repairing the first basis */
} lemke_basis;

/* rows and nnz of the largest system. */
void lemke_basis_layout(lemke_basis *b, int rows, int nnz, base_arena *a);

/* The basis of in_z is there already. */
static inline bool lemke_engine_holds(const lemke_engine *e, const lemke_system *s,
                                      const unsigned char *in_z) {
  const int n = s->rows;
  bool same = e->system == s && e->edition == s->edition && e->n == n && e->where[2 * n] < 0;
  for (int i = 0; i < n && same; ++i) {
    same = (e->where[n + i] >= 0) == (in_z[i] != 0);
  }
  return same;
}

/* What the engine holds is of no use any more. */
static inline void lemke_engine_forget(lemke_engine *e) {
  e->system = NULL;
}
