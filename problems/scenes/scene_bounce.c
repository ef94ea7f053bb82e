/* Bouncing ball. */
#include "problems/scenes/kit.h"

typedef struct bounce {
  double height, restitution, radius, mass, gravity, duration;
  int dim;
} bounce;

static const base_field fields[] = {
    BASE_FIELD(bounce, height, BASE_REAL, "m", 1.0, 1e-3, 1e4, "initial gap to the floor"),
    BASE_FIELD(bounce, restitution, BASE_REAL, "1", 0.8, 0.0, 1.0, "Newton's coefficient"),
    BASE_FIELD(bounce, radius, BASE_REAL, "m", 0.1, 1e-4, 1e3, "radius"),
    BASE_FIELD(bounce, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e9, "mass"),
    BASE_FIELD(bounce, dim, BASE_INT, "1", 2, 2, 3, "dimension"),
    BASE_FIELD(bounce, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
    BASE_FIELD(bounce, duration, BASE_REAL, "s", 2.5, 1e-6, 1e5, "time simulated"),
};

/* Apex k (after the k-th impact) at radius + e^{2k} H, impacts at t0 (1 + 2e + .. + 2e^k),
 * t0 = sqrt(2H/g); all bounces over at t0 (1+e)/(1-e) (MATHEMATICS B5). */
static base_status predict(scene_spec *s, const bounce *p, const char *var, base_error *err) {
  const double t0 = sqrt(2.0 * p->height / p->gravity), v0 = sqrt(2.0 * p->gravity * p->height);
  const double e = p->restitution;
  spec_check *c;
  BASE_TRY(spec_add_check(s, CHECK_EVENT_TIME, NULL, &c, err));
  c->event = EVENT_FIRST_CONTACT;
  c->value = t0;
  c->tol.abs = 1e-9;
  c->tol.h = 2.5;
  kit_source(c, "sqrt(2H/g)");
  double impact = t0, rise = e;
  for (int k = 1; k <= 3 && e > 0.0 && impact + 2.0 * t0 * rise < p->duration; k++) {
    BASE_TRY(spec_add_check(s, CHECK_WINDOW_MAX, var, &c, err));
    c->t0 = impact + 0.5 * t0 * rise;
    c->t1 = impact + 1.5 * t0 * rise;
    c->value = p->radius + rise * rise * p->height;
    c->tol.abs = 1e-9;
    c->tol.h = 2.5 * v0;
    kit_source(c, "apex e^{2k} H");
    BASE_TRY(spec_check_only(c, "velocity", err));
    BASE_TRY(spec_check_only(c, "regularized", err));
    impact += 2.0 * t0 * rise;
    rise *= e;
  }
  const double zeno = (e < 1.0) ? t0 * (1.0 + e) / (1.0 - e) : HUGE_VAL;
  if (zeno + 0.3 < p->duration) {
    BASE_TRY(spec_add_state(s, var, p->duration, p->radius, 1e-6, 2.0 * v0, err));
    kit_source(&s->check[s->n_check - 1], "at rest after t0 (1+e)/(1-e)");
  }
  return kit_energy(s, 1e-9 * p->mass * v0 * v0, 0.0, err);
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const bounce *p = param;
  double pos[3] = {0.0};
  const char *var = (p->dim == 2) ? "ball.y" : "ball.z";
  kit_world(s, p->dim, p->gravity, p->duration, 0.002);
  pos[kit_up(s)] = p->height + p->radius;
  BASE_TRY(kit_ball(s, "ball", p->mass, p->radius, pos, NULL, err));
  BASE_TRY(kit_floor(s, err));
  s->restitution.dflt = p->restitution;
  s->effects = EFFECT_CONTACT | EFFECT_RESTITUTION;
  BASE_TRY(spec_add_observe(s, var, err));
  BASE_TRY(spec_add_observe(s, "ball.vel", err));
  if (p->restitution > 0.0) { /* a position-level scheme has no restitution */
    s->n_not_applicable = 1;
    BASE_TRY(spec_text(s->not_applicable[0], SPEC_NAME, "position", "not_applicable", err));
    BASE_TRY(spec_add_off(s, EFFECT_RESTITUTION, var, p->duration, p->radius, 1e-8,
                          1.05 * sqrt(2.0 * p->gravity * p->height), err));
  }
  return predict(s, p, var, err);
}

const scene scene_bounce = {
    .name = "bounce",
    .title = "bouncing ball",
    .cite = "brogliato2016",
    .about =
        "A ball falls from rest and bounces with Newton's law: apex heights e^{2k} H, impact times "
        "t0 (1 + 2e + ... + 2e^k) that accumulate at the Zeno time t0 (1+e)/(1-e), after which it "
        "rests. Event-driven methods must survive the accumulation, time stepping passes it "
        "without noticing (MATHEMATICS B5).",
    .situation = SITUATION_IMPACT,
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .param_size = sizeof(bounce),
    .build = build,
};
