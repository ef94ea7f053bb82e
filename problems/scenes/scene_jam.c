/* Plug jammed in a slot. */
#include "problems/scenes/kit.h"

typedef struct jam {
  double half_angle_deg, mu, press, gravity;
} jam;

static const base_field fields[] = {
    BASE_FIELD(jam, half_angle_deg, BASE_REAL, "deg", 5.0, 0.1, 60.0, "half angle of the slot"),
    BASE_FIELD(jam, mu, BASE_REAL, "1", 0.5, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(jam, press, BASE_REAL, "N", 0.0, -1e7, 1e7, "force pressing it in"),
    BASE_FIELD(jam, gravity, BASE_REAL, "m/s^2", 9.81, 0.0, 1e3, "gravity"),
};

/* Self-locking iff mu >= tan(half angle): the set of solutions is then unbounded (self-stress). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const jam *p = param;
  const double a = kit_radians(p->half_angle_deg), r = 0.1, pos[2] = {0.0, r / sin(a)};
  const double left[2] = {cos(a), sin(a)}, right[2] = {-cos(a), sin(a)};
  spec_body *b;
  spec_load *l;
  kit_world(s, 2, p->gravity, 0.3, 0.01);
  BASE_TRY(kit_ball(s, "plug", 1.0, r, pos, &b, err));
  b->lock = SPEC_RZ;
  BASE_TRY(spec_add_static(s, "left", left, 0.0, NULL, err));
  BASE_TRY(spec_add_static(s, "right", right, 0.0, NULL, err));
  if (p->press != 0.0) {
    BASE_TRY(spec_add_load(s, &l, err));
    l->kind = SPEC_FORCE;
    l->force[1] = -p->press;
  }
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION;
  BASE_TRY(spec_add_observe(s, "plug.y", err));
  BASE_TRY(kit_finite(s, err));
  if (p->press + p->gravity < 0.0) {
    return BASE_OK; /* pulled out */
  }
  BASE_TRY(kit_rests(s, "plug.y", 1e-6, "sits in the slot", err));
  return kit_rests(s, "plug.x", 1e-6, "sits in the slot", err);
}

KIT_SCENE(jam, "plug jammed in a slot", "cottle1992",
          "A plug in a narrow slot is self-locking for mu >= tan(half angle): any amount of "
          "self-stress is a solution, so the solution set of the complementarity problem is "
          "unbounded. Any finite answer without motion is right (MATHEMATICS B21).",
          .situation = SITUATION_GRASP);
