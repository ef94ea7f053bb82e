/* Spheres on a cubic lattice in a box. */
#include "problems/scenes/kit.h"

#include <stdio.h>

typedef struct silo {
  int side, layers;
  double radius, mu, mass, gravity, duration;
} silo;

static const base_field fields[] = {
    BASE_FIELD(silo, side, BASE_INT, "1", 3, 1, 300, "spheres along an edge of the floor"),
    BASE_FIELD(silo, layers, BASE_INT, "1", 4, 1, 1000, "layers"),
    BASE_FIELD(silo, radius, BASE_REAL, "m", 0.05, 1e-4, 1e2, "radius"),
    BASE_FIELD(silo, mu, BASE_REAL, "1", 0.3, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(silo, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e6, "mass of a sphere"),
    BASE_FIELD(silo, gravity, BASE_REAL, "m/s^2", 9.81, 0.0, 1e3, "gravity"),
    BASE_FIELD(silo, duration, BASE_REAL, "s", 0.05, 1e-3, 1e3, "time simulated"),
};

/* side^2 layers spheres that just touch: side^2 layers vertical contacts, 2 side (side-1) layers
 * between neighbours, 4 side layers at the walls. By symmetry nothing moves. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const silo *p = param;
  const double d = 2.0 * p->radius, count = (double)p->side * p->side * p->layers;
  char name[SPEC_NAME] = "";
  int n = 0;
  if (count > 2e6) {
    return BASE_FAIL(err, BASE_EINVAL, "side^2 layers = %g: need at most 2e6 spheres", count);
  }
  kit_world(s, 3, p->gravity, p->duration, 0.005);
  for (int z = 0; z < p->layers; z++) {
    for (int i = 0; i < p->side * p->side; i++) {
      const int column = i % p->side, row = i / p->side;
      const double pos[3] = {(column + 0.5) * d, (row + 0.5) * d, (z + 0.5) * d};
      kit_name(name, "s", n++);
      BASE_TRY(kit_ball(s, name, p->mass, p->radius, pos, NULL, err));
    }
  }
  BASE_TRY(kit_floor(s, err));
  for (int k = 0; k < 2; k++) {
    static const char *const low[] = {"west", "south"}, *const high[] = {"east", "north"};
    BASE_TRY(kit_wall(s, low[k], k, 1.0, 0.0, err));
    BASE_TRY(kit_wall(s, high[k], k, -1.0, p->side * d, err));
  }
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  char var[2 * SPEC_NAME];
  (void)snprintf(var, sizeof var, "%s.pos", name);
  BASE_TRY(spec_add_observe(s, var, err));
  BASE_TRY(kit_finite(s, err));
  BASE_TRY(kit_drift(s, var, 1e-6, 2.0 * p->gravity * p->layers, NULL, err));
  kit_source(kit_last(s), "symmetry: nothing moves");
  return kit_penetration(s, 1e-7, 0.02 * p->gravity * p->layers * p->duration, err);
}

KIT_SCENE(silo, "spheres on a cubic lattice in a box", "janssen1895",
          "A simple cubic packing filling a box: the number of contacts is known in advance (three "
          "per sphere and the walls, to 1e5 and beyond), the state is at rest by symmetry and "
          "unstable, which an asymmetric solver betrays.",
          .situation = SITUATION_OTHER);
