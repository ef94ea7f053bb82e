/* A ball that slides, then rolls. */
#include "problems/scenes/kit.h"

typedef struct roll {
  double speed, spin, mu, radius, mass, gravity, duration;
  int dim;
} roll;

static const base_field fields[] = {
    BASE_FIELD(roll, speed, BASE_REAL, "m/s", 2.0, -1e4, 1e4, "initial speed of the centre"),
    BASE_FIELD(roll, spin, BASE_REAL, "rad/s", 0.0, -1e5, 1e5,
               "initial spin, positive backwards (against rolling along +x)"),
    BASE_FIELD(roll, mu, BASE_REAL, "1", 0.2, 1e-6, 100.0, "friction coefficient"),
    BASE_FIELD(roll, radius, BASE_REAL, "m", 0.1, 1e-4, 1e3, "radius"),
    BASE_FIELD(roll, mass, BASE_REAL, "kg", 0.5, 1e-6, 1e9, "mass"),
    BASE_FIELD(roll, dim, BASE_INT, "1", 3, 2, 3, "dimension: sphere in 3, disc in 2"),
    BASE_FIELD(roll, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(roll, duration, BASE_REAL, "s", 1.0, 1e-6, 1e5, "time simulated"),
};

/* Slip u0 = v0 + r w ends at t = |u0| b/(mu g (1+b)) with v_f = v0 - u0 b/(1+b), I = b m r^2, for
 * every friction law (angular momentum about the contact; MATHEMATICS B4). */
static base_status predict(scene_spec *s, const roll *p, base_error *err) {
  const double b = (p->dim == 3) ? 0.4 : 0.5, g = p->gravity, T = p->duration;
  const double u0 = p->speed + p->radius * p->spin, share = b / (1.0 + b);
  const double v_f = p->speed - u0 * share, t_f = fabs(u0) * share / (p->mu * g);
  if (t_f >= T) {
    return BASE_OK;
  }
  const double x_f = 0.5 * (p->speed + v_f) * t_f, x = x_f + v_f * (T - t_f);
  BASE_TRY(spec_add_state(s, "ball.vx", T, v_f, 1e-8, 0.0, err));
  spec_check *c = &s->check[s->n_check - 1];
  c->tol.reg_v = 0.01;
  kit_source(c, "v0 - u0 b/(1+b), any law of friction");
  BASE_TRY(spec_add_state(s, (p->dim == 3) ? "ball.omega.y" : "ball.omega", T,
                          (p->dim == 3 ? v_f : -v_f) / p->radius, 1e-7, 0.0, err));
  c = &s->check[s->n_check - 1];
  c->tol.reg_v = 0.1 / p->radius;
  kit_source(c, "rolling: v_f/r");
  BASE_TRY(spec_add_state(s, "ball.x", T, x, 1e-9, 0.8 * fabs(u0) * share, err));
  c = &s->check[s->n_check - 1];
  c->tol.reg_h = 2.0 * fabs(u0) * share;
  c->tol.reg_v = 0.1 * T;
  kit_source(c, "slide, then roll");
  BASE_TRY(kit_energy(s, 1e-9 * p->mass * (p->speed * p->speed + u0 * u0), 0.0, err));
  return spec_add_off(s, EFFECT_FRICTION, "ball.x", T, p->speed * T, 1e-8, 0.0, err);
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const roll *p = param;
  double pos[3] = {0.0};
  kit_world(s, p->dim, p->gravity, p->duration, 0.01);
  pos[kit_up(s)] = p->radius;
  spec_body *b;
  BASE_TRY(kit_ball(s, "ball", p->mass, p->radius, pos, &b, err));
  b->vel[0] = p->speed;
  if (p->dim == 3) {
    b->omega[1] = -p->spin;
  } else {
    b->omega[2] = p->spin;
  }
  BASE_TRY(kit_floor(s, err));
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "ball.x", err));
  BASE_TRY(spec_add_observe(s, "ball.vx", err));
  BASE_TRY(spec_add_observe(s, (p->dim == 3) ? "ball.omega.y" : "ball.omega", err));
  return predict(s, p, err);
}

const scene scene_roll = {
    .name = "roll",
    .title = "ball that slides, then rolls",
    .cite = "coriolis1835",
    .about =
        "A ball is set sliding on a floor, with backspin if wanted. Friction turns sliding into "
        "rolling; the final speed v0 - u0 b/(1+b), with u0 = v0 + r omega and I = b m r^2, does "
        "not depend on mu or on the law of friction, because the angular momentum about the "
        "contact line is kept. Enough backspin brings the ball back (MATHEMATICS B4).",
    .situation = SITUATION_OTHER,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .param_size = sizeof(roll),
    .build = build,
};
