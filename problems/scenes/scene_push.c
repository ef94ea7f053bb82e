/* Block under a growing push, or dragged by a spring. */
#include "problems/scenes/kit.h"

typedef struct push {
  int by;
  double rate, stiffness, speed, mu, mass, gravity;
} push;

static const base_field fields[] = {
    BASE_FIELD_CHOICE(push, by, "ramp|spring", 0, "a growing force, or a spring pulled along"),
    BASE_FIELD(push, rate, BASE_REAL, "N/s", 4.0, 1e-6, 1e9, "growth of the force"),
    BASE_FIELD(push, stiffness, BASE_REAL, "N/m", 50.0, 1e-6, 1e9, "of the spring"),
    BASE_FIELD(push, speed, BASE_REAL, "m/s", 0.2, 1e-6, 1e3, "of the spring's end"),
    BASE_FIELD(push, mu, BASE_REAL, "1", 0.5, 1e-6, 10.0, "friction coefficient"),
    BASE_FIELD(push, mass, BASE_REAL, "kg", 2.0, 1e-6, 1e6, "mass"),
    BASE_FIELD(push, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

/* Breaks away at t* = F/rate or F/(k V), F = mu m g; then m x'' = rate (t - t*), or the spring law
 * x = V tau - (V/w) sin(w tau). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const push *p = param;
  const bool ramp = p->by == 0;
  const double F = p->mu * p->mass * p->gravity, w = sqrt(p->stiffness / p->mass);
  const double start = ramp ? F / p->rate : F / (p->stiffness * p->speed);
  const double tau = ramp ? 0.6 * start : 2.0 / w, T = start + tau, V = p->speed;
  const double a = ramp ? p->rate * tau / p->mass : w * V;
  const double v = ramp ? a * tau / 2.0 : V * (1.0 - cos(w * tau));
  const double x = ramp ? a * tau * tau / 6.0 : V * tau - V / w * sin(w * tau);
  const double half[2] = {0.2, 0.05}, pos[2] = {0.0, 0.05};
  spec_load *l;
  spec_check *c;
  kit_world(s, 2, p->gravity, T, fmin(0.01, T / 50.0));
  BASE_TRY(kit_box(s, "block", p->mass, half, pos, NULL, err));
  BASE_TRY(kit_floor(s, err));
  BASE_TRY(spec_add_load(s, &l, err));
  l->kind = ramp ? SPEC_FORCE_RAMP : SPEC_SPRING;
  l->body = 0;
  l->dir[0] = 1.0;
  l->rate = p->rate;
  l->k = ramp ? 0.0 : p->stiffness;
  l->anchor_vel[0] = V;
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "block.x", err));
  BASE_TRY(kit_rests(s, "block.x", 1e-8, "sticks until mu m g", err));
  c = kit_last(s);
  c->t1 = 0.99 * start;
  BASE_TRY(kit_expect(s, "block.vx", T, v, 2.0 * a, "after breaking away", err));
  kit_last(s)->tol.reg_h = 4.0 * a;
  kit_last(s)->tol.reg_v = 10.0;
  BASE_TRY(kit_expect(s, "block.x", T, x, 2.0 * a * tau, "after breaking away", err));
  kit_last(s)->tol.reg_h = 4.0 * a * tau;
  kit_last(s)->tol.reg_v = 2.0 * T;
  kit_last(s)->tol.reg_d = 2.0;
  return BASE_OK;
}

KIT_SCENE(push, "pushed until it slips", "coulomb1785",
          "A block under a slowly growing force, or behind a spring pulled at constant speed, "
          "sticks exactly until mu m g and then moves by a closed form: the threshold of static "
          "friction in time (MATHEMATICS S3).",
          .situation = SITUATION_SLIDING);
