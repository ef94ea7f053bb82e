#include "formulations/penalty_law.h"

#include <math.h>

/* Root of x (1 + e) = ln((1 + x) / (1 - x e)) in (0, 1/e), by bisection: left less right is negative beyond it, positive before. */
static double gonthier(double e) {
  const double least = 0.01;
  e = fmax(e, least);
  if (e >= 1.0) {
    return 0.0;
  }
  double low = 0.0, high = 1.0 / e;
  for (int k = 0; k < 200 && high - low > 4e-16 * high; k++) {
    const double x = 0.5 * (low + high);
    const double over = x * (1.0 + e) - log1p(x) + log1p(-x * e);
    low = (over > 0.0) ? x : low;
    high = (over > 0.0) ? high : x;
  }
  return 0.5 * (low + high);
}

double penalty_damping(penalty_model model, double e) {
  switch (model) {
  case PENALTY_HUNT_CROSSLEY:
    return 1.5 * (1.0 - e);
  case PENALTY_LANKARANI_NIKRAVESH:
    return 0.75 * (1.0 - e * e);
  case PENALTY_GONTHIER:
    return gonthier(e);
  case PENALTY_HERTZ:
  case PENALTY_KELVIN_VOIGT:
    break;
  }
  return 0.0;
}

double penalty_normal_force(penalty_model model, double K, double c, double x, double v_i, double d,
                            double v) {
  if (d <= 0.0) {
    return 0.0;
  }
  const double force =
      (model == PENALTY_KELVIN_VOIGT) ? K * d + c * v : K * d * sqrt(d) * (1.0 + x * v / v_i);
  return fmax(force, 0.0);
}

double penalty_energy(penalty_model model, double K, double d) {
  if (d <= 0.0) {
    return 0.0;
  }
  return (model == PENALTY_KELVIN_VOIGT) ? 0.5 * K * d * d : 0.4 * K * d * d * sqrt(d);
}

void penalty_friction(double mu, double F, double v_s, int n_t, const double *u, double *f) {
  double square = 0.0;
  for (int k = 0; k < n_t; k++) {
    square += u[k] * u[k];
  }
  /* g(|u|/v_s) u/|u| = u / sqrt(v_s^2 + |u|^2): smooth at u = 0 */
  const double scale = -mu * F / sqrt(v_s * v_s + square);
  for (int k = 0; k < n_t; k++) {
    f[k] += scale * u[k];
  }
}
