/* A ball stopped by rolling and drilling friction. */
#include "problems/scenes/kit.h"

typedef struct billiard {
  double speed, spin, rolling, drilling, mu, radius, mass, gravity;
} billiard;

static const base_field fields[] = {
    BASE_FIELD(billiard, speed, BASE_REAL, "m/s", 0.5, 1e-6, 1e3, "speed at which it rolls"),
    BASE_FIELD(billiard, spin, BASE_REAL, "rad/s", 10.0, 1e-6, 1e5, "spin about the vertical"),
    BASE_FIELD(billiard, rolling, BASE_REAL, "m", 2e-3, 1e-9, 1.0,
               "coefficient of rolling friction: moment over normal force"),
    BASE_FIELD(billiard, drilling, BASE_REAL, "m", 5e-4, 1e-9, 1.0,
               "coefficient of drilling friction: moment over normal force"),
    BASE_FIELD(billiard, mu, BASE_REAL, "1", 0.3, 1e-6, 100.0, "friction coefficient"),
    BASE_FIELD(billiard, radius, BASE_REAL, "m", 0.03, 1e-4, 1e3, "radius"),
    BASE_FIELD(billiard, mass, BASE_REAL, "kg", 0.2, 1e-6, 1e9, "mass"),
    BASE_FIELD(billiard, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

/* Half way to the stop of a quantity that falls evenly from x0 to 0 within `stop`, and the stop. */
static base_status falls_evenly(scene_spec *s, const char *var, double x0, double stop,
                                const char *source, base_error *err) {
  spec_check *c;
  BASE_TRY(kit_expect(s, var, stop / 2.0, x0 / 2.0, 2.0 * fabs(x0) / stop, source, err));
  kit_last(s)->tol.abs = 1e-6 * fabs(x0);
  kit_last(s)->tol.reg_v = 1.0;
  BASE_TRY(spec_add_check(s, CHECK_EVENT_TIME, var, &c, err));
  c->event = EVENT_STOP;
  c->threshold = 1e-6 * fabs(x0);
  c->value = stop;
  c->tol.h = 2.0;
  kit_source(c, source);
  return kit_rigid_only(c, err);
}

/* Moments about the contact: (I + m r^2) dw/dt = -rho m g while it rolls, I = 2/5 m r^2; about the
 * vertical: I dw_z/dt = -tau m g. The two do not touch each other on separate cones. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const billiard *p = param;
  const double r = p->radius, g = p->gravity, pos[3] = {0.0, 0.0, r};
  const double t_roll = 1.4 * r * p->speed / (p->rolling * g);
  const double t_spin = 0.4 * r * r * p->spin / (p->drilling * g);
  if (p->rolling > 1.4 * r * p->mu) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "billiard: rolling = %g m: more than 7/5 mu r = %g m makes the ball slide",
                     p->rolling, 1.4 * r * p->mu);
  }
  spec_body *b;
  kit_world(s, 3, g, 1.2 * fmax(t_roll, t_spin), fmin(t_roll, t_spin) / 100.0);
  BASE_TRY(kit_ball(s, "ball", p->mass, r, pos, &b, err));
  b->vel[0] = p->speed;
  b->omega[1] = p->speed / r;
  b->omega[2] = p->spin;
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->rolling.dflt = p->rolling;
  s->torsion.dflt = p->drilling;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION | EFFECT_ROLLING | EFFECT_TORSION;
  BASE_TRY(spec_add_observe(s, "ball.x", err));
  BASE_TRY(falls_evenly(s, "ball.vx", p->speed, t_roll, "rolls with a = 5/7 rho g/r", err));
  BASE_TRY(falls_evenly(s, "ball.omega.z", p->spin, t_spin, "I dw/dt = tau m g", err));
  BASE_TRY(kit_expect(s, "ball.x", s->duration, p->speed * t_roll / 2.0, p->speed,
                      "v0^2/(2 a), a = 5/7 rho g/r", err));
  kit_last(s)->tol.reg_v = 1.0;
  BASE_TRY(spec_add_off(s, EFFECT_ROLLING, "ball.vx", t_roll, p->speed, 1e-6, 0.0, err));
  BASE_TRY(spec_add_off(s, EFFECT_TORSION, "ball.omega.z", t_spin, p->spin, 1e-6, 0.0, err));
  return kit_energy(s, 1e-9 * p->mass * p->speed * p->speed, 0.0, err);
}

KIT_SCENE(billiard, "ball stopped by rolling and drilling friction", "coulomb1785",
          "A ball rolls without sliding and spins about the vertical. Rolling friction stops the "
          "one after 7/5 r v0/(rho g), drilling friction the other after 2/5 r^2 w0/(tau g); "
          "neither knows of the other, because each has its own bound. Five friction rows on one "
          "contact.",
          .situation = SITUATION_OTHER);
