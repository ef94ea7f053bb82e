/* solvers/lemke_sift.h - a first basis for lemke where few bodies have many contacts. */
#pragma once

#include "lcp/solvers/lemke.h"

/* Of the contacts of few bodies hardly any carry a normal impulse: at most as many as their velocities,
 * in a basic solution. So Lemke's path is run on a growing set of contacts, from the basis it ended in
 * before, until no contact left out is violated (sifting: Bixby, Gregory, Lustig, Marsten & Shanno 1992,
 * for linear programs). Pivots then grow with the bodies, not with the contacts; a round costs one
 * pass over J. */
typedef struct lemke_sift {
  const lcp_factored *f;
  int *helper;   /* n: row whose unknown alone can keep w_i >= 0; SIFT_PRICED or SIFT_HELPER */
  double *gain;  /* n: entry of M that helper has in row i */
  double *u;     /* n_dof: velocities of the last round, scaled */
  int *worst;    /* n_body: group most violated, or -1 */
  double *depth; /* n_body: its w, scaled */
  unsigned char *inside; /* n_group: in the set */
  unsigned char *chosen; /* n: z_i basic */
  int *row, *local;      /* sub row -> row; row -> sub row, of those in the set only: n each */
  lemke_system sub;      /* the problem of the set: w, tau0, zref, diagonal are not carved */
  bool one_by_one;       /* M not symmetric: a round takes in one contact, not one of every body */
  int set_groups;        /* in the set */
  bool tabular;          /* the set is in the table of the path, rows in the order they came */
  int table_rows;        /* most */
  int *group;            /* table rows: sub row -> contact */
  double *entry_column, *entry_row; /* table rows: scratch */
  double *reply, *back;             /* n_dof, zero between calls: scratch */
} lemke_sift;

/* Rows of the table for sets of at most `most` rows. */
static inline int lemke_sift_table_rows(const lcp_capacity *cap, int most) {
  return (cap->n_dof == 0) ? 0 : (cap->n < most) ? cap->n : most;
}

void lemke_sift_layout(lemke_sift *k, const lcp_capacity *cap, int table, base_arena *a);

/* After lemke_system_build. Leaves k->f NULL where contacts are few for the velocities, or S joins rows of
 * different contacts. */
void lemke_sift_prepare(lemke_sift *k, const lemke_system *s, const lcp_problem *p);

typedef enum lemke_sift_end {
  LEMKE_SIFT_DONE,   /* no contact left out is violated */
  LEMKE_SIFT_WIDE,   /* the set became half of all contacts: not worth going on */
  LEMKE_SIFT_FAILED, /* a round did not end in a solution */
} lemke_sift_end;

/* Rounds from the basis t->in_z (rows of s), whose place the basis found takes, in all rows; after
 * LEMKE_SIFT_FAILED t->in_z means nothing. Needs k->f. */
lemke_sift_end lemke_sift_run(lemke_sift *k, lemke_path *t, const lemke_system *s,
                              lemke_tolerance tol);

/* After LEMKE_SIFT_DONE with k->tabular: the solution of the basis found, refined in extended precision with
 * the inverse that the table holds, z scaled by row of s (velocities are not filled in). */
void lemke_sift_point(lemke_sift *k, lemke_path *t, const lemke_system *s, double *z);

/* lemke_sift_table.c, for lemke_sift.c */

/* Begins a set in the table of t. */
void lemke_sift_open_table(lemke_sift *k, lemke_path *t, const lemke_system *s);

/* Takes contact g in, with the z that are `chosen` basic where independent. False, with the table lost, when it
 * does not fit or has a free row. */
bool lemke_sift_append(lemke_sift *k, lemke_path *t, const lemke_system *s, int g);

/* A path on the table; chosen and u follow. False when it did not end in a solution, or in one with too much
 * round-off. */
bool lemke_sift_follow_table(lemke_sift *k, lemke_path *t, const lemke_system *s,
                             lemke_tolerance tol);
