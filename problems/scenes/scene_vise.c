/* Rigid part between closing jaws. */
#include "problems/scenes/kit.h"

typedef struct vise {
  double speed, mu;
} vise;

static const base_field fields[] = {
    BASE_FIELD(vise, speed, BASE_REAL, "m/s", 0.1, 1e-9, 1e3, "speed of each jaw"),
    BASE_FIELD(vise, mu, BASE_REAL, "1", 0.3, 0.0, 10.0, "friction coefficient"),
};

/* W = [[1,-1],[-1,1]]/m, q = -(v, v): y = (1,1) is a Farkas vector, no velocity-level solution. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const vise *p = param;
  const double half[2] = {0.1, 0.1}, jaw[2] = {0.05, 0.3}, pos[2] = {0.0, 0.0};
  static const char *const names[] = {"jaw_left", "jaw_right"};
  kit_world(s, 2, 0.0, 0.02, 0.01);
  BASE_TRY(kit_box(s, "part", 1.0, half, pos, NULL, err));
  for (int i = 0; i < 2; i++) {
    const double side = (i == 0) ? -1.0 : 1.0, at[2] = {0.15 * side, 0.0};
    spec_body *b;
    BASE_TRY(kit_box(s, names[i], 1.0, jaw, at, &b, err));
    b->kinematic = true;
    b->vel[0] = -side * p->speed;
  }
  BASE_TRY(spec_add_no_collision(s, names[0], names[1], err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT;
  s->expect_unsolved = true;
  BASE_TRY(spec_add_observe(s, "part.x", err));
  return kit_finite(s, err);
}

KIT_SCENE(vise, "rigid part between closing jaws", "cottle1992",
          "Two kinematic jaws close on a rigid part: no velocity satisfies both contacts, and the "
          "only right answer is to say so, best with the certificate y = (1, 1). A solver that "
          "returns any z here without saying 'infeasible' is lying (MATHEMATICS S14).",
          .situation = SITUATION_GRASP);
