/* formulations/penalty_law.h - compliant contact: normal force from indentation, friction from
 * slip velocity. Pure functions.
 *
 * d = -gap > 0 indentation [m], v = d/dt d [m/s] (> 0 while closing), v_i > 0 the closing speed
 * with which the contact began:
 *
 *   hertz               F = K d^1.5                                  (Hertz 1881; lossless)
 *   kelvin_voigt        F = K d + c v                                (Goldsmith 1960)
 *   hunt_crossley       F = K d^1.5 (1 + 3 (1 - e) / (2 v_i) v)      (Hunt & Crossley 1975)
 *   lankarani_nikravesh F = K d^1.5 (1 + 3 (1 - e^2) / (4 v_i) v)    (Lankarani & Nikravesh 1990)
 *   gonthier            F = K d^1.5 (1 + x v / v_i)                  (Gonthier, McPhee, Lange & Piedboeuf 2004)
 *
 * None pulls: F = max(F, 0). The factors of hunt_crossley and lankarani_nikravesh are derived for e near 1 and lose accuracy
 * below e of about 0.7 (at e = 0 a ball still rises to a tenth of its height); that of gonthier is exact,
 * x (1 + e) = ln((1 + x) / (1 - x e)), and taken at e = 0.01 where e is less: e = 0 asks for x infinite.
 */
#pragma once

typedef enum penalty_model {
  PENALTY_HERTZ,
  PENALTY_KELVIN_VOIGT,
  PENALTY_HUNT_CROSSLEY,
  PENALTY_LANKARANI_NIKRAVESH,
  PENALTY_GONTHIER,
} penalty_model;
#define PENALTY_MODELS "hertz|kelvin_voigt|hunt_crossley|lankarani_nikravesh|gonthier"

/* The factor of v / v_i at the coefficient of restitution e in [0, 1]; 0 for hertz and kelvin_voigt [1]. */
double penalty_damping(penalty_model model, double e);

/* K [N/m^1.5] or [N/m] (kelvin_voigt), c [N s/m] (kelvin_voigt only), x from penalty_damping. Returns [N]. */
double penalty_normal_force(penalty_model model, double K, double c, double x, double v_i, double d,
                            double v);

/* Elastic energy stored at indentation d [J]. */
double penalty_energy(penalty_model model, double K, double d);

/* Friction on n_t tangential components: f = -mu F g(|u|/v_s) u/|u| with the C1 function
 * g(x) = x / sqrt(1 + x^2): viscous with v_s [m/s] near zero, Coulomb beyond. Adds to f[n_t]. */
void penalty_friction(double mu, double F, double v_s, int n_t, const double *u, double *f);
