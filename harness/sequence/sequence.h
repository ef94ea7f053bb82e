/* harness/sequence/sequence.h - complementarity problems in the order in which a simulation poses them, each with the answer
 * that the run took and with whose its rows are, so that a row is found again in the problem before.
 *
 * A row is named by its contact's id (or its joint) and its place among the rows of that contact. It is active where its
 * unknown is not at a bound: z_i > 0 on an orthant, lo_i < z_i < hi_i on a box, always where it is free, and all rows of a
 * cone whose normal impulse is above zero. */
#pragma once

#include "harness/measure/simulate.h"

/* Ids from here on are joints, in their order; no contact has one. */
#define SEQUENCE_JOINT (UINT64_MAX - 0xfffff)

typedef struct sequence_item {
  long step;                     /* from 1 */
  int solve;                     /* within the step, from 1 */
  lcp_problem p;                 /* views of the arrays below; factors are multiplied out */
  double *val, *q, *lo, *hi, *z; /* z: the run's answer */
  lcp_csc csc;
  lcp_block *block;
  int n_owner;
  uint64_t *owner;       /* n_owner, ascending: contacts by id, then joints */
  int *first;            /* n_owner+1: rows first[k] .. first[k + 1] - 1 */
  unsigned char *active; /* n */
  run_status status;
  bool verified; /* status ok, and rho within the tolerance of the solver's kind */
  double rho;
  int n_active;
  int n_changed; /* rows, by id, that are active in one of this problem and the one before; of the first: n_active */
  double change; /* n_changed over the rows that are active in either; 0: none is [1] */
} sequence_item;

enum { SEQUENCE_TEXT = 320 };

typedef struct sequence {
  char scene[SEQUENCE_TEXT], formulation[SEQUENCE_TEXT], solver[SEQUENCE_TEXT]; /* as typed */
  double h;                                                                     /* [s] */
  long count, steps; /* asked for, taken */
  run_status status; /* of the run that posed them, and its first trouble */
  char note[240];
  int n, cap;
  sequence_item *item; /* owned */
} sequence;

/* Appends a copy of what was solved; k->rows says whose its rows are. */
base_status sequence_put(sequence *q, const sim_solved *k, base_error *err);
/* The same from names in place of k->rows: owner[n_owner] ascending with first[n_owner + 1]. BASE_EINVAL: they are not, or do
 * not cover the rows. */
base_status sequence_put_named(sequence *q, const sim_solved *k, int n_owner, const uint64_t *owner,
                               const int *first, base_error *err);
void sequence_free(sequence *q);

/* from[n of now]: the row of `before` with the same name; -1: there is none, or its contact had another number of rows. */
void sequence_match(const sequence_item *now, const sequence_item *before, int *from);

int sequence_largest(const sequence *q); /* most unknowns of a problem; 0: there is no problem */
/* Mean of `change` over the problems behind the first [1]; NaN: there are none. */
double sequence_change(const sequence *q);
