#include "harness/cell/outliers.h"

#include "harness/cell/stats.h"

#include <math.h>

enum { OUTLIER_ROWS = 512 };

int outliers_flag(record *row, int n) {
  double x[OUTLIER_ROWS];
  double away[OUTLIER_ROWS];
  int timed = 0;
  for (int i = 0; i < n && timed < OUTLIER_ROWS; i++) {
    if (row[i].t_total_s > 0.0) {
      x[timed++] = row[i].t_total_s;
    }
  }
  if (timed < 5) {
    return 0;
  }
  stats_sort(x, timed);
  const double median = stats_median(x, timed);
  for (int i = 0; i < timed; i++) {
    away[i] = fabs(x[i] - median);
  }
  stats_sort(away, timed);
  const double mad = stats_median(away, timed);
  int far = 0;
  for (int i = 0; mad > 0.0 && i < n; i++) {
    if (0.6745 * fabs(row[i].t_total_s - median) / mad > 3.5) {
      record_flag(&row[i], "outlier");
      far++;
    }
  }
  return far;
}
