/* Tilted box that is dropped and clatters to rest. */
#include "problems/scenes/kit.h"

typedef struct clatter {
  double tilt, restitution, mu, gravity, duration;
} clatter;

static const base_field fields[] = {
    BASE_FIELD(clatter, tilt, BASE_REAL, "rad", 0.2, 1e-3, 0.4, "initial tilt"),
    BASE_FIELD(clatter, restitution, BASE_REAL, "1", 0.5, 0.0, 0.9, "Newton's coefficient"),
    BASE_FIELD(clatter, mu, BASE_REAL, "1", 0.4, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(clatter, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(clatter, duration, BASE_REAL, "s", 3.0, 1.0, 1e2, "time simulated"),
};

/* No closed form between the impacts; at the end it lies flat, and no impact gives energy. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const clatter *p = param;
  const double half[2] = {0.3, 0.1}, pos[2] = {0.0, 0.25}, T = p->duration;
  spec_body *block;
  spec_check *c;
  kit_world(s, 2, p->gravity, T, 0.005);
  BASE_TRY(kit_box(s, "block", 2.0, half, pos, &block, err));
  block->angle = p->tilt;
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->restitution.dflt = p->restitution;
  s->effects = EFFECT_CONTACT | EFFECT_ROTATION | (p->mu > 0.0 ? EFFECT_FRICTION : 0u) |
               (p->restitution > 0.0 ? EFFECT_RESTITUTION : 0u);
  BASE_TRY(spec_add_observe(s, "block.angle", err));
  BASE_TRY(spec_add_check(s, CHECK_WINDOW_MAX, "block.y", &c, err));
  c->t0 = 0.9 * T;
  c->t1 = T;
  c->value = half[1];
  c->tol.abs = 1e-4;
  c->tol.h = 1.5;
  kit_source(c, "flat on the floor");
  BASE_TRY(spec_add_state(s, "block.angle", T, 0.0, 1e-4, 4.0, err));
  kit_source(kit_last(s), "flat on the floor");
  BASE_TRY(spec_add_state(s, "block.omega", T, 0.0, 1e-3, 5.0, err));
  kit_source(kit_last(s), "flat on the floor");
  BASE_TRY(kit_energy(s, 1e-8, 0.0, err));
  kit_last(s)->tol.h2 = 100.0;
  return BASE_OK;
}

KIT_SCENE(clatter, "tilted box that clatters to rest", "goyal1998",
          "A box dropped on one corner throws itself from corner to corner, faster and faster, and "
          "must come to rest: the impacts may not feed each other energy.",
          .situation = SITUATION_IMPACT);
