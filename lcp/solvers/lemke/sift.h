/* solvers/lemke/sift.h - a first basis for lemke where few bodies have many contacts. */
#pragma once

#include "lcp/solvers/lemke/path.h"

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
  lemke_system sub;      /* the problem of the set; its arrays: */
  lemke_store store;
  lemke_table *table; /* the two engines, of the solver */
  lemke_basis *basis;
  int retreats;    /* from the table to the basis */
  bool one_by_one; /* M not symmetric: a round takes in one contact, not one of every body */
  bool joined;     /* there are free rows: no table */
  int set_groups;  /* in the set */
  bool tabular;    /* the set is in the table, rows in the order they came */
  int table_rows;  /* most */
  int *group;      /* table rows: sub row -> contact */
  double *entry_column, *entry_row, *defect; /* table rows: scratch */
  double *reply, *back;                      /* n_dof, zero between calls: scratch */
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
 * LEMKE_SIFT_FAILED t->in_z means nothing. Sets of orthant rows run on the table as far as they fit, others, and what
 * the table cannot end (k->retreats), on the basis. Needs k->f. */
lemke_sift_end lemke_sift_run(lemke_sift *k, lemke_path *t, lemke_table *table, lemke_basis *basis,
                              const lemke_system *s, lemke_tolerance tol);

/* After LEMKE_SIFT_DONE with k->tabular: the solution of the basis found, refined in extended precision with
 * the inverse that the table holds, z scaled by row of s (velocities are not filled in). */
void lemke_sift_point(lemke_sift *k, const lemke_system *s, double *z);
