#include "problems/families/known_lcp.h"

#include "lcp/lcp_column.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void known_lcp_free(known_lcp *k) {
  for (int i = 0; i < k->n_owned; i++) {
    free(k->owned[i]);
  }
  memset(k, 0, sizeof *k);
}

void *known_take(known_lcp *k, size_t count, size_t size) {
  if (k->n_owned == KNOWN_OWNED || count > SIZE_MAX / size - 1) {
    return NULL;
  }
  void *mem = calloc(count + 1, size); /* an empty array is not an error */
  if (mem != NULL) {
    k->owned[k->n_owned++] = mem;
  }
  return mem;
}

base_status known_dense(known_lcp *k, int n, double **M, double **q, base_error *err) {
  *M = KNOWN_ARRAY(k, double, (size_t)n *(size_t)n);
  *q = KNOWN_ARRAY(k, double, n);
  if (*M == NULL || *q == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "n = %d: no memory for the dense matrix", n);
  }
  k->p.M = (lcp_matrix){.storage = LCP_DENSE, .n = n, .val = *M};
  k->p.q = *q;
  return BASE_OK;
}

base_status known_sparse(known_lcp *k, int n, int nnz, int **colptr, int **rowind, double **val,
                         double **q, base_error *err) {
  *colptr = KNOWN_ARRAY(k, int, n + 1);
  *rowind = KNOWN_ARRAY(k, int, nnz);
  *val = KNOWN_ARRAY(k, double, nnz);
  *q = KNOWN_ARRAY(k, double, n);
  if (*colptr == NULL || *rowind == NULL || *val == NULL || *q == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "n = %d: no memory for %d entries", n, nnz);
  }
  k->p.M = (lcp_matrix){.storage = LCP_CSC, .n = n, .csc = {n, n, *colptr, *rowind, *val}};
  k->p.q = *q;
  return BASE_OK;
}

static void product(const lcp_matrix *M, const double *x, double *y) {
  for (int j = 0; j < M->n; j++) {
    lcp_column_add(lcp_column_of(M, j), x[j], y);
  }
}

base_status known_plant(known_lcp *k, const double *z, const double *w, base_error *err) {
  const int n = k->p.M.n;
  k->z = KNOWN_ARRAY(k, double, n);
  k->w = KNOWN_ARRAY(k, double, n);
  double *q = KNOWN_ARRAY(k, double, n);
  if (k->z == NULL || k->w == NULL || q == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "n = %d: no memory for the solution", n);
  }
  memcpy(k->z, z, (size_t)n * sizeof *z);
  memcpy(k->w, w, (size_t)n * sizeof *w);
  product(&k->p.M, z, q);
  for (int i = 0; i < n; i++) {
    q[i] = w[i] - q[i];
  }
  k->p.q = q;
  return BASE_OK;
}
