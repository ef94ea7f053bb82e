#include "harness/cell/stats.h"

#include <math.h>
#include <stdlib.h>

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a;
  const double y = *(const double *)b;
  return (x > y) - (x < y);
}

void stats_sort(double *x, int n) {
  qsort(x, (size_t)n, sizeof *x, ascending);
}

double stats_median(const double *sorted, int n) {
  return stats_quantile(sorted, n, 0.5);
}

void stats_median_interval(const double *sorted, int n, double *lo, double *hi) {
  int k = (int)floor((n - 1.96 * sqrt((double)n)) / 2.0); /* 0-based rank of the lower end */
  k = (k > 0) ? k - 1 : 0;
  *lo = (n > 0) ? sorted[k] : (double)NAN;
  *hi = (n > 0) ? sorted[n - 1 - k] : (double)NAN;
}

double stats_half_width(double *x, int n) {
  double lo;
  double hi;
  stats_sort(x, n);
  stats_median_interval(x, n, &lo, &hi);
  const double median = stats_median(x, n);
  return (n < 2 || !(median > 0.0)) ? HUGE_VAL : 0.5 * (hi - lo) / median;
}

double stats_quantile(const double *sorted, int n, double p) {
  if (n <= 0) {
    return (double)NAN;
  }
  const double at = p * (n - 1);
  const int i = (int)floor(at);
  const int j = (i + 1 < n) ? i + 1 : i;
  return sorted[i] + (at - i) * (sorted[j] - sorted[i]);
}
