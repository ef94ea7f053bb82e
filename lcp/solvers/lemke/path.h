/* solvers/lemke/path.h - Lemke's complementary path with lexicographic choice (Lemke 1965; Cottle, Pang & Stone 1992,
 * algorithm 4.4.5 and section 4.9), on whatever engine holds the basis. */
#pragma once

#include "lcp/solvers/lemke/engine.h"

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
  LEMKE_BROKEN,  /* the engine cannot hold the basis */
} lemke_end;

typedef struct lemke_path {
  lemke_engine *engine;
  const lemke_system *system;
  lemke_tolerance tol;
  const double *d;      /* rows: column of the entering variable; the ray after LEMKE_RAY */
  double *room;         /* rows: d, where the engine has to compute it */
  double *lex;          /* rows: one column of the lexicographic matrix */
  long double *sum;     /* rows */
  int *first;           /* rows: variable of pair i in the first basis: the lexicographic columns */
  int *tied;            /* rows */
  unsigned char *in_z;  /* rows: first basis on entry, last basis on return */
  int entering;         /* variable that drives */
  uint64_t hash, noted; /* of the present basis, of one met before */
  long period, until_note;
  double
      deadline; /* [s]; negative until the first look at the clock, from which max_seconds count */
  double max_seconds;
  long pivot_limit;
  long pivots;
} lemke_path;

void lemke_path_layout(lemke_path *t, int rows, base_arena *a);

/* Is the time used up? A short path never asks: the clock costs as much as two of its pivots. */
bool lemke_path_late(lemke_path *t);

/* Pivots from the complementary basis in_z until the path ends. */
lemke_end lemke_path_run(lemke_path *t, lemke_engine *e, const lemke_system *s,
                         lemke_tolerance tol);

/* The same from the complementary basis that the engine holds; of s only rows and is_free are read unless the
 * tolerance is local. */
lemke_end lemke_path_go_on(lemke_path *t, lemke_engine *e, const lemke_system *s,
                           lemke_tolerance tol);

/* Makes z_i basic in the place of w_i in a basis without z0; false where it depends on the others. */
bool lemke_path_take(lemke_path *t, lemke_engine *e, int i);

/* Refines the values that the engine holds, z0 being zero, in extended precision. */
void lemke_path_refine(lemke_path *t, lemke_engine *e, const lemke_system *s);

/* Values of the basis in_z, refined `passes` times in extended precision. False where that basis is not to be had. */
bool lemke_path_settle(lemke_path *t, lemke_engine *e, const lemke_system *s, int passes);
