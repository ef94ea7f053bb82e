/* Pyramid of boxes. */
#include "problems/scenes/kit.h"

#include <stdio.h>

typedef struct pyramid {
  int base;
  double mu, half, mass, gravity, duration;
} pyramid;

static const base_field fields[] = {
    BASE_FIELD(pyramid, base, BASE_INT, "1", 5, 1, 150, "boxes in the lowest course"),
    BASE_FIELD(pyramid, mu, BASE_REAL, "1", 0.5, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(pyramid, half, BASE_REAL, "m", 0.1, 1e-3, 1e2, "half edge"),
    BASE_FIELD(pyramid, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e6, "mass of a box"),
    BASE_FIELD(pyramid, gravity, BASE_REAL, "m/s^2", 9.81, 0.0, 1e3, "gravity"),
    BASE_FIELD(pyramid, duration, BASE_REAL, "s", 0.1, 1e-3, 1e3, "time simulated"),
};

/* Cubes in one vertical plane, base (base+1)/2 of them; a gap of a tenth of an edge between
 * neighbours, so every box rests on two. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const pyramid *p = param;
  const double half[3] = {p->half, p->half, p->half}, pitch = 2.2 * p->half;
  char name[SPEC_NAME] = "", var[2 * SPEC_NAME];
  int n = 0;
  kit_world(s, 3, p->gravity, p->duration, 0.01);
  for (int r = 0; r < p->base; r++) {
    for (int c = 0; c < p->base - r; c++) {
      const double pos[3] = {(c + 0.5 * r) * pitch, 0.0, p->half * (2.0 * r + 1.0)};
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
  spec_check *c;
  BASE_TRY(kit_drift(s, var, 1e-6, 2.0 * p->gravity * p->base, &c, err));
  kit_source(c, "stands");
  return BASE_OK;
}

KIT_SCENE(pyramid, "pyramid of boxes", "tasora2011",
          "A pyramid of cubes at rest, each on two others with four contacts each: the usual large "
          "box scene of rigid-body engines, here with the exact answer that nothing moves.",
          .situation = SITUATION_STACK, .redundant = true);
