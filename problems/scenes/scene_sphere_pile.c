/* Spheres falling into a box. */
#include "lcp/base/rng.h"
#include "problems/scenes/kit.h"

#include <stdio.h>

typedef struct sphere_pile {
  int n, side, seed;
  double radius, spread, mu, density, gravity, duration;
} sphere_pile;

static const base_field fields[] = {
    BASE_FIELD(sphere_pile, n, BASE_INT, "1", 100, 1, 1000000, "spheres"),
    BASE_FIELD(sphere_pile, side, BASE_INT, "1", 0, 0, 1000,
               "spheres along an edge of the floor; 0: so that the pile is about as high as wide"),
    BASE_FIELD(sphere_pile, radius, BASE_REAL, "m", 0.05, 1e-4, 1e2, "mean radius"),
    BASE_FIELD(sphere_pile, spread, BASE_REAL, "1", 0.1, 0.0, 0.5, "relative spread of radii"),
    BASE_FIELD(sphere_pile, mu, BASE_REAL, "1", 0.4, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(sphere_pile, density, BASE_REAL, "kg/m^3", 1000.0, 1e-3, 1e6, "density"),
    BASE_FIELD(sphere_pile, seed, BASE_INT, "1", 1, 0, 1e9, "seed of radii and positions"),
    BASE_FIELD(sphere_pile, gravity, BASE_REAL, "m/s^2", 9.81, 0.0, 1e3, "gravity"),
    BASE_FIELD(sphere_pile, duration, BASE_REAL, "s", 0.1, 1e-3, 1e3, "time simulated"),
};

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const sphere_pile *p = param;
  const int side = (p->side > 0) ? p->side : (int)ceil(cbrt(p->n));
  const double cell = 2.0 * p->radius * (1.0 + p->spread), width = side * cell;
  base_rng rng = base_rng_seeded((uint64_t)p->seed);
  kit_world(s, 3, p->gravity, p->duration, 0.005);
  for (int i = 0; i < p->n; i++) {
    char name[SPEC_NAME];
    const double r = p->radius * base_rng_between(&rng, 1.0 - p->spread, 1.0 + p->spread);
    const double play = cell / 2.0 - r; /* room to move inside the cell */
    const int at[3] = {i % side, i / side % side, i / (side * side)};
    double pos[3];
    for (int k = 0; k < 3; k++) {
      pos[k] = (at[k] + 0.5) * cell + play * base_rng_between(&rng, -1.0, 1.0);
    }
    kit_name(name, "s", i);
    BASE_TRY(kit_ball(s, name, p->density * 4.0 / 3.0 * KIT_PI * r * r * r, r, pos, NULL, err));
  }
  BASE_TRY(kit_floor(s, err));
  for (int k = 0; k < 2; k++) {
    static const char *const low[] = {"west", "south"}, *const high[] = {"east", "north"};
    BASE_TRY(kit_wall(s, low[k], k, 1.0, 0.0, err));
    BASE_TRY(kit_wall(s, high[k], k, -1.0, width, err));
  }
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  char last[2 * SPEC_NAME]; /* the sphere that lands on the others */
  (void)snprintf(last, sizeof last, "s%d.pos", p->n - 1);
  BASE_TRY(spec_add_observe(s, last, err));
  BASE_TRY(kit_finite(s, err));
  const double fall = p->gravity * p->duration;
  BASE_TRY(kit_penetration(s, 1e-6, 2.0 * fall + 1e-3, err));
  const double mass = p->n * p->density * 4.2 * pow(p->radius, 3.0);
  return kit_energy(s, 1e-9 * (1.0 + mass * fall * fall), mass * p->gravity * fall, err);
}

KIT_SCENE(sphere_pile, "spheres falling into a box", "tasora2011",
          "Polydisperse spheres on a jittered grid settle in a box with four walls: the standard "
          "scaling scene of granular codes, any size up to a million. Energy never grows, nothing "
          "leaves the box.",
          .situation = SITUATION_STACK);
