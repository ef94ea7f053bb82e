/* Block on an accelerating table. */
#include "problems/scenes/kit.h"

typedef struct tablecloth {
  double acceleration, mu, gravity, duration;
} tablecloth;

static const base_field fields[] = {
    BASE_FIELD(tablecloth, acceleration, BASE_REAL, "m/s^2", 6.0, 1e-3, 1e3, "of the table"),
    BASE_FIELD(tablecloth, mu, BASE_REAL, "1", 0.4, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(tablecloth, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(tablecloth, duration, BASE_REAL, "s", 0.5, 1e-3, 10.0, "time simulated"),
};

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const tablecloth *p = param;
  const double a = fmin(p->acceleration, p->mu * p->gravity), T = p->duration;
  const double long_half = 2.0 + p->acceleration * T * T;
  const double half[2] = {long_half, 0.05}, pos[2] = {0.0, 0.05};
  const double small[2] = {0.15, 0.05}, start[2] = {0.0, 0.15};
  spec_body *b;
  kit_world(s, 2, p->gravity, T, 0.01);
  BASE_TRY(kit_box(s, "table", 1.0, half, pos, &b, err));
  b->kinematic = true;
  b->acc[0] = p->acceleration;
  BASE_TRY(kit_box(s, "block", 1.0, small, start, NULL, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "block.vx", err));
  BASE_TRY(kit_expect(s, "block.vx", T, a * T, 1.1 * p->acceleration, "min(A, mu g) T", err));
  kit_last(s)->tol.reg_h = p->acceleration + p->gravity;
  kit_last(s)->tol.reg_v = 2.0;
  BASE_TRY(kit_expect(s, "block.x", T, a * T * T / 2.0, 1.1 * p->acceleration * T,
                      "min(A, mu g) T^2/2", err));
  kit_last(s)->tol.reg_h = (p->acceleration + p->gravity) * T;
  kit_last(s)->tol.reg_v = 2.0 * T;
  return BASE_OK;
}

KIT_SCENE(tablecloth, "block on an accelerating table", "coulomb1785",
          "A table is pulled away with constant acceleration A: the block on it goes along for A < "
          "mu g and slips with mu g otherwise, the tablecloth trick (MATHEMATICS S8).",
          .situation = SITUATION_SLIDING);
