/* Painleve's sliding rod. */
#include "problems/scenes/kit.h"

#include <stdio.h>

typedef struct painleve {
  double theta_deg, mu, omega, speed, half, gravity;
} painleve;

static const base_field fields[] = {
    BASE_FIELD(painleve, theta_deg, BASE_REAL, "deg", 63.43494882292201, 1.0, 89.0, "inclination"),
    BASE_FIELD(painleve, mu, BASE_REAL, "1", 2.0, 0.0, 100.0, "friction coefficient"),
    BASE_FIELD(painleve, omega, BASE_REAL, "rad/s", 0.0, -100.0, 100.0, "spin"),
    BASE_FIELD(painleve, speed, BASE_REAL, "m/s", -1.0, -100.0, 100.0,
               "slip of the tip; negative: away from the side the rod leans to"),
    BASE_FIELD(painleve, half, BASE_REAL, "m", 1.0, 1e-3, 1e3, "half length"),
    BASE_FIELD(painleve, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

static base_status after_step(scene_spec *s, const char *var, double value, double slope,
                              double h_coef, double h2_coef, base_error *err) {
  spec_check *c;
  BASE_TRY(spec_add_check(s, CHECK_STATE_AFTER_STEPS, var, &c, err));
  c->n = 1;
  c->value = value;
  c->dvalue_dh = slope;
  c->tol.abs = 1e-6;
  c->tol.h = h_coef;
  c->tol.h2 = h2_coef;
  kit_source(c, "free motion, or the impulse of sticking");
  return kit_rigid_only(c, err);
}

/* Sticking impulse P = -W^-1 (u_t, 0): the impact without collision of the inconsistent regime. */
static base_status predict_impact(scene_spec *s, const painleve *p, const double v[3],
                                  base_error *err) {
  const double th = kit_radians(p->theta_deg), l = p->half, I = l * l / 3.0;
  const double Wn = 1.0 + l * l * cos(th) * cos(th) / I, Wt = 1.0 + l * l * sin(th) * sin(th) / I;
  const double X = -l * l * sin(th) * cos(th) / I, det = Wn * Wt - X * X;
  const double Pn = X * p->speed / det, Pt = -Wn * p->speed / det;
  const double dw = (-l * cos(th) * Pn + l * sin(th) * Pt) / I;
  BASE_TRY(after_step(s, "rod.vx", v[0] + Pt, 0.0, 8.0, 0.0, err));
  BASE_TRY(after_step(s, "rod.vy", v[1] + Pn, 0.0, 8.0, 0.0, err));
  return after_step(s, "rod.omega", v[2] + dw, 0.0, 16.0, 0.0, err);
}

static base_status predict_slip(scene_spec *s, const painleve *p, const double v[3], double N,
                                base_error *err) {
  const double th = kit_radians(p->theta_deg), l = p->half, I = l * l / 3.0;
  const double F = -copysign(p->mu * N, p->speed);
  BASE_TRY(after_step(s, "rod.vx", v[0], F, 0.0, 200.0, err));
  return after_step(s, "rod.omega", v[2], (-l * cos(th) * N + l * sin(th) * F) / I, 0.0, 400.0,
                    err);
}

/* Unit mass; normal acceleration of the tip p N + b (MATHEMATICS 2.3.8). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const painleve *q = param;
  const double th = kit_radians(q->theta_deg), l = q->half, sine = sin(th), cosine = cos(th);
  const double slip = (q->speed < 0.0) ? -1.0 : 1.0;
  const double v[3] = {q->speed - q->omega * l * sine, q->omega * l * cosine, q->omega};
  const double p = 1.0 + 3.0 * cosine * (cosine + slip * q->mu * sine);
  const double b = l * q->omega * q->omega * sine - q->gravity;
  spec_body *rod;
  kit_world(s, 2, q->gravity, 0.05, 0.001);
  BASE_TRY(spec_add_body(s, "rod", &rod, err));
  rod->shape.kind = SPEC_ROD;
  rod->shape.half[0] = l;
  rod->mass = 1.0;
  rod->inertia[0] = l * l / 3.0;
  rod->pos[0] = l * cosine;
  rod->pos[1] = l * sine;
  rod->angle = th;
  rod->vel[0] = v[0];
  rod->vel[1] = v[1];
  rod->omega[2] = v[2];
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = q->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  s->acceleration =
      (spec_acceleration){true, p, b, (1.0 + 3.0 * cosine * cosine) / (3.0 * sine * cosine), ""};
  const char *regime =
      (p > 0.0) ? (b < 0.0 ? "slip" : "flight") : (b < 0.0 ? "inconsistent" : "indeterminate");
  BASE_TRY(spec_text(s->acceleration.regime, SPEC_NAME, regime, "regime", err));
  BASE_TRY(spec_add_observe(s, "rod.vel", err));
  BASE_TRY(spec_add_observe(s, "rod.omega", err));
  if (p < 0.0 && b < 0.0) {
    BASE_TRY(predict_impact(s, q, v, err));
  } else if (p > 0.0 && b < 0.0 && q->speed != 0.0) {
    BASE_TRY(predict_slip(s, q, v, -b / p, err));
  }
  BASE_TRY(kit_finite(s, err));
  return kit_energy(s, 1e-9, 0.1, err);
}

KIT_SCENE(
    painleve, "Painleve's sliding rod", "genot1999",
    "The tip of a leaning rod slides on a rough floor. Where p = 1/m + (l^2/I) cos (cos - mu "
    "sin) is negative the acceleration-level problem has no solution (inconsistent) or "
    "several (indeterminate); mu_crit = (1 + 3 cos^2)/(3 sin cos), least 4/3 at tan = 2. Time "
    "stepping must then stop the tip within one step, for every h (MATHEMATICS B8).",
    .situation = SITUATION_OTHER);
