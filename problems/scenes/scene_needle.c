/* Needle at rest whose inertia all but vanishes. */
#include "problems/scenes/kit.h"

typedef struct needle {
  double inertia, half, thickness, gravity, duration;
} needle;

static const base_field fields[] = {
    BASE_FIELD(needle, inertia, BASE_REAL, "kg m^2", 1e-6, 1e-15, 1.0, "about the centre"),
    BASE_FIELD(needle, half, BASE_REAL, "m", 0.5, 1e-3, 1e3, "half length"),
    BASE_FIELD(needle, thickness, BASE_REAL, "m", 0.001, 1e-6, 1.0, "half thickness"),
    BASE_FIELD(needle, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(needle, duration, BASE_REAL, "s", 0.2, 1e-3, 1e3, "time simulated"),
};

/* The contact matrix has the eigenvalues 2/m and 2 half^2/inertia: with them in its condition, the
 * force keeps 16 - log10(condition) digits (MATHEMATICS S13). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const needle *p = param;
  const double half[2] = {p->half, p->thickness}, pos[2] = {0.0, p->thickness};
  const double digits = fmin(p->half * p->half / p->inertia * 1e-16, 1.0);
  spec_body *b;
  kit_world(s, 2, p->gravity, p->duration, 0.01);
  BASE_TRY(kit_box(s, "needle", 1.0, half, pos, &b, err));
  b->inertia[0] = p->inertia;
  BASE_TRY(kit_floor(s, err));
  s->effects = EFFECT_CONTACT | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "needle.angle", err));
  BASE_TRY(kit_force(s, "needle", "floor", false, p->duration / 2.0, p->duration, p->gravity,
                     (1e-6 + 100.0 * digits) * p->gravity, NULL, err));
  kit_source(kit_last(s), "m g, however split");
  BASE_TRY(kit_drift(s, "needle.y", 1e-7 + 0.04 * digits, 0.0, NULL, err));
  BASE_TRY(kit_drift(s, "needle.angle", 1e-6 + 0.4 * digits, 0.0, NULL, err));
  return kit_energy(s, 1e-9 + 0.04 * digits, 0.0, err);
}

KIT_SCENE(needle, "needle with next to no inertia", "lotstedt1982",
          "A flat needle lies on two contacts. As its inertia goes to zero the mass matrix becomes "
          "singular and the contact matrix ill-conditioned, half^2 m/inertia; the weight on the "
          "floor stays what it is (MATHEMATICS S13).",
          .situation = SITUATION_OTHER);
