/* Housner's rocking block. */
#include "problems/scenes/kit.h"

typedef struct rocking {
  double half_width, half_height, tilt, mu, gravity;
} rocking;

static const base_field fields[] = {
    BASE_FIELD(rocking, half_width, BASE_REAL, "m", 0.1, 1e-3, 1e3, "half width b"),
    BASE_FIELD(rocking, half_height, BASE_REAL, "m", 0.4, 1e-3, 1e3, "half height h"),
    BASE_FIELD(rocking, tilt, BASE_REAL, "1", 0.4, 0.01, 0.9, "initial tilt over alpha"),
    BASE_FIELD(rocking, mu, BASE_REAL, "1", 0.6, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(rocking, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

/* psi = alpha - tilt: psi'' = (3g/4R) sin psi; *ctx is 3g/4R. */
static double topple(double psi, double rate, const void *ctx) {
  (void)rate;
  return *(const double *)ctx * sin(psi);
}

/* Time from rest at psi0 to psi1 > psi0, by bisection on the integrated motion. */
static double time_to(double p2, double psi0, double psi1) {
  double lo = 0.0, hi = 1.0 / sqrt(p2);
  double y[2];
  do {
    hi *= 2.0;
    y[0] = psi0;
    y[1] = 0.0;
    kit_integrate(topple, &p2, hi, y);
  } while (y[0] < psi1);
  for (int i = 0; i < 45; i++) {
    const double mid = 0.5 * (lo + hi);
    y[0] = psi0;
    y[1] = 0.0;
    kit_integrate(topple, &p2, mid, y);
    *((y[0] < psi1) ? &lo : &hi) = mid;
  }
  return lo;
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const rocking *p = param;
  const double b = p->half_width, h = p->half_height, R = sqrt(b * b + h * h);
  const double alpha = atan2(b, h), tilt = p->tilt * alpha, p2 = 3.0 * p->gravity / (4.0 * R);
  const double hit = time_to(p2, alpha - tilt, alpha), r = 1.0 - 1.5 * sin(alpha) * sin(alpha);
  const double before = sqrt(2.0 * p2 * (cos(alpha - tilt) - cos(alpha)));
  /* turned by +tilt about the lower left corner, which stands at (-b, 0) */
  const double half[2] = {b, h};
  const double pos[2] = {R * sin(alpha - tilt) - b, R * cos(alpha - tilt)};
  spec_body *block;
  kit_world(s, 2, p->gravity, 2.5 * hit, 0.002);
  BASE_TRY(kit_box(s, "block", 5.0, half, pos, &block, err));
  block->angle = tilt;
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "block.angle", err));
  spec_check *c;
  if (p->mu < 3.0 * sin(alpha) * cos(alpha) / (1.0 + 3.0 * cos(alpha) * cos(alpha)) || r <= 0.0) {
    return kit_finite(s, err); /* slips at the impact: no Housner ratio */
  }
  BASE_TRY(spec_add_check(s, CHECK_EVENT_TIME, "block.angle", &c, err));
  c->event = EVENT_SIGN_CHANGE;
  c->value = hit;
  c->tol.abs = 1e-6;
  c->tol.h = 4.0;
  kit_source(c, "first impact of the rocking equation");
  BASE_TRY(kit_rigid_only(c, err));
  const double apex = alpha - acos(cos(alpha) + r * r * before * before / (2.0 * p2));
  BASE_TRY(spec_add_check(s, CHECK_WINDOW_MIN, "block.angle", &c, err));
  c->t1 = 2.5 * hit;
  c->value = -apex;
  c->tol.abs = 1e-9;
  c->tol.h = 4.0;
  kit_source(c, "apex after omega+/omega- = 1 - 1.5 sin^2 alpha (Housner 1963)");
  return kit_rigid_only(c, err);
}

KIT_SCENE(
    rocking, "rocking block", "housner1963",
    "A tilted block rocks back and hits with its other corner; angular momentum about the "
    "new corner gives omega+/omega- = 1 - 1.5 sin^2(alpha), which is exactly the solution of "
    "the complementarity problem for e = 0 when mu >= 3 sin cos/(1 + 3 cos^2) (MATHEMATICS B11).",
    .situation = SITUATION_IMPACT);
