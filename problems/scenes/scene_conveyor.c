/* Box dropped on a conveyor. */
#include "problems/scenes/kit.h"

typedef struct conveyor {
  double speed, mu, gravity, duration;
  int dim;
} conveyor;

static const base_field fields[] = {
    BASE_FIELD(conveyor, speed, BASE_REAL, "m/s", 1.5, 1e-6, 1e3, "speed of the belt"),
    BASE_FIELD(conveyor, mu, BASE_REAL, "1", 0.4, 1e-6, 10.0, "friction coefficient"),
    BASE_FIELD(conveyor, dim, BASE_INT, "1", 2, 2, 3, "dimension"),
    BASE_FIELD(conveyor, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(conveyor, duration, BASE_REAL, "s", 0.8, 1e-3, 1e3, "time simulated"),
};

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const conveyor *p = param;
  const double a = p->mu * p->gravity, V = p->speed, grip = V / a, T = p->duration;
  const double half[3] = {0.15, (p->dim == 2) ? 0.05 : 0.15, 0.05};
  double pos[3] = {0.0}, up[3] = {0.0};
  spec_static *belt;
  kit_world(s, p->dim, p->gravity, T, 0.01);
  pos[kit_up(s)] = 0.05;
  up[kit_up(s)] = 1.0;
  BASE_TRY(kit_box(s, "block", 1.0, half, pos, NULL, err));
  BASE_TRY(spec_add_static(s, "belt", up, 0.0, &belt, err));
  belt->surface_velocity[0] = V;
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "block.vx", err));
  const double v = fmin(V, a * T), x = (T > grip) ? V * T - V * V / (2.0 * a) : a * T * T / 2.0;
  BASE_TRY(kit_expect(s, "block.vx", T, v, (T > grip) ? 0.0 : a, "min(V, mu g t)", err));
  kit_last(s)->tol.reg_v = 0.01;
  kit_last(s)->tol.reg_h = (T > grip) ? 0.0 : 2.0 * a;
  BASE_TRY(kit_expect(s, "block.x", T, x, 0.7 * V, "slips V^2/(2 mu g) on the belt", err));
  kit_last(s)->tol.reg_h = 2.0 * V;
  kit_last(s)->tol.reg_v = 0.1 + 0.5 * grip;
  return spec_add_off(s, EFFECT_FRICTION, "block.x", T, 0.0, 1e-8, 0.0, err);
}

KIT_SCENE(
    conveyor, "box on a conveyor belt", "coulomb1785",
    "A box is put on a moving belt, slips V^2/(2 mu g) relative to it and is carried along "
    "after V/(mu g). The only scene that notices a forgotten surface velocity (MATHEMATICS S8).",
    .situation = SITUATION_SLIDING);
