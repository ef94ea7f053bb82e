/* lcp/io/triplets.h - the entries of a matrix, in whatever order a file has them. */
#pragma once

#include "lcp/io/lcp_read.h"

typedef struct lcp_triplet {
  int row, col; /* from 0 */
  double value;
} lcp_triplet;

/* Makes out->p.M of them: LCP_CSC, n x n, columns with increasing rows; e is sorted. BASE_EINVAL: an entry stands
 * twice; path is named. */
base_status lcp_from_triplets(const char *path, int n, lcp_triplet *e, size_t count,
                              lcp_file_problem *out, base_error *err);

/* out owns p from now on. BASE_ENOMEM: p is NULL. */
base_status lcp_file_own(lcp_file_problem *f, void *p, const char *path, base_error *err);
