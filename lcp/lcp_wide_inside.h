/* lcp/lcp_wide_inside.h - what columns (lcp_wide_column.c) and sums over all of them (lcp_wide_sums.c) share. */
#pragma once

#include "lcp/lcp_wide_column.h"

/* A group beside another one, with its stored rows of J on the bodies of that; NULL: not there. */
typedef struct lcp_wide_neighbour {
  int group, first, rows;
  const double *jac[2];
} lcp_wide_neighbour;

/* Where groups between the same two bodies are summed. */
typedef struct lcp_wide_scratch {
  double *entry, *weighed;  /* per row; W J' */
  lcp_wide_neighbour *near; /* n_group: the groups at its bodies */
} lcp_wide_scratch;

enum {
  LCP_WIDE_LANES = 4,  /* columns that are summed side by side */
  LCP_WIDE_SHARE = 64, /* bodies or groups of one part of the work */
};

static inline int lcp_wide_padded(int rows) {
  return (rows + LCP_WIDE_LANES - 1) / LCP_WIDE_LANES * LCP_WIDE_LANES;
}

/* First of the rows of group g on body b (which g touches) that are stored. */
const double *lcp_wide_stored_on(const lcp_factored *f, int g, int b);

/* Row j of J on body b, which may be made in `room` (LCP_MIXED_MAX); NULL where it is zero. */
const double *lcp_wide_moved_by(const lcp_wide_columns *c, int j, int b, double *room);
