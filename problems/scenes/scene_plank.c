/* Block on a free plank. */
#include "problems/scenes/kit.h"

typedef struct plank {
  double speed, mu, mass_block, mass_plank, gravity;
} plank;

static const base_field fields[] = {
    BASE_FIELD(plank, speed, BASE_REAL, "m/s", 2.0, 1e-3, 10.0, "initial speed of the block"),
    BASE_FIELD(plank, mu, BASE_REAL, "1", 0.3, 1e-3, 10.0, "block on plank; the floor is smooth"),
    BASE_FIELD(plank, mass_block, BASE_REAL, "kg", 1.0, 1e-6, 1e6, "mass of the block"),
    BASE_FIELD(plank, mass_plank, BASE_REAL, "kg", 3.0, 1e-6, 1e6, "mass of the plank"),
    BASE_FIELD(plank, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

/* Common speed m v0/(m+M) after v0 M/(mu g (m+M)). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const plank *p = param;
  const double m = p->mass_block, M = p->mass_plank, g = p->gravity, v0 = p->speed;
  const double v = m * v0 / (m + M), t = v0 * M / (p->mu * g * (m + M)), T = 1.5 * t;
  const double slide = 0.5 * v0 * t, long_half = 2.0 * slide + 0.5;
  const double half[2] = {long_half, 0.05}, pos[2] = {0.0, 0.05};
  const double small[2] = {0.15, 0.05}, start[2] = {0.2 - long_half, 0.15};
  spec_body *b;
  spec_check *c;
  kit_world(s, 2, g, T, 0.01);
  BASE_TRY(kit_box(s, "plank", M, half, pos, NULL, err));
  BASE_TRY(kit_box(s, "block", m, small, start, &b, err));
  b->vel[0] = v0;
  BASE_TRY(kit_floor(s, err));
  BASE_TRY(spec_add_pair(&s->friction, "block", "plank", p->mu, err));
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "plank.vx", err));
  static const char *const speeds[] = {"block.vx", "plank.vx"};
  for (int i = 0; i < 2; i++) {
    BASE_TRY(kit_expect(s, speeds[i], T, v, 0.0, "m v0/(m+M)", err));
    kit_last(s)->tol.reg_v = 0.05;
  }
  BASE_TRY(kit_expect(s, "plank.x", T, v * t / 2.0 + v * (T - t), 0.8 * v0, "carried along", err));
  kit_last(s)->tol.reg_h = 3.0 * v0;
  kit_last(s)->tol.reg_v = T;
  BASE_TRY(spec_add_check(s, CHECK_MOMENTUM_X, NULL, &c, err));
  kit_source(c, "no force from outside along x");
  c->t = T;
  c->value = m * v0;
  c->tol.abs = 1e-8 * m * v0;
  return kit_energy(s, 1e-9 * m * v0 * v0, 0.0, err);
}

KIT_SCENE(plank, "block on a free plank", "newton1687",
          "A block slides on a plank that slides on a smooth floor: both end with m v0/(m+M), "
          "whatever the friction law, because momentum is kept (MATHEMATICS S8).",
          .situation = SITUATION_SLIDING);
