/* Tower of boxes at rest. */
#include "problems/scenes/kit.h"

#include <stdio.h>
#include <string.h>

typedef struct stack {
  int n, dim;
  double mass, mass_ratio, half, mu, gravity, duration;
} stack;

static const base_field fields[] = {
    BASE_FIELD(stack, n, BASE_INT, "1", 5, 1, 10000, "boxes"),
    BASE_FIELD(stack, mass_ratio, BASE_REAL, "1", 1.0, 1e-9, 1e9,
               "mass of the top box over that of the others"),
    BASE_FIELD(stack, dim, BASE_INT, "1", 3, 2, 3, "dimension"),
    BASE_FIELD(stack, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e9, "mass of a box"),
    BASE_FIELD(stack, half, BASE_REAL, "m", 0.25, 1e-4, 1e3, "half edge"),
    BASE_FIELD(stack, mu, BASE_REAL, "1", 0.5, 0.0, 100.0, "friction coefficient"),
    BASE_FIELD(stack, gravity, BASE_REAL, "m/s^2", 9.81, 0.0, 1e3, "gravity"),
    BASE_FIELD(stack, duration, BASE_REAL, "s", 0.2, 1e-6, 1e5, "time simulated"),
};

/* Interface i carries all masses above it; nothing moves. A velocity-level scheme that closes an
 * interface one step late settles by up to g h^2 each (MATHEMATICS B12). */
static base_status predict(scene_spec *s, const stack *p, base_error *err) {
  const double heaviest = p->mass * fmax(1.0, p->mass_ratio), T = p->duration;
  const double weight = p->gravity * (p->mass * (p->n - 1) + p->mass * p->mass_ratio);
  double above = weight;
  char name[SPEC_NAME], below[SPEC_NAME] = "floor", var[2 * SPEC_NAME];
  for (int i = 0; i < p->n; i++) {
    kit_name(name, "b", i);
    if (i < 40 || i == p->n - 1) { /* a selection suffices on a high tower */
      spec_check *c;
      BASE_TRY(kit_force(s, name, below, false, T / 2.0, T, above, 1e-6 * weight + 1e-12, &c, err));
      kit_source(c, "weight above");
    }
    memcpy(below, name, sizeof below);
    above -= p->gravity * p->mass;
  }
  spec_check *c;
  (void)snprintf(var, sizeof var, "%s.%c", name, (p->dim == 2) ? 'y' : 'z');
  BASE_TRY(kit_drift(s, var, 1e-7, p->gravity * p->n, &c, err));
  BASE_TRY(spec_check_only(c, "velocity", err));
  BASE_TRY(spec_check_only(c, "regularized", err));
  BASE_TRY(kit_drift(s, var, 1e-7, 0.0, &c, err));
  BASE_TRY(spec_check_only(c, "position", err));
  (void)snprintf(var, sizeof var, "%s.x", name);
  BASE_TRY(kit_drift(s, var, 1e-7, 0.0, NULL, err));
  BASE_TRY(spec_add_check(s, CHECK_MAX_PENETRATION, NULL, &c, err));
  kit_source(c, "bodies do not overlap");
  c->tol.abs = 1e-7;
  c->tol.h2 = p->gravity;
  return kit_energy(s, 1e-8 * heaviest * p->gravity * p->half * p->n + 1e-12, 0.0, err);
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const stack *p = param;
  const double half[3] = {p->half, p->half, p->half};
  char name[SPEC_NAME];
  kit_world(s, p->dim, p->gravity, p->duration, 0.01);
  for (int i = 0; i < p->n; i++) {
    double pos[3] = {0.0};
    pos[kit_up(s)] = p->half * (2.0 * i + 1.0);
    kit_name(name, "b", i);
    const double mass = (i == p->n - 1) ? p->mass * p->mass_ratio : p->mass;
    BASE_TRY(kit_box(s, name, mass, half, pos, NULL, err));
  }
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_ROTATION | (p->mu > 0.0 ? EFFECT_FRICTION : 0u);
  s->order = 0;
  const double c = cos(KIT_PI / (2.0 * p->n));
  s->sweep_rate = (p->mass_ratio == 1.0) ? c * c
                  : (p->n == 2)          ? p->mass_ratio / (1.0 + p->mass_ratio)
                                         : 0.0;
  return predict(s, p, err);
}

const scene scene_stack = {
    .name = "stack",
    .title = "tower of boxes at rest",
    .cite = "acary2008",
    .about =
        "n boxes on each other at rest, four contact points per interface (two in the plane), so "
        "the split of forces is not unique while the sum at interface i is the weight above it. "
        "Height and the mass ratio of the top box set the difficulty: Gauss-Seidel sweeps contract "
        "like cos^2(pi/2n) for equal masses and R/(1+R) for two boxes of ratio R "
        "(MATHEMATICS B12).",
    .situation = SITUATION_STACK,
    .redundant = true,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .param_size = sizeof(stack),
    .build = build,
};
