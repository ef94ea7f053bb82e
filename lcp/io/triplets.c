#include "lcp/io/triplets.h"

#include <stdlib.h>

static int by_column(const void *a, const void *b) {
  const lcp_triplet *x = a, *y = b;
  return (x->col != y->col) ? (x->col > y->col) - (x->col < y->col)
                            : (x->row > y->row) - (x->row < y->row);
}

base_status lcp_file_own(lcp_file_problem *f, void *p, const char *path, base_error *err) {
  if (p == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for its numbers", path);
  }
  f->owned[f->n_owned++] = p;
  return BASE_OK;
}

base_status lcp_from_triplets(const char *path, int n, lcp_triplet *e, size_t count,
                              lcp_file_problem *out, base_error *err) {
  qsort(e, count, sizeof *e, by_column);
  for (size_t k = 1; k < count; k++) {
    if (by_column(&e[k - 1], &e[k]) == 0) {
      return BASE_FAIL(err, BASE_EINVAL, "%s: entry (%d, %d) stands twice", path, e[k].row + 1,
                       e[k].col + 1);
    }
  }
  int *colptr = calloc((size_t)n + 1, sizeof *colptr);
  BASE_TRY(lcp_file_own(out, colptr, path, err));
  int *rowind = malloc((count + 1) * sizeof *rowind);
  BASE_TRY(lcp_file_own(out, rowind, path, err));
  double *val = malloc((count + 1) * sizeof *val);
  BASE_TRY(lcp_file_own(out, val, path, err));
  for (size_t k = 0; k < count; k++) {
    colptr[e[k].col + 1] = (int)k + 1;
    rowind[k] = e[k].row;
    val[k] = e[k].value;
  }
  for (int j = 0; j < n; j++) { /* empty columns start where the one before ended */
    colptr[j + 1] = (colptr[j + 1] > colptr[j]) ? colptr[j + 1] : colptr[j];
  }
  out->p.M = (lcp_matrix){.storage = LCP_CSC, .n = n, .csc = {n, n, colptr, rowind, val}};
  return BASE_OK;
}
