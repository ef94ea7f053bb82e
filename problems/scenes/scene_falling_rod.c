/* Rod falling on a smooth floor. */
#include "problems/scenes/kit.h"

typedef struct falling_rod {
  double theta_deg, half, gravity, duration;
} falling_rod;

static const base_field fields[] = {
    BASE_FIELD(falling_rod, theta_deg, BASE_REAL, "deg", 60.0, 10.0, 89.0, "initial inclination"),
    BASE_FIELD(falling_rod, half, BASE_REAL, "m", 1.0, 1e-2, 1e2, "half length"),
    BASE_FIELD(falling_rod, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(falling_rod, duration, BASE_REAL, "s", 0.3, 1e-3, 10.0, "time simulated"),
};

/* y = l sin: (1/3 + cos^2) th'' = sin cos th'^2 - (g/l) cos (Lagrange); *ctx is g/l. */
static double fall(double th, double rate, const void *ctx) {
  const double s = sin(th), c = cos(th);
  return (s * c * rate * rate - *(const double *)ctx * c) / (1.0 / 3.0 + c * c);
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const falling_rod *p = param;
  const double l = p->half, T = p->duration, g_l = p->gravity / l;
  double y[2] = {kit_radians(p->theta_deg), 0.0};
  spec_body *rod;
  kit_world(s, 2, p->gravity, T, 0.005);
  BASE_TRY(spec_add_body(s, "rod", &rod, err));
  rod->shape.kind = SPEC_ROD;
  rod->shape.half[0] = l;
  rod->mass = 1.0;
  rod->inertia[0] = l * l / 3.0;
  rod->pos[0] = l * cos(y[0]);
  rod->pos[1] = l * sin(y[0]);
  rod->angle = y[0];
  BASE_TRY(kit_floor(s, err));
  s->effects = EFFECT_CONTACT | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "rod.angle", err));
  kit_integrate(fall, &g_l, T, y);
  BASE_TRY(kit_drift(s, "rod.x", 1e-8, 0.0, NULL, err));
  if (y[0] < 0.05) {
    return BASE_OK; /* lies flat before the end */
  }
  BASE_TRY(kit_expect(s, "rod.angle", T, y[0], 4.0, "falling rod equation", err));
  BASE_TRY(kit_expect(s, "rod.omega", T, y[1], 12.0, "falling rod equation", err));
  return kit_energy(s, 1e-6 * p->gravity * l, 0.06 * p->gravity, err);
}

KIT_SCENE(
    falling_rod, "rod falling on a smooth floor", "lagrange1788",
    "A rod stands tilted on a frictionless floor and falls; its centre goes straight down "
    "and the tip slides along. The reference integrates the one-dof equation (MATHEMATICS S9).",
    .situation = SITUATION_OTHER);
