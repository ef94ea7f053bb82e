/* Row of discs on a ramp. */
#include "problems/scenes/kit.h"

#include <string.h>

typedef struct row {
  int n;
  double theta_deg, heavy, radius, gravity;
} row;

static const base_field fields[] = {
    BASE_FIELD(row, n, BASE_INT, "1", 20, 1, 10000, "discs"),
    BASE_FIELD(row, theta_deg, BASE_REAL, "deg", 30.0, 1.0, 80.0, "slope"),
    BASE_FIELD(row, heavy, BASE_REAL, "kg", 1000.0, 1e-6, 1e9, "mass of the last; others 1 kg"),
    BASE_FIELD(row, radius, BASE_REAL, "m", 0.05, 1e-3, 1e2, "radius"),
    BASE_FIELD(row, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

/* Force between neighbours: g sin(theta) times the masses above. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const row *p = param;
  const double th = kit_radians(p->theta_deg), r = p->radius, g = p->gravity;
  const double ramp[2] = {-sin(th), cos(th)}, stop[2] = {cos(th), sin(th)};
  double above = (p->n - 1) + p->heavy;
  const double total = above;
  char name[SPEC_NAME], below[SPEC_NAME] = "stop";
  kit_world(s, 2, g, 0.2, 0.01);
  for (int i = 0; i < p->n; i++) {
    const double u = r * (2.0 * i + 1.0);
    const double pos[2] = {u * stop[0] + r * ramp[0], u * stop[1] + r * ramp[1]};
    spec_body *b;
    kit_name(name, "s", i);
    BASE_TRY(kit_ball(s, name, (i == p->n - 1) ? p->heavy : 1.0, r, pos, &b, err));
    b->lock = SPEC_RZ;
  }
  BASE_TRY(spec_add_static(s, "ramp", ramp, 0.0, NULL, err));
  BASE_TRY(spec_add_static(s, "stop", stop, 0.0, NULL, err));
  for (int i = 0; i < p->n && i < 25; i++) {
    kit_name(name, "s", i);
    BASE_TRY(kit_force(s, name, below, false, 0.1, 0.2, g * sin(th) * above, 1e-6 * g * total, NULL,
                       err));
    kit_source(kit_last(s), "g sin(theta) sum of masses above");
    memcpy(below, name, sizeof below);
    above -= 1.0;
  }
  s->effects = EFFECT_CONTACT;
  BASE_TRY(spec_add_observe(s, "s0.pos", err));
  return kit_drift(s, "s0.x", 1e-6, 0.0, NULL, err);
}

KIT_SCENE(row, "row of discs on a ramp, heavy end", "",
          "Discs in a row lean on a stop at the foot of a smooth ramp, the last one a thousand "
          "times heavier: forces follow from statics, sweeps need as many passes as the mass "
          "ratio. The contact-only twin of a chain with a heavy end (MATHEMATICS S12).",
          .situation = SITUATION_STACK);
