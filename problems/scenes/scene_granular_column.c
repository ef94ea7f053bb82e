/* Collapse of a granular column. */
#include "lcp/base/rng.h"
#include "problems/scenes/kit.h"

#include <stdio.h>

typedef struct granular_column {
  int columns, layers, seed;
  double radius, spread, mu, density, gravity, duration;
} granular_column;

static const base_field fields[] = {
    BASE_FIELD(granular_column, columns, BASE_INT, "1", 6, 1, 1000, "discs side by side"),
    BASE_FIELD(granular_column, layers, BASE_INT, "1", 12, 1, 1000, "layers"),
    BASE_FIELD(granular_column, radius, BASE_REAL, "m", 0.02, 1e-4, 1e2, "mean radius"),
    BASE_FIELD(granular_column, spread, BASE_REAL, "1", 0.1, 0.0, 0.4, "relative spread of radii"),
    BASE_FIELD(granular_column, mu, BASE_REAL, "1", 0.5, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(granular_column, density, BASE_REAL, "kg/m^2", 1000.0, 1e-3, 1e6, "mass per area"),
    BASE_FIELD(granular_column, seed, BASE_INT, "1", 1, 0, 1e9, "seed of the radii"),
    BASE_FIELD(granular_column, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(granular_column, duration, BASE_REAL, "s", 0.2, 1e-3, 1e2, "time simulated"),
};

/* Discs in staggered layers against a wall at x = 0; the other side is let go at t = 0. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const granular_column *p = param;
  const double cell = 2.0 * p->radius * (1.0 + p->spread);
  base_rng rng = base_rng_seeded((uint64_t)p->seed);
  double mass = 0.0;
  int n = 0;
  kit_world(s, 2, p->gravity, p->duration, 0.002);
  for (int z = 0; z < p->layers; z++) {
    for (int c = 0; c < p->columns; c++) {
      char name[SPEC_NAME];
      const double r = p->radius * base_rng_between(&rng, 1.0 - p->spread, 1.0 + p->spread);
      const double m = p->density * KIT_PI * r * r;
      const double pos[2] = {cell * (c + 0.5 + 0.5 * (z % 2)), cell * (0.5 + z * sqrt(0.75))};
      kit_name(name, "d", n++);
      BASE_TRY(kit_ball(s, name, m, r, pos, NULL, err));
      mass += m;
    }
  }
  BASE_TRY(kit_floor(s, err));
  BASE_TRY(kit_wall(s, "wall", 0, 1.0, 0.0, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  char front[2 * SPEC_NAME]; /* the outer disc of the lowest layer */
  (void)snprintf(front, sizeof front, "d%d.x", p->columns - 1);
  BASE_TRY(spec_add_observe(s, front, err));
  BASE_TRY(kit_finite(s, err));
  const double fall = p->gravity * p->duration;
  BASE_TRY(kit_penetration(s, 1e-6, 3.0 * fall, err));
  return kit_energy(s, 1e-9 * mass * fall * fall, mass * p->gravity * fall, err);
}

KIT_SCENE(granular_column, "collapse of a granular column", "lajeunesse2005",
          "A column of discs against a wall is let go and spreads: contacts open and close all the "
          "time, most of them slide. Energy never grows; the run-out scales with the aspect ratio "
          "in experiments.",
          .situation = SITUATION_STACK);
