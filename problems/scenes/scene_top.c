/* Torque-free rotation. */
#include "problems/scenes/kit.h"

typedef struct top {
  double i1, i2, i3, w1, w2, w3, duration;
} top;

static const base_field fields[] = {
    BASE_FIELD(top, i1, BASE_REAL, "kg m^2", 1.0, 1e-3, 1e3, "first principal moment"),
    BASE_FIELD(top, i2, BASE_REAL, "kg m^2", 1.0, 1e-3, 1e3, "second"),
    BASE_FIELD(top, i3, BASE_REAL, "kg m^2", 1.9, 1e-3, 1e3, "third"),
    BASE_FIELD(top, w1, BASE_REAL, "rad/s", 1.0, -100.0, 100.0, "initial spin about the first"),
    BASE_FIELD(top, w2, BASE_REAL, "rad/s", 0.0, -100.0, 100.0, "second"),
    BASE_FIELD(top, w3, BASE_REAL, "rad/s", 3.0, -100.0, 100.0, "third"),
    BASE_FIELD(top, duration, BASE_REAL, "s", 0.4, 1e-3, 100.0, "time simulated"),
};

/* A symmetric top's omega turns about L with |L|/I1. */
static base_status predict_symmetric(scene_spec *s, const top *p, double scale, base_error *err) {
  const double L[3] = {p->i1 * p->w1, p->i2 * p->w2, p->i3 * p->w3};
  const double w[3] = {p->w1, p->w2, p->w3}, n = sqrt(L[0] * L[0] + L[1] * L[1] + L[2] * L[2]);
  const double angle = n / p->i1 * p->duration,
               along = (L[0] * w[0] + L[1] * w[1] + L[2] * w[2]) / (n * n);
  static const char *const vars[] = {"top.omega.x", "top.omega.y", "top.omega.z"};
  for (int k = 0; k < 3; k++) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double axial = along * L[k], across = (L[i] * w[j] - L[j] * w[i]) / n;
    const double value = axial + (w[k] - axial) * cos(angle) + across * sin(angle);
    BASE_TRY(
        kit_expect(s, vars[k], p->duration, value, scale, "omega turns about L with |L|/I1", err));
  }
  return BASE_OK;
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const top *p = param;
  const double half[3] = {0.1, 0.1, 0.1}, pos[3] = {0.0};
  const double w2 = p->w1 * p->w1 + p->w2 * p->w2 + p->w3 * p->w3;
  spec_body *b;
  spec_check *c;
  kit_world(s, 3, 0.0, p->duration, 0.002);
  BASE_TRY(kit_box(s, "top", 1.0, half, pos, &b, err));
  b->inertia[0] = p->i1;
  b->inertia[1] = p->i2;
  b->inertia[2] = p->i3;
  b->omega[0] = p->w1;
  b->omega[1] = p->w2;
  b->omega[2] = p->w3;
  s->effects = EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "top.omega", err));
  const double scale = 4.0 * w2 * p->duration;
  if (p->i1 == p->i2) {
    BASE_TRY(predict_symmetric(s, p, sqrt(w2) * scale, err));
  }
  BASE_TRY(spec_add_check(s, CHECK_ANGULAR_MOMENTUM_DRIFT_REL, NULL, &c, err));
  kit_source(c, "no torque about the centre");
  c->tol.abs = 1e-9;
  c->tol.h = scale;
  BASE_TRY(spec_add_check(s, CHECK_ENERGY_GROWTH_REL, NULL, &c, err));
  kit_source(c, "no torque about the centre");
  c->tol.abs = 1e-9;
  return BASE_OK;
}

KIT_SCENE(top, "torque-free rotation", "euler1758",
          "A body spins freely. The omega of a symmetric top turns about the angular momentum with "
          "|L|/I1; about the middle axis of an asymmetric body the motion is unstable and flips. "
          "The only scene that exposes a missing gyroscopic term, and energy growth of an explicit "
          "one (MATHEMATICS S11).",
          .situation = SITUATION_OTHER);
