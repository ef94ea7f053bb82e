/* Initial overlap. */
#include "problems/scenes/kit.h"

typedef struct overlap {
  double depth, radius, gravity, duration;
} overlap;

static const base_field fields[] = {
    BASE_FIELD(overlap, depth, BASE_REAL, "m", 0.05, 0.0, 1.0, "initial penetration"),
    BASE_FIELD(overlap, radius, BASE_REAL, "m", 0.1, 1e-3, 1e2, "radius"),
    BASE_FIELD(overlap, gravity, BASE_REAL, "m/s^2", 9.81, 0.0, 1e3, "gravity"),
    BASE_FIELD(overlap, duration, BASE_REAL, "s", 0.2, 1e-3, 1e2, "time simulated"),
};

/* Velocity level: it stays; position level: expelled in one step with depth/h. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const overlap *p = param;
  const double pos[2] = {0.0, p->radius - p->depth};
  spec_check *c;
  kit_world(s, 2, p->gravity, p->duration, 0.01);
  BASE_TRY(kit_ball(s, "ball", 1.0, p->radius, pos, NULL, err));
  BASE_TRY(kit_floor(s, err));
  s->effects = EFFECT_CONTACT;
  BASE_TRY(spec_add_observe(s, "ball.y", err));
  BASE_TRY(kit_finite(s, err));
  for (int position = 0; position < 2; position++) {
    BASE_TRY(spec_add_check(s, CHECK_MAX_SPEED, NULL, &c, err));
    c->tol.abs = 1e-6;
    c->tol.h = 2.0 * p->gravity;
    c->tol.inv_h = (position == 1) ? 1.05 * p->depth : 0.0;
    kit_source(c, position == 1 ? "expelled with depth/h" : "no correction, no motion");
    BASE_TRY(spec_check_only(c, position == 1 ? "position" : "velocity", err));
  }
  BASE_TRY(kit_drift(s, "ball.y", 1e-6, 2.0 * p->gravity, &c, err));
  return spec_check_only(c, "velocity", err);
}

KIT_SCENE(overlap, "initial overlap", "anitescu2004",
          "A ball starts inside the floor. A velocity-level scheme leaves it there, a "
          "position-level one removes the overlap in one step with depth/h and so injects energy: "
          "both are what the equations say, and the report must show it (MATHEMATICS S15).",
          .situation = SITUATION_OTHER);
