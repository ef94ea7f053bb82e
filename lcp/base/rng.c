#include "lcp/base/rng.h"

#include <math.h>

double base_rng_normal(base_rng *r) {
  const double two_pi = 6.283185307179586;
  const double u = 1.0 - base_rng_uniform(r); /* in (0, 1] */
  const double v = base_rng_uniform(r);
  return sqrt(-2.0 * log(u)) * cos(two_pi * v);
}
