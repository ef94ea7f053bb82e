#include "lcp/solvers/interval_map.h"

#include <math.h>

/* a + b - sqrt(a^2 + b^2) without cancellation, and its gradient; at the origin the element of
 * (1, 1)/sqrt(2) direction. */
static double fischer(double a, double b, double *ga, double *gb) {
  const double r = hypot(a, b);
  *ga = (r > 0.0) ? 1.0 - a / r : 1.0 - sqrt(0.5);
  *gb = (r > 0.0) ? 1.0 - b / r : 1.0 - sqrt(0.5);
  return (a > 0.0 && b > 0.0) ? 2.0 * a * b / (a + b + r) : a + b - r;
}

static double minimum(double a, double b, double *ga, double *gb) {
  *ga = (a < b) ? 1.0 : 0.0;
  *gb = 1.0 - *ga;
  return fmin(a, b);
}

double lcp_interval_map(lcp_map map, double lo, double hi, double x, double y, double *dx,
                        double *dy) {
  double (*const phi)(double, double, double *, double *) =
      (map == LCP_MAP_FISCHER) ? fischer : minimum;
  if (lo == -HUGE_VAL && hi == HUGE_VAL) {
    *dx = 0.0;
    *dy = 1.0;
    return y;
  }
  if (hi == HUGE_VAL) {
    return phi(x - lo, y, dx, dy);
  }
  double inner_x, inner_y, outer_x, outer_y;
  const double inner = phi(hi - x, -y, &inner_x, &inner_y);
  if (lo == -HUGE_VAL) {
    *dx = inner_x;
    *dy = inner_y;
    return -inner;
  }
  const double F = phi(x - lo, -inner, &outer_x, &outer_y);
  *dx = outer_x + outer_y * inner_x;
  *dy = outer_y * inner_y;
  return F;
}
