/* Semicircular arch. */
#include "problems/scenes/kit.h"

#include <stdio.h>

typedef struct arch {
  int n;
  double thickness, mu, radius, density, gravity, duration;
} arch;

static const base_field fields[] = {
    BASE_FIELD(arch, n, BASE_INT, "1", 9, 3, 201, "voussoirs (odd: with a keystone)"),
    BASE_FIELD(arch, thickness, BASE_REAL, "1", 0.2, 0.01, 0.5, "thickness over radius"),
    BASE_FIELD(arch, mu, BASE_REAL, "1", 0.7, 0.0, 5.0, "friction coefficient"),
    BASE_FIELD(arch, radius, BASE_REAL, "m", 1.0, 1e-2, 1e3, "mean radius"),
    BASE_FIELD(arch, density, BASE_REAL, "kg/m^2", 2000.0, 1e-3, 1e6, "mass per area"),
    BASE_FIELD(arch, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(arch, duration, BASE_REAL, "s", 0.15, 1e-3, 1e2, "time simulated"),
};

static base_status add_voussoir(scene_spec *s, const arch *p, int i, base_error *err) {
  const double lo = KIT_PI * i / p->n, hi = KIT_PI * (i + 1) / p->n;
  const double in = p->radius * (1.0 - p->thickness / 2.0),
               out = p->radius * (1.0 + p->thickness / 2.0);
  const double corner[4][2] = {{in * cos(lo), in * sin(lo)},
                               {out * cos(lo), out * sin(lo)},
                               {out * cos(hi), out * sin(hi)},
                               {in * cos(hi), in * sin(hi)}};
  char name[SPEC_NAME], other[SPEC_NAME];
  kit_name(name, "v", i);
  BASE_TRY(kit_polygon(s, name, p->density, 4, corner, NULL, err));
  for (int k = 0; k + 1 < i; k++) { /* only neighbours touch */
    kit_name(other, "v", k);
    BASE_TRY(spec_add_no_collision(s, other, name, err));
  }
  return BASE_OK;
}

/* Limit analysis: stands above thickness 0.1075 (Milankovitch) and mu about 0.31 to 0.40. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const arch *p = param;
  char crown[SPEC_NAME], var[2 * SPEC_NAME];
  double weight = 0.0;
  spec_check *c;
  kit_world(s, 2, p->gravity, p->duration, 0.01);
  for (int i = 0; i < p->n; i++) {
    BASE_TRY(add_voussoir(s, p, i, err));
    weight += p->gravity * s->body[i].mass;
  }
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  kit_name(crown, "v", p->n / 2);
  (void)snprintf(var, sizeof var, "%s.y", crown);
  BASE_TRY(spec_add_observe(s, var, err));
  BASE_TRY(kit_finite(s, err));
  if (p->thickness >= 0.15 && p->mu >= 0.5) {
    BASE_TRY(kit_drift(s, var, 1e-4 * p->radius, p->gravity, &c, err));
    kit_source(c, "stands (Milankovitch 1904)");
    BASE_TRY(kit_rigid_only(c, err));
    BASE_TRY(spec_add_check(s, CHECK_CONTACT_FORCE_SUM, NULL, &c, err));
    c->n_pair = 2;
    BASE_TRY(spec_text(c->pair[0].a, SPEC_NAME, "v0", "pair", err));
    kit_name(c->pair[1].a, "v", p->n - 1);
    for (int k = 0; k < 2; k++) {
      BASE_TRY(spec_text(c->pair[k].b, SPEC_NAME, "floor", "pair", err));
    }
    c->t0 = p->duration / 2.0;
    c->t1 = p->duration;
    c->value = weight;
    c->tol.abs = 1e-4 * weight;
    kit_source(c, "weight of the arch");
    return kit_rigid_only(c, err);
  }
  if (p->thickness <= 0.08 || p->mu <= 0.25) {
    BASE_TRY(kit_moves(s, var, 0.005 * p->radius, "collapses", err));
    return kit_rigid_only(kit_last(s), err);
  }
  return BASE_OK;
}

KIT_SCENE(arch, "semicircular masonry arch", "heyman1966",
          "Straight-edged voussoirs, dry joints. Limit analysis: it stands for a thickness above "
          "0.1075 R (Milankovitch) and enough friction, falls by hinges below, by sliding with too "
          "little friction. Highly hyperstatic, all joints at once (MATHEMATICS S7).",
          .situation = SITUATION_STACK);
