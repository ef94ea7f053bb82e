/* formulations/dof_kernel.h - loops over the dofs of one body: written once for any number, and inlined for
 * the usual 6 and 3, where the compiler then knows their length. */
#pragma once

#include <stddef.h>

/* F(..., n) with a literal n where it is 6 or 3. */
#define FORM_WITH_DOFS(n, F, ...)                                                                  \
  (((n) == 6) ? F(__VA_ARGS__, 6) : ((n) == 3) ? F(__VA_ARGS__, 3) : F(__VA_ARGS__, (n)))

/* sum of x y */
static inline double form_dot(const double *x, const double *y, int n) {
  double sum = 0;
  for (int k = 0; k < n; k++) {
    sum += x[k] * y[k];
  }
  return sum;
}

/* The same for long vectors: four sums that need not wait for one another. */
static inline double form_long_dot(const double *x, const double *y, int n) {
  double sum[4] = {0};
  int k = 0;
  for (; k + 4 <= n; k += 4) {
    for (int m = 0; m < 4; m++) {
      sum[m] += x[k + m] * y[k + m];
    }
  }
  return (sum[0] + sum[1]) + (sum[2] + sum[3]) + form_dot(x + k, y + k, n - k);
}

/* out += s x */
static inline void form_add_scaled(double s, const double *restrict x, double *restrict out,
                                   int n) {
  for (int k = 0; k < n; k++) {
    out[k] += s * x[k];
  }
}

/* out += W x, W symmetric n x n and read by columns, so that the sums of neighbours go side by side. */
static inline void form_add_product(const double *restrict W, const double *restrict x,
                                    double *restrict out, int n) {
  for (int k = 0; k < n; k++) {
    double sum = out[k];
    for (int j = 0; j < n; j++) {
      sum += x[j] * W[(ptrdiff_t)j * n + k];
    }
    out[k] = sum;
  }
}
