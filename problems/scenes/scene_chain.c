/* Hanging chain with a heavy end. */
#include "problems/scenes/kit.h"

#include <stdio.h>

typedef struct chain {
  int n, dim;
  double heavy, tilt_deg, link, gravity, duration;
} chain;

static const base_field fields[] = {
    BASE_FIELD(chain, n, BASE_INT, "1", 10, 1, 10000, "links"),
    BASE_FIELD(chain, heavy, BASE_REAL, "kg", 1000.0, 1e-6, 1e9, "mass of the last; others 1 kg"),
    BASE_FIELD(chain, tilt_deg, BASE_REAL, "deg", 0.0, 0.0, 90.0, "initial angle to the vertical"),
    BASE_FIELD(chain, dim, BASE_INT, "1", 2, 2, 3, "dimension"),
    BASE_FIELD(chain, link, BASE_REAL, "m", 0.1, 1e-3, 1e2, "half length of a link"),
    BASE_FIELD(chain, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(chain, duration, BASE_REAL, "s", 0.5, 1e-3, 1e3, "time simulated"),
};

/* Straight down it hangs still, link i carrying all below it; tilted it swings, energy kept. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const chain *p = param;
  const double a = kit_radians(p->tilt_deg), l = p->link;
  const int up = p->dim - 1;
  const double half[3] = {0.2 * l, (p->dim == 2) ? l : 0.2 * l, l}; /* no contacts between links */
  char name[SPEC_NAME], var[2 * SPEC_NAME];
  /* tension over link mass and length is a frequency that the step must resolve while it swings */
  const double stiff = 0.1 / sqrt(p->gravity * (p->heavy + p->n) / l);
  kit_world(s, p->dim, p->gravity, p->duration, (p->tilt_deg > 0.0) ? fmin(0.005, stiff) : 0.005);
  for (int i = 0; i < p->n; i++) {
    double pos[3] = {sin(a) * l * (2.0 * i + 1.0)};
    spec_body *b;
    spec_joint *j;
    pos[up] = -cos(a) * l * (2.0 * i + 1.0);
    kit_name(name, "c", i);
    BASE_TRY(kit_box(s, name, (i == p->n - 1) ? p->heavy : 1.0, half, pos, &b, err));
    b->angle = a;
    if (p->dim == 3) {
      kit_turn(b, (const double[3]){0.0, 1.0, 0.0}, -a);
    }
    kit_name(name, "j", i);
    BASE_TRY(spec_add_joint(s, name, &j, err));
    j->kind = SPEC_BALL;
    j->body = i;
    j->other = i - 1;
    j->anchor[0] = sin(a) * l * 2.0 * i;
    j->anchor[up] = -cos(a) * l * 2.0 * i;
  }
  s->effects = EFFECT_JOINTS | ((p->tilt_deg > 0.0) ? EFFECT_ROTATION : 0u);
  (void)snprintf(var, sizeof var, "c%d.pos", p->n - 1);
  BASE_TRY(spec_add_observe(s, var, err));
  BASE_TRY(kit_finite(s, err));
  if (p->tilt_deg > 0.0) {
    const double E = p->gravity * (p->heavy + p->n) * 2.0 * l * p->n;
    return kit_energy(s, 1e-6 * E, 2.0 * E, err);
  }
  BASE_TRY(kit_drift(s, var, 1e-6 * l * p->n, 0.0, NULL, err));
  kit_source(kit_last(s), "hangs still");
  return BASE_OK;
}

KIT_SCENE(chain, "hanging chain with a heavy end", "baraff1996",
          "Links joined by ball joints, the last a thousand times heavier: bilateral rows only. It "
          "hangs still when straight, swings when tilted; iterative treatment of the joints needs "
          "as many sweeps as the mass ratio.",
          .situation = SITUATION_OTHER);
