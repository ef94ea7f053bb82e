/* problems/broad_phase.h - pairs of balls that may touch, in time and memory linear in their
 * number for balls of similar size.
 *
 * Uniform grid: a ball sits in the cell of its centre, cells are as wide as the largest small
 * ball's diameter, so partners are in neighbouring cells. Balls much larger than the typical one
 * are compared with all others. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>

typedef struct broad_ball {
  double x[3];
  double r; /* bounding radius with the margin of this step [m] */
} broad_ball;

typedef struct broad_pair {
  int a, b; /* a < b */
} broad_pair;

typedef struct broad_phase {
  int n, cap;
  broad_ball *ball; /* n; the caller fills it after broad_reserve */
  int n_pair, cap_pair;
  broad_pair *pair; /* result, in no particular order but always the same one */
  int cap_bucket;
  int *head, *next, *cell, *large; /* bucket heads, chains, 3 cell coordinates a ball */
} broad_phase;

base_status broad_reserve(broad_phase *bp, int n, base_error *err);
void broad_close(broad_phase *bp);

/* Fills pair with all a < b whose balls overlap. */
base_status broad_find(broad_phase *bp, int dim, base_error *err);
