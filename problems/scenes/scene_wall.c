/* Brick wall in running bond. */
#include "problems/scenes/kit.h"

#include <stdio.h>

typedef struct wall {
  int rows, columns, dim;
  double mu, mass, gravity, duration;
} wall;

static const base_field fields[] = {
    BASE_FIELD(wall, rows, BASE_INT, "1", 4, 1, 1000, "courses"),
    BASE_FIELD(wall, columns, BASE_INT, "1", 4, 1, 1000, "bricks in a course"),
    BASE_FIELD(wall, dim, BASE_INT, "1", 3, 2, 3, "dimension"),
    BASE_FIELD(wall, mu, BASE_REAL, "1", 0.6, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(wall, mass, BASE_REAL, "kg", 3.0, 1e-6, 1e6, "mass of a brick"),
    BASE_FIELD(wall, gravity, BASE_REAL, "m/s^2", 9.81, 0.0, 1e3, "gravity"),
    BASE_FIELD(wall, duration, BASE_REAL, "s", 0.1, 1e-3, 1e3, "time simulated"),
};

/* Odd courses are shifted by half a brick and one brick shorter. Bricks are 0.24 x 0.115 x 0.071 m
 * with gaps of 1 mm between neighbours of a course. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const wall *p = param;
  const double half[3] = {0.12, (p->dim == 2) ? 0.0355 : 0.0575, 0.0355}, pitch = 0.241;
  char name[SPEC_NAME] = "", var[2 * SPEC_NAME];
  int n = 0;
  kit_world(s, p->dim, p->gravity, p->duration, 0.01);
  for (int r = 0; r < p->rows; r++) {
    const int count = (p->columns > 1) ? p->columns - r % 2 : 1;
    const double shift = (p->columns > 1 && r % 2 == 1) ? pitch / 2.0 : 0.0;
    for (int c = 0; c < count; c++) {
      double pos[3] = {shift + c * pitch};
      pos[kit_up(s)] = 0.071 * (r + 0.5);
      kit_name(name, "b", n++);
      BASE_TRY(kit_box(s, name, p->mass, half, pos, NULL, err));
    }
  }
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  (void)snprintf(var, sizeof var, "%s.pos", name);
  BASE_TRY(spec_add_observe(s, var, err));
  BASE_TRY(kit_finite(s, err));
  BASE_TRY(kit_penetration(s, 1e-7, 0.02 * p->gravity * p->rows * 0.01, err));
  spec_check *c;
  BASE_TRY(kit_drift(s, var, 1e-6, 2.0 * p->gravity * p->rows, &c, err));
  kit_source(c, "stands");
  return BASE_OK;
}

KIT_SCENE(wall, "brick wall in running bond", "acary2018",
          "A wall of bricks at rest, every brick on two others: hyperstatic, with as many contacts "
          "as wanted. Nothing moves; the weight must arrive at the ground.",
          .situation = SITUATION_STACK, .redundant = true);
