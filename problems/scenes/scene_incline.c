/* Block on an incline. */
#include "problems/scenes/kit.h"

#include <stdio.h>
#include <string.h>

typedef struct incline {
  double theta_deg, mu, mass, half_x, half_y, half_z, gravity, duration;
  int dim;
} incline;

static const base_field fields[] = {
    BASE_FIELD(incline, theta_deg, BASE_REAL, "deg", 20.0, 0.0, 89.0, "slope"),
    BASE_FIELD(incline, mu, BASE_REAL, "1", 0.5, 0.0, 100.0, "friction coefficient"),
    BASE_FIELD(incline, dim, BASE_INT, "1", 3, 2, 3, "dimension"),
    BASE_FIELD(incline, mass, BASE_REAL, "kg", 2.0, 1e-6, 1e9, "mass of the block"),
    BASE_FIELD(incline, half_x, BASE_REAL, "m", 0.2, 1e-4, 1e3, "half length along the slope"),
    BASE_FIELD(incline, half_y, BASE_REAL, "m", 0.15, 1e-4, 1e3, "half width across it"),
    BASE_FIELD(incline, half_z, BASE_REAL, "m", 0.1, 1e-4, 1e3, "half height"),
    BASE_FIELD(incline, gravity, BASE_REAL, "m/s^2", 9.81, 0.0, 1e3, "gravity"),
    BASE_FIELD(incline, duration, BASE_REAL, "s", 1.0, 1e-6, 1e5, "time simulated"),
};

/* Component along the slope, downhill positive. */
static void downhill(const scene_spec *s, double theta, spec_check *c) {
  c->has_dir = true;
  c->dir[0] = cos(theta);
  c->dir[kit_up(s)] = -sin(theta);
}

/* Sticks: no motion. A bristle deflects by (tan/mu) of its saturation, a viscous model creeps with
 * (tan/mu) v_s; a lagged normal force costs a frictionless step (MATHEMATICS B1). */
static base_status predict_stick(scene_spec *s, const incline *p, double theta, base_error *err) {
  spec_check *c;
  const double share = (p->mu > 0.0) ? tan(theta) / p->mu : 0.0, T = p->duration;
  BASE_TRY(kit_drift(s, "block.pos", 1e-8, 0.0, &c, err));
  downhill(s, theta, c);
  kit_source(c, "stick: tan(theta) <= mu, no motion");
  BASE_TRY(kit_rigid_only(c, err));
  BASE_TRY(kit_drift(s, "block.pos", 1e-8, 8.2 * p->gravity * sin(theta), &c, err));
  downhill(s, theta, c);
  c->tol.reg_v = 1.05 * share * T;
  c->tol.reg_d = 1.05 * share;
  kit_source(c, "stick: creep v_s tan/mu or sag delta tan/mu");
  BASE_TRY(spec_check_only(c, "regularized", err));
  BASE_TRY(spec_add_state(s, "block.vel", T, 0.0, 1e-7, 0.0, err));
  c = &s->check[s->n_check - 1];
  downhill(s, theta, c);
  c->tol.reg_v = 1.02 * share;
  kit_source(c, "stick");
  return BASE_OK;
}

/* Slips: constant acceleration g (sin - mu cos). */
static base_status predict_slip(scene_spec *s, const incline *p, double theta, base_error *err) {
  const double g = p->gravity, T = p->duration, a = g * (sin(theta) - p->mu * cos(theta));
  BASE_TRY(spec_add_state(s, "block.pos", T, a * T * T / 2.0, 1e-9, 0.6 * a * T, err));
  spec_check *c = &s->check[s->n_check - 1];
  downhill(s, theta, c);
  c->tol.reg_h = 1.2 * g * T;
  c->tol.reg_v = 1.5 * T;
  kit_source(c, "slip: g (sin - mu cos) T^2/2");
  BASE_TRY(spec_add_state(s, "block.vel", T, a * T, 1e-8, 0.0, err));
  c = &s->check[s->n_check - 1];
  downhill(s, theta, c);
  c->tol.reg_h = 1.5 * g;
  c->tol.reg_v = 1.5;
  kit_source(c, "slip: g (sin - mu cos) T");
  return BASE_OK;
}

static base_status predict_forces(scene_spec *s, const incline *p, double theta, base_error *err) {
  spec_check *c;
  const double N = p->mass * p->gravity * cos(theta);
  const double F = fmin(p->mass * p->gravity * sin(theta), p->mu * N);
  BASE_TRY(kit_force(s, "block", "incline", false, p->duration / 2.0, p->duration, N,
                     1e-6 * (N + 1e-9), &c, err));
  kit_source(c, "m g cos(theta)");
  BASE_TRY(kit_rigid_only(c, err));
  BASE_TRY(kit_force(s, "block", "incline", true, p->duration / 2.0, p->duration, F,
                     1e-6 * (N + 1e-9), &c, err));
  kit_source(c, "min(m g sin(theta), mu m g cos(theta))");
  return kit_rigid_only(c, err);
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const incline *p = param;
  const double theta = kit_radians(p->theta_deg);
  const double half[3] = {p->half_x, (p->dim == 3) ? p->half_y : p->half_z, p->half_z};
  double normal[3] = {sin(theta)}, pos[3] = {0.0};
  kit_world(s, p->dim, p->gravity, p->duration, 0.01);
  normal[kit_up(s)] = cos(theta);
  for (int k = 0; k < 3; k++) {
    pos[k] = p->half_z * normal[k];
  }
  spec_body *b;
  BASE_TRY(kit_box(s, "block", p->mass, half, pos, &b, err));
  b->angle = -theta;
  if (p->dim == 3) {
    kit_turn(b, (const double[3]){0.0, 1.0, 0.0}, theta);
  }
  BASE_TRY(spec_add_static(s, "incline", normal, 0.0, NULL, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "block.pos", err));
  BASE_TRY(spec_add_observe(s, "block.vel", err));
  const bool slips = tan(theta) > p->mu;
  /* base force within the base: min(tan, mu) half_z <= half_x, else the block tips over */
  if (fmin(tan(theta), p->mu) * p->half_z >= p->half_x) {
    return BASE_OK;
  }
  BASE_TRY(slips ? predict_slip(s, p, theta, err) : predict_stick(s, p, theta, err));
  BASE_TRY(predict_forces(s, p, theta, err));
  return spec_add_off(s, EFFECT_FRICTION, "block.pos", p->duration,
                      p->gravity * sin(theta) * p->duration * p->duration / 2.0, 1e-8,
                      0.6 * p->gravity * sin(theta) * p->duration, err);
}

const scene scene_incline = {
    .name = "incline",
    .title = "block on an incline",
    .cite = "coulomb1785",
    .about =
        "A homogeneous block at rest on a plane of slope theta. It sticks for tan(theta) <= mu and "
        "slides with the constant acceleration g (sin(theta) - mu cos(theta)) otherwise; the "
        "contact carries m g cos(theta) on four corners (two in the plane), a hyperstatic split. "
        "The standard first test of a friction model: sag of a bristle and creep of a viscous "
        "regularisation are visible here (MATHEMATICS B1).",
    .situation = SITUATION_SLIDING,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .param_size = sizeof(incline),
    .build = build,
};
