/* Oblique impact of a spinning ball. */
#include "problems/scenes/kit.h"

typedef struct impact {
  double speed_n, speed_t, spin, restitution, mu, radius, mass;
  int dim;
} impact;

static const base_field fields[] = {
    BASE_FIELD(impact, speed_n, BASE_REAL, "m/s", 2.0, 1e-3, 1e4, "approach speed"),
    BASE_FIELD(impact, speed_t, BASE_REAL, "m/s", 1.0, -1e4, 1e4, "speed along the floor"),
    BASE_FIELD(impact, spin, BASE_REAL, "rad/s", 0.0, -1e5, 1e5, "backspin"),
    BASE_FIELD(impact, restitution, BASE_REAL, "1", 0.7, 0.0, 1.0, "Newton's coefficient"),
    BASE_FIELD(impact, mu, BASE_REAL, "1", 0.1, 0.0, 100.0, "friction coefficient"),
    BASE_FIELD(impact, radius, BASE_REAL, "m", 0.1, 1e-4, 1e3, "radius"),
    BASE_FIELD(impact, mass, BASE_REAL, "kg", 0.6, 1e-6, 1e9, "mass"),
    BASE_FIELD(impact, dim, BASE_INT, "1", 2, 2, 3, "dimension"),
};

static base_status impulsive(scene_spec *s, base_error *err) {
  BASE_TRY(spec_check_only(kit_last(s), "velocity", err));
  return spec_check_only(kit_last(s), "coulomb", err);
}

/* Pn = m (1+e) v_n; Pt = -clip(u m b/(1+b), mu Pn) with u = v_t + r w, I = b m r^2 (MATHEMATICS B6). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const impact *p = param;
  const double b = (p->dim == 2) ? 0.5 : 0.4, m = p->mass, r = p->radius;
  const double u = p->speed_t + r * p->spin, Pn = m * (1.0 + p->restitution) * p->speed_n;
  const double Pt = -copysign(fmin(fabs(u) * m * b / (1.0 + b), p->mu * Pn), u);
  const double T = 0.1 / p->speed_n, spin = p->spin + Pt / (b * m * r);
  double pos[3] = {0.0};
  const bool flat = p->dim == 2;
  spec_body *ball;
  kit_world(s, p->dim, 0.0, T, T / 20.0);
  pos[kit_up(s)] = r + 0.05;
  BASE_TRY(kit_ball(s, "ball", m, r, pos, &ball, err));
  ball->vel[0] = p->speed_t;
  ball->vel[kit_up(s)] = -p->speed_n;
  ball->omega[flat ? 2 : 1] = flat ? p->spin : -p->spin;
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->restitution.dflt = p->restitution;
  s->effects = EFFECT_CONTACT | EFFECT_ROTATION | EFFECT_FRICTION | EFFECT_RESTITUTION;
  s->n_not_applicable = (p->restitution > 0.0) ? 1 : 0;
  BASE_TRY(spec_text(s->not_applicable[0], SPEC_NAME, "position", "not_applicable", err));
  BASE_TRY(spec_add_observe(s, "ball.vel", err));
  BASE_TRY(kit_expect(s, "ball.vx", T, p->speed_t + Pt / m, 0.0, "v_t + Pt/m", err));
  BASE_TRY(impulsive(s, err));
  BASE_TRY(kit_expect(s, flat ? "ball.vy" : "ball.vz", T, p->restitution * p->speed_n, 0.0, "e v_n",
                      err));
  BASE_TRY(impulsive(s, err));
  BASE_TRY(kit_expect(s, flat ? "ball.omega" : "ball.omega.y", T, flat ? spin : -spin, 0.0,
                      "w + Pt/(b m r)", err));
  BASE_TRY(impulsive(s, err));
  return kit_energy(s, 1e-9 * m * (p->speed_n * p->speed_n + u * u), 0.0, err);
}

KIT_SCENE(impact, "oblique impact of a spinning ball", "walton1993",
          "One impact with friction and spin: the tangential impulse stops the slip or is limited "
          "by mu times the normal impulse. A model that takes the normal force from the last step "
          "misses friction in impacts altogether (MATHEMATICS B6).",
          .situation = SITUATION_IMPACT);
