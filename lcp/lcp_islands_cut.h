/* lcp/lcp_islands_cut.h - finds the islands of a problem and cuts them out. Private to lcp_islands*.c. */
#pragma once

#include "lcp/lcp_problem.h"

typedef struct islands_part {
  lcp_problem
      p; /* views of the arrays of islands_cut, or the whole problem where it is one island */
  lcp_factored factored;
  lcp_csc shift;
  double *z;      /* n: start point in */
  const int *row; /* n: rows of the whole, ascending; NULL where it is all of them */
} islands_part;

typedef struct islands_cut {
  int count;
  islands_part *island; /* cap_island, owned */
  int *by_size;         /* count: the largest first, for threads */
  /* of the whole, by block (a row each where there are none), then body */
  int *root;     /* n_node: an earlier node of the same island, or itself */
  int *number;   /* n_node: the island of a root */
  int *block_of; /* n: node of a row */
  int *row;      /* n: rows by island */
  int *local;    /* n: place of a row in its island */
  int *place;    /* n_body: of a body in its island */
  /* of the islands, side by side */
  lcp_block *block;
  double *q, *lo, *hi, *z, *val, *jac, *weight;
  int *colptr, *rowind, *dof_start, *weight_start, *row_start, *body, *jac_start;
  int *jac_at; /* n_group of the whole: where J of a group lies in jac */
  int n_node, cap_island;
  lcp_capacity cap; /* what the arrays hold */
  size_t cap_val;
  int cap_group;
  void *mem; /* owned */
} islands_cut;

/* by_factors: of a sparse matrix with factors beside it these are cut out; else what is stored. z[n]: start points go
 * with the islands. BASE_ENOMEM only. */
base_status lcp_islands_cut_problem(islands_cut *s, const lcp_problem *p, bool by_factors,
                                    double *z, base_error *err);

/* to[rows of island k] = from. */
void lcp_islands_cut_out(const islands_cut *s, int k, const double *from, double *to);

void lcp_islands_cut_close(islands_cut *s); /* accepts zeroes */
