/* Sliding block that comes to rest. */
#include "problems/scenes/kit.h"

typedef struct slide {
  double speed, mu, mass, half, height, angle_deg, gravity;
  int dim;
} slide;

static const base_field fields[] = {
    BASE_FIELD(slide, speed, BASE_REAL, "m/s", 5.0, 0.0, 1e4, "initial speed"),
    BASE_FIELD(slide, mu, BASE_REAL, "1", 0.5, 1e-6, 100.0, "friction coefficient"),
    BASE_FIELD(slide, angle_deg, BASE_REAL, "deg", 0.0, 0.0, 360.0,
               "direction in the floor (3D): off the facets of a polyhedral cone it shows their "
               "anisotropy"),
    BASE_FIELD(slide, dim, BASE_INT, "1", 3, 2, 3, "dimension"),
    BASE_FIELD(slide, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e9, "mass of the block"),
    BASE_FIELD(slide, half, BASE_REAL, "m", 0.25, 1e-4, 1e3, "half length and width"),
    BASE_FIELD(slide, height, BASE_REAL, "m", 0.1, 1e-4, 1e3, "half height"),
    BASE_FIELD(slide, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

/* d = v0^2/(2 mu g) after t = v0/(mu g); semi-implicit Euler stops v0 h/2 short (MATHEMATICS B2). Exact
 * for an isotropic cone; a polyhedral one only along a facet (MATHEMATICS B2, B3). */
static base_status predict(scene_spec *s, const slide *p, const double *dir, base_error *err) {
  const double a = p->mu * p->gravity, v = p->speed, stop = v / a, d = v * v / (2.0 * a);
  const double T = s->duration;
  const bool along_facet = dir[0] == 1.0;
  BASE_TRY(spec_add_state(s, "block.pos", T, d, 1e-9, 0.6 * v, err));
  spec_check *c = &s->check[s->n_check - 1];
  c->has_dir = true;
  c->dir[0] = dir[0];
  c->dir[1] = dir[1];
  c->tol.reg_h = 1.3 * v;
  c->tol.reg_v = 0.03 * v / a + 0.5 * stop;
  kit_source(c, "stopping distance v0^2/(2 mu g)");
  if (!along_facet) {
    BASE_TRY(spec_check_only(c, "regularized", err));
    BASE_TRY(spec_check_only(c, "coulomb", err));
  }
  BASE_TRY(spec_add_state(s, "block.vel", T, 0.0, 1e-8, 0.0, err));
  s->check[s->n_check - 1].tol.reg_v = 0.01;
  kit_source(&s->check[s->n_check - 1], "at rest");
  BASE_TRY(spec_add_check(s, CHECK_EVENT_TIME, "block.vel", &c, err));
  c->event = EVENT_STOP;
  c->threshold = 1e-6 * v;
  c->value = stop;
  c->tol.abs = 1e-9;
  c->tol.h = 2.5;
  kit_source(c, "v0/(mu g)");
  if (along_facet) {
    BASE_TRY(kit_rigid_only(c, err));
  } else {
    BASE_TRY(spec_check_only(c, "coulomb", err));
  }
  return kit_energy(s, 1e-9 * p->mass * v * v, 0.0, err);
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const slide *p = param;
  const double angle = (p->dim == 3) ? kit_radians(p->angle_deg) : 0.0;
  const double dir[2] = {cos(angle), (p->dim == 3) ? sin(angle) : 0.0};
  const double half[3] = {p->half, (p->dim == 3) ? p->half : p->height, p->height};
  double pos[3] = {0.0};
  if (!(p->speed > 0.0)) {
    return BASE_FAIL(err, BASE_EINVAL, "speed = %g: need > 0", p->speed);
  }
  kit_world(s, p->dim, p->gravity, 1.5 * p->speed / (p->mu * p->gravity), 0.01);
  pos[kit_up(s)] = p->height;
  spec_body *b;
  BASE_TRY(kit_box(s, "block", p->mass, half, pos, &b, err));
  b->vel[0] = p->speed * dir[0];
  b->vel[1] = (p->dim == 3) ? p->speed * dir[1] : 0.0;
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "block.x", err));
  BASE_TRY(spec_add_observe(s, "block.vel", err));
  if (p->mu * p->height >= p->half) {
    return BASE_OK; /* tumbles: no closed form */
  }
  BASE_TRY(predict(s, p, dir, err));
  BASE_TRY(spec_add_off(s, EFFECT_FRICTION, "block.pos", s->duration, p->speed * s->duration, 1e-8,
                        0.0, err));
  spec_check *c = &s->off[0].check;
  c->has_dir = true;
  c->dir[0] = dir[0];
  c->dir[1] = dir[1];
  return BASE_OK;
}

const scene scene_slide = {
    .name = "slide",
    .title = "sliding block that stops",
    .cite = "coulomb1785",
    .about =
        "A block slides on a floor with friction and stops after v0/(mu g) at v0^2/(2 mu g); with "
        "the default numbers after 2.548 m, the box test of Project Chrono. In 3D the direction is "
        "a parameter: along a facet of a polyhedral cone the answer is exact, between facets the "
        "block goes astray by up to pi/nd and too far by up to 1/cos(pi/nd), while an isotropic "
        "model stays on its line (MATHEMATICS B2, B3).",
    .situation = SITUATION_SLIDING,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .param_size = sizeof(slide),
    .build = build,
};
