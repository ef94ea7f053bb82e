/* Three cylinders. */
#include "problems/scenes/kit.h"

typedef struct pile3 {
  double mu_cylinders, mu_ground, radius, mass, gravity, duration;
} pile3;

static const base_field fields[] = {
    BASE_FIELD(pile3, mu_cylinders, BASE_REAL, "1", 0.3, 0.0, 10.0, "between the cylinders"),
    BASE_FIELD(pile3, mu_ground, BASE_REAL, "1", 0.12, 0.0, 10.0, "cylinders on the ground"),
    BASE_FIELD(pile3, radius, BASE_REAL, "m", 0.1, 1e-3, 1e3, "radius"),
    BASE_FIELD(pile3, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e9, "mass of each"),
    BASE_FIELD(pile3, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(pile3, duration, BASE_REAL, "s", 0.5, 1e-3, 1e3, "time simulated"),
};

/* Stands iff mu_cc >= tan 15 and mu_ground >= tan(15)/3; then N_ground = 1.5 W, N_cc = W/2,
 * F = W/2 tan 15. The two below do not press on each other. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const pile3 *p = param;
  const double r = p->radius, W = p->mass * p->gravity, T = p->duration;
  const double limit = tan(KIT_PI / 12.0);
  const double pos[3][2] = {{-r, r}, {r, r}, {0.0, r + sqrt(3.0) * r}};
  static const char *const names[] = {"left", "right", "top"};
  kit_world(s, 2, p->gravity, T, 0.005);
  for (int i = 0; i < 3; i++) {
    BASE_TRY(kit_ball(s, names[i], p->mass, r, pos[i], NULL, err));
  }
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu_cylinders;
  BASE_TRY(spec_add_pair(&s->friction, "left", "floor", p->mu_ground, err));
  BASE_TRY(spec_add_pair(&s->friction, "right", "floor", p->mu_ground, err));
  BASE_TRY(spec_add_no_collision(s, "left", "right", err)); /* else the forces are not unique */
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "top.y", err));
  const double cc = p->mu_cylinders / limit, ground = p->mu_ground / (limit / 3.0);
  if (cc >= 1.0 && ground >= 1.0) {
    spec_check *c;
    BASE_TRY(
        kit_rests(s, "top.y", 1e-7 * r, "stands: mu_cc >= tan 15, mu_ground >= tan(15)/3", err));
    BASE_TRY(kit_force(s, "left", "floor", false, T / 2.0, T, 1.5 * W, 1e-6 * W, &c, err));
    kit_source(c, "half of all the weight, 3 W/2");
    BASE_TRY(kit_rigid_only(c, err));
    BASE_TRY(kit_force(s, "top", "left", false, T / 2.0, T, 0.5 * W, 1e-6 * W, &c, err));
    kit_source(c, "W/2: moments about the ground contact");
    BASE_TRY(kit_rigid_only(c, err));
    BASE_TRY(kit_force(s, "top", "left", true, T / 2.0, T, 0.5 * W * limit, 1e-6 * W, &c, err));
    kit_source(c, "W/2 tan 15 degrees");
    return kit_rigid_only(c, err);
  }
  return kit_moves(s, "top.y", (fmin(cc, ground) < 0.97) ? 0.01 * r : 0.0, "collapses", err);
}

KIT_SCENE(pile3, "three-cylinder pile", "",
          "Two cylinders on the ground, one on top. It stands if and only if the friction between "
          "cylinders is at least tan 15 degrees = 0.267949 and that on the ground at least a third "
          "of it, 0.089316: rolling, not sliding, decides. A very sharp friction test "
          "(MATHEMATICS B13).",
          .situation = SITUATION_STACK);
