/* Euler's disc. */
#include "problems/scenes/kit.h"

typedef struct euler_disc {
  double alpha_deg, radius, mass, mu, gravity, duration;
} euler_disc;

static const base_field fields[] = {
    BASE_FIELD(euler_disc, alpha_deg, BASE_REAL, "deg", 20.0, 1.0, 80.0, "inclination"),
    BASE_FIELD(euler_disc, radius, BASE_REAL, "m", 0.05, 1e-3, 1e2, "radius"),
    BASE_FIELD(euler_disc, mass, BASE_REAL, "kg", 0.2, 1e-6, 1e6, "mass"),
    BASE_FIELD(euler_disc, mu, BASE_REAL, "1", 1.5, 0.0, 10.0, "friction coefficient"),
    BASE_FIELD(euler_disc, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(euler_disc, duration, BASE_REAL, "s", 0.2, 1e-3, 1e2, "time simulated"),
};

/* Steady: Omega^2 sin(alpha) = 4g/r, omega = Omega sin(alpha) along the contact diameter. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const euler_disc *p = param;
  const double a = kit_radians(p->alpha_deg), r = p->radius;
  const double spin = sqrt(4.0 * p->gravity * sin(a) / r);
  spec_body *b;
  kit_world(s, 3, p->gravity, p->duration, 0.001 * sqrt(r / 0.05));
  BASE_TRY(spec_add_body(s, "disc", &b, err));
  b->shape.kind = SPEC_DISC3D;
  b->shape.r = r;
  b->mass = p->mass;
  BASE_TRY(spec_solid_inertia(&b->shape, 3, p->mass, b->inertia, err));
  b->pos[2] = r * sin(a);
  kit_turn(b, (const double[3]){0.0, 1.0, 0.0}, a);
  b->omega[0] = -spin * cos(a);
  b->omega[2] = spin * sin(a);
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  s->facets = 8;
  BASE_TRY(spec_add_observe(s, "disc.z", err));
  BASE_TRY(kit_expect(s, "disc.z", p->duration, r * sin(a), 3.0 * sqrt(r / 0.05),
                      "steady precession", err));
  kit_last(s)->tol.abs = 2e-5 * r;
  BASE_TRY(kit_finite(s, err));
  return kit_energy(s, 1e-6 * p->mass * p->gravity * r, 4.0 * p->mass * p->gravity * r / 0.05, err);
}

KIT_SCENE(euler_disc, "Euler's disc in steady precession", "moffatt2000",
          "A thin disc precesses on its rim with Omega^2 sin(alpha) = 4g/r, its centre at rest and "
          "no loss: every loss is numerical. Rotation update, gyroscopic term and rim contact all "
          "show (MATHEMATICS S10).",
          .situation = SITUATION_OTHER);
