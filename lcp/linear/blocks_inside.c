#include "lcp/linear/blocks_inside.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

base_status lin_blocks_memory(lin_blocks *s, void **mem, void (*layout)(lin_blocks *, base_arena *),
                              base_error *err) {
  base_arena measure = base_arena_measuring();
  layout(s, &measure);
  free(*mem);
  *mem = measure.overflow ? NULL : base_alloc(measure.used > 0 ? measure.used : 1);
  if (*mem == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a factor of %d blocks", s->cap_n);
  }
  base_arena real = base_arena_over(*mem, measure.used);
  layout(s, &real);
  return BASE_OK;
}

/* A = L L' in the lower triangle. */
static bool cholesky(int n, double *A, lin_span *pivots) {
  for (int k = 0; k < n; k++) {
    double pivot = A[k + k * n];
    for (int j = 0; j < k; j++) {
      pivot -= A[k + j * n] * A[k + j * n];
    }
    if (!(pivot > 0)) {
      return false;
    }
    pivots->low = fmin(pivots->low, pivot);
    pivots->high = fmax(pivots->high, pivot);
    const double root = sqrt(pivot);
    A[k + k * n] = root;
    for (int i = k + 1; i < n; i++) {
      double v = A[i + k * n];
      for (int j = 0; j < k; j++) {
        v -= A[i + j * n] * A[k + j * n];
      }
      A[i + k * n] = v / root;
    }
  }
  return true;
}

/* P A = L U in place, L with a unit diagonal; swap[k]: row exchanged with row k. */
static bool lu(int n, double *A, int *swap, lin_span *pivots) {
  for (int k = 0; k < n; k++) {
    int p = k;
    for (int i = k + 1; i < n; i++) {
      p = (fabs(A[i + k * n]) > fabs(A[p + k * n])) ? i : p;
    }
    swap[k] = p;
    for (int j = 0; j < n && p != k; j++) {
      const double x = A[p + j * n];
      A[p + j * n] = A[k + j * n];
      A[k + j * n] = x;
    }
    const double pivot = A[k + k * n];
    if (!(fabs(pivot) > 0)) {
      return false;
    }
    pivots->low = fmin(pivots->low, fabs(pivot));
    pivots->high = fmax(pivots->high, fabs(pivot));
    for (int i = k + 1; i < n; i++) {
      A[i + k * n] /= pivot;
    }
    for (int j = k + 1; j < n; j++) {
      for (int i = k + 1; i < n; i++) {
        A[i + j * n] -= A[i + k * n] * A[k + j * n];
      }
    }
  }
  return true;
}

bool lin_blocks_pivot(const lin_blocks *s, int n, double *D, int *swap, lin_span *pivots) {
  return s->symmetric ? cholesky(n, D, pivots) : lu(n, D, swap, pivots);
}
