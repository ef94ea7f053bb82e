/* Box that tips over on an incline. */
#include "problems/scenes/kit.h"

typedef struct tip {
  double theta_deg, half_width, half_height, mu, gravity, duration;
} tip;

static const base_field fields[] = {
    BASE_FIELD(tip, theta_deg, BASE_REAL, "deg", 20.0, 0.1, 80.0, "slope"),
    BASE_FIELD(tip, half_width, BASE_REAL, "m", 0.1, 1e-3, 1e2, "half width b"),
    BASE_FIELD(tip, half_height, BASE_REAL, "m", 0.4, 1e-3, 1e2, "half height h"),
    BASE_FIELD(tip, mu, BASE_REAL, "1", 0.8, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(tip, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(tip, duration, BASE_REAL, "s", 0.4, 1e-3, 10.0, "time simulated"),
};

/* psi'' = (3g/4R) sin(psi), psi the angle of the centre past the vertical through the corner. */
static double topple(double psi, double rate, const void *ctx) {
  (void)rate;
  return *(const double *)ctx * sin(psi);
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const tip *p = param;
  const double th = kit_radians(p->theta_deg), b = p->half_width, h = p->half_height;
  const double R = sqrt(b * b + h * h), alpha = atan2(b, h), c = 3.0 * p->gravity / (4.0 * R);
  const double half[2] = {b, h}, n[2] = {sin(th), cos(th)}, pos[2] = {h * n[0], h * n[1]};
  double psi[2] = {th - alpha, 0.0};
  spec_body *box;
  kit_world(s, 2, p->gravity, p->duration, 0.01);
  BASE_TRY(kit_box(s, "block", 2.0, half, pos, &box, err));
  box->angle = -th;
  BASE_TRY(spec_add_static(s, "incline", n, 0.0, NULL, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "block.angle", err));
  if (tan(th) <= b / h || p->mu <= tan(th)) { /* rests or slides without turning */
    return (p->mu <= b / h || tan(th) <= b / h)
               ? kit_rests(s, "block.angle", 1e-7, "does not tip", err)
               : kit_finite(s, err);
  }
  kit_integrate(topple, &c, p->duration, psi);
  if (psi[0] > 1.2) {
    return kit_finite(s, err); /* lies down before the end */
  }
  BASE_TRY(kit_expect(s, "block.angle", p->duration, -(psi[0] + alpha), 1.6 * psi[1] + 0.1,
                      "psi'' = (3g/4R) sin psi", err));
  BASE_TRY(kit_rigid_only(kit_last(s), err));
  BASE_TRY(kit_expect(s, "block.omega", p->duration, -psi[1], 3.0 + c * psi[1],
                      "psi'' = (3g/4R) sin psi", err));
  return kit_rigid_only(kit_last(s), err);
}

KIT_SCENE(tip, "box on an incline: rest, slide or tip", "coulomb1785",
          "A box slides when the slope exceeds mu and tips about its lower corner when it exceeds "
          "b/h, whichever comes first; tipping follows the inverted pendulum of the corner "
          "(MATHEMATICS S6).",
          .situation = SITUATION_IMPACT);
