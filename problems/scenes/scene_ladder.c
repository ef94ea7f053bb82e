/* Ladder against a wall. */
#include "problems/scenes/kit.h"

typedef struct ladder {
  double theta_deg, mu_floor, mu_wall, half, mass, gravity;
} ladder;

static const base_field fields[] = {
    BASE_FIELD(ladder, theta_deg, BASE_REAL, "deg", 50.0, 5.0, 89.0, "inclination to the floor"),
    BASE_FIELD(ladder, mu_floor, BASE_REAL, "1", 0.4, 0.0, 10.0, "friction at the floor"),
    BASE_FIELD(ladder, mu_wall, BASE_REAL, "1", 0.3, 0.0, 10.0, "friction at the wall"),
    BASE_FIELD(ladder, half, BASE_REAL, "m", 1.0, 1e-3, 1e3, "half length"),
    BASE_FIELD(ladder, mass, BASE_REAL, "kg", 3.0, 1e-6, 1e9, "mass"),
    BASE_FIELD(ladder, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

/* Stands iff tan(theta) >= (1 - mu_f mu_w)/(2 mu_f). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const ladder *p = param;
  const double th = kit_radians(p->theta_deg), up[2] = {1.0, 0.0};
  spec_body *rod;
  kit_world(s, 2, p->gravity, sqrt(9.81 * p->half / p->gravity), 0.0025);
  BASE_TRY(spec_add_body(s, "ladder", &rod, err));
  rod->shape.kind = SPEC_ROD;
  rod->shape.half[0] = p->half;
  rod->mass = p->mass;
  rod->inertia[0] = p->mass * p->half * p->half / 3.0;
  rod->pos[0] = p->half * cos(th);
  rod->pos[1] = p->half * sin(th);
  rod->angle = KIT_PI - th;
  BASE_TRY(kit_floor(s, err));
  BASE_TRY(spec_add_static(s, "wall", up, 0.0, NULL, err));
  BASE_TRY(spec_add_pair(&s->friction, "ladder", "floor", p->mu_floor, err));
  BASE_TRY(spec_add_pair(&s->friction, "ladder", "wall", p->mu_wall, err));
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "ladder.angle", err));
  const double need = (1.0 - p->mu_floor * p->mu_wall) / (2.0 * p->mu_floor);
  if (tan(th) >= need * 1.001) {
    BASE_TRY(kit_rests(s, "ladder.angle", 1e-6, "stands: tan >= (1 - mu_f mu_w)/(2 mu_f)", err));
    return kit_rests(s, "ladder.x", 1e-6 * p->half, "stands", err);
  }
  if (tan(th) <= need * 0.97) {
    return kit_moves(s, "ladder.angle", 0.02, "slips: tan < (1 - mu_f mu_w)/(2 mu_f)", err);
  }
  return kit_finite(s, err);
}

KIT_SCENE(ladder, "ladder against a wall", "parent1704",
          "A uniform ladder stands if and only if tan(theta) >= (1 - mu_f mu_w)/(2 mu_f). With a "
          "smooth wall it is one card of a symmetric card house, tan(theta) >= 1/(2 mu). A sharp "
          "test of two simultaneous friction limits (MATHEMATICS S5).",
          .situation = SITUATION_SLIDING);
