/* Stick-slip on a belt. */
#include "problems/scenes/kit.h"

typedef struct belt {
  double speed, mu_static, mu_kinetic, stiffness, mass, gravity;
} belt;

static const base_field fields[] = {
    BASE_FIELD(belt, speed, BASE_REAL, "m/s", 0.1, 1e-6, 1e3, "speed of the belt"),
    BASE_FIELD(belt, mu_static, BASE_REAL, "1", 0.4, 1e-6, 10.0, "static coefficient"),
    BASE_FIELD(belt, mu_kinetic, BASE_REAL, "1", 0.3, 0.0, 10.0, "kinetic coefficient"),
    BASE_FIELD(belt, stiffness, BASE_REAL, "N/m", 20.0, 1e-6, 1e9, "spring to the wall"),
    BASE_FIELD(belt, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e9, "mass"),
    BASE_FIELD(belt, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

/* D = (mu_s - mu_k) N/K, w = sqrt(K/m): x in mu_k N/K +- sqrt(D^2 + (v_b/w)^2), period
 * (2/w)(pi - atan(wD/v_b)) + 2D/v_b (MATHEMATICS B16). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const belt *p = param;
  const double N = p->mass * p->gravity, K = p->stiffness, w = sqrt(K / p->mass);
  const double D = fmax(p->mu_static - p->mu_kinetic, 0.0) * N / K;
  const double slip = 2.0 / w * (KIT_PI - atan(w * D / p->speed)), stick = 2.0 * D / p->speed;
  const double swing = sqrt(D * D + p->speed * p->speed / (w * w)), mean = p->mu_kinetic * N / K;
  const double half[2] = {0.1, 0.05}, pos[2] = {0.0, 0.05}, first = p->mu_static * N / K / p->speed;
  spec_body *b;
  spec_load *l;
  spec_static *floor;
  const double up[2] = {0.0, 1.0};
  kit_world(s, 2, p->gravity, first + 2.0 * (slip + stick), 1e-3 / w);
  BASE_TRY(kit_box(s, "block", p->mass, half, pos, &b, err));
  b->vel[0] = p->speed;
  b->lock = SPEC_RZ;
  BASE_TRY(spec_add_static(s, "belt", up, 0.0, &floor, err));
  floor->surface_velocity[0] = p->speed;
  BASE_TRY(spec_add_load(s, &l, err));
  l->kind = SPEC_SPRING;
  l->body = 0;
  l->k = K;
  l->dir[0] = 1.0;
  s->friction.dflt = p->mu_static;
  s->friction_kinetic.dflt = p->mu_kinetic;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION;
  BASE_TRY(spec_add_observe(s, "block.x", err));
  if (p->mu_kinetic >= p->mu_static) {
    return kit_finite(s, err);
  }
  static const spec_check_kind kinds[] = {CHECK_WINDOW_MAX, CHECK_WINDOW_MIN};
  static const char *const two_coefficients[] = {
      "velocity", "position", "boxed", "coulomb", "acceleration", "event", "regularized"};
  for (int i = 0; i < 2; i++) {
    spec_check *c;
    BASE_TRY(spec_add_check(s, kinds[i], "block.x", &c, err));
    c->t0 = first;
    c->value = (i == 0) ? mean + swing : mean - swing;
    c->tol.abs = 0.01 * swing;
    c->tol.h = 2.0 * p->speed;
    c->tol.reg_d = 2.0;
    kit_source(c, "mu_k N/K +- sqrt(D^2 + (v_b/w)^2)");
    for (int k = 0; k < BASE_COUNT(two_coefficients); k++) {
      BASE_TRY(spec_check_only(c, two_coefficients[k], err));
    }
  }
  return kit_finite(s, err);
}

KIT_SCENE(belt, "stick-slip on a belt", "leine1998",
          "A mass on a spring is dragged by a belt and slips back periodically, because the static "
          "coefficient exceeds the kinetic one: period (2/w)(pi - atan(w D/v)) + 2 D/v and swing "
          "sqrt(D^2 + (v/w)^2) about mu_k N/K. Models with one coefficient do not oscillate "
          "(MATHEMATICS B16).",
          .situation = SITUATION_SLIDING);
