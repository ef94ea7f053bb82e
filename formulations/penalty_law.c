#include "formulations/penalty_law.h"

#include <math.h>

double penalty_normal_force(penalty_model model, double K, double c, double e, double v_i, double d,
                            double v) {
  if (d <= 0.0) {
    return 0.0;
  }
  double force = 0.0;
  switch (model) {
  case PENALTY_HERTZ:
    force = K * d * sqrt(d);
    break;
  case PENALTY_KELVIN_VOIGT:
    force = K * d + c * v;
    break;
  case PENALTY_HUNT_CROSSLEY:
    force = K * d * sqrt(d) * (1.0 + 1.5 * (1.0 - e) * v / v_i);
    break;
  case PENALTY_LANKARANI_NIKRAVESH:
    force = K * d * sqrt(d) * (1.0 + 0.75 * (1.0 - e * e) * v / v_i);
    break;
  }
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
