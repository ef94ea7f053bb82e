/* lcp/share/lcp_share_facets.h - the parts of a contact block of facets. Private to lcp_share*.c. */
#pragma once

#include "lcp/lcp_column.h"
#include "lcp/share/lcp_share_state.h"

typedef struct share_facets {
  int first, count, speed; /* unknowns: facets, then the slip speed of the part */
} share_facets;

static inline share_facets lcp_share_facets(const lcp_block *b, int part) {
  share_facets f = {.first = b->start + 1, .speed = b->start + b->size - b->n_part + part};
  for (int k = 0; k < part; k++) {
    f.first += b->part_dim[k];
  }
  f.count = b->part_dim[part];
  return f;
}

static inline bool lcp_share_is_faceted(const lcp_block *b) {
  return b->set == LCP_ORTHANT && b->n_part > 0;
}

/* Coefficient of the slip speed in the rows of its facets; one value for all of them. */
static inline double lcp_share_speed_unit(const lcp_share *s, share_facets f) {
  const lcp_column c = lcp_column_of(&s->M, f.speed);
  for (int k = 0; k < c.count; k++) {
    const int row = lcp_column_row(&c, k);
    if (row >= f.first && row < f.first + f.count) {
      return c.val[k];
    }
    if (c.row == NULL && row < f.first) { /* dense: straight to the row */
      k = f.first - 1;
    }
  }
  return 0;
}
