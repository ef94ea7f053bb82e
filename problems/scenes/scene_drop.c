/* Drop to rest without restitution. */
#include "problems/scenes/kit.h"

typedef struct drop {
  double height, radius, mu, gravity, duration;
  int dim;
} drop;

static const base_field fields[] = {
    BASE_FIELD(drop, height, BASE_REAL, "m", 0.1, 1e-6, 1e4, "initial gap to the floor"),
    BASE_FIELD(drop, radius, BASE_REAL, "m", 0.1, 1e-4, 1e3, "radius"),
    BASE_FIELD(drop, mu, BASE_REAL, "1", 0.5, 0.0, 100.0, "friction coefficient (plays no part)"),
    BASE_FIELD(drop, dim, BASE_INT, "1", 2, 2, 3, "dimension"),
    BASE_FIELD(drop, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(drop, duration, BASE_REAL, "s", 0.5, 1e-6, 1e4, "time simulated"),
};

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const drop *p = param;
  const double fall = sqrt(2.0 * p->height / p->gravity), v = p->gravity * fall;
  double pos[3] = {0.0};
  const char *var = (p->dim == 2) ? "ball.y" : "ball.z";
  kit_world(s, p->dim, p->gravity, p->duration, 0.01);
  pos[kit_up(s)] = p->radius + p->height;
  BASE_TRY(kit_ball(s, "ball", 1.0, p->radius, pos, NULL, err));
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT;
  BASE_TRY(spec_add_observe(s, var, err));
  if (fall + 0.1 > p->duration) {
    return kit_finite(s, err);
  }
  spec_check *c;
  BASE_TRY(spec_add_check(s, CHECK_EVENT_TIME, NULL, &c, err));
  c->value = fall;
  c->tol.h = 2.5;
  c->tol.abs = 1e-9;
  kit_source(c, "sqrt(2H/g)");
  /* velocity level: stops anywhere within one step of travel; position level: on the surface */
  BASE_TRY(kit_expect(s, var, p->duration, p->radius, 1.05 * v, "at rest", err));
  BASE_TRY(kit_expect(s, var, p->duration, p->radius, 0.0, "on the surface", err));
  kit_last(s)->tol.abs = 1e-7;
  BASE_TRY(spec_check_only(kit_last(s), "position", err));
  BASE_TRY(kit_expect(s, "ball.vel", p->duration, 0.0, 0.0, "at rest", err));
  kit_last(s)->tol.abs = 1e-7;
  BASE_TRY(kit_penetration(s, 1e-7, 1.05 * v, err));
  return kit_energy(s, 1e-9 * (1.0 + v * v), 0.0, err);
}

KIT_SCENE(drop, "drop to rest", "stewart1996",
          "A ball falls and stays down (e = 0). A velocity-level scheme stops anywhere within one "
          "step of travel of the surface, a position-level one on it: the cheapest picture of the "
          "difference between the two (MATHEMATICS B19).",
          .situation = SITUATION_IMPACT);
