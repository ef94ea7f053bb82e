/* problems/families/triplets.h - a sparse matrix collected entry by entry, then compressed by columns. */
#pragma once

#include "problems/families/known_lcp.h"

#include <stdint.h>

typedef struct triplets {
  int n_row, n_col, count, cap;
  int *row, *col;
  double *val;
} triplets;

/* Room for cap entries; freed with triplets_free. */
base_status triplets_open(triplets *t, int n_row, int n_col, int cap, base_error *err);
void triplets_free(triplets *t);
/* Never more than cap calls; indices in range. */
void triplets_add(triplets *t, int row, int col, double val);

/* Sums duplicates into sorted columns; out owns its arrays (lcp_csc_free). */
base_status triplets_to_csc(const triplets *t, lcp_csc *out, base_error *err);
/* The same into a fresh square problem k with q = 0. */
base_status triplets_compress(const triplets *t, known_lcp *k, base_error *err);

/* Random complementary pair: a share `active` of the unknowns has z in (0.5, 1.5), the others w;
 * q = w - M z. Sets the answer to `answer`. */
base_status plant_random(known_lcp *k, double active, uint64_t seed, known_answer answer,
                         base_error *err);
