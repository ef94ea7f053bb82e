/* Newton's cradle. */
#include "problems/scenes/kit.h"

#include <stdio.h>

typedef struct cradle {
  int n;
  double gap, restitution, speed;
} cradle;

static const base_field fields[] = {
    BASE_FIELD(cradle, n, BASE_INT, "1", 3, 2, 1000, "balls"),
    BASE_FIELD(cradle, gap, BASE_REAL, "m", 0.0, 0.0, 1.0, "gap between the resting ones"),
    BASE_FIELD(cradle, restitution, BASE_REAL, "1", 1.0, 0.0, 1.0, "Newton's coefficient"),
    BASE_FIELD(cradle, speed, BASE_REAL, "m/s", 1.0, 1e-3, 1e3, "speed of the first"),
};

/* Touching: the others leave as one body, v' = v (1+e)/n, the first with v' - e v. Apart and e = 1:
 * binary impacts, the last takes all. */
static base_status predict(scene_spec *s, const cradle *p, base_error *err) {
  const double e = p->restitution, v = p->speed, together = v * (1.0 + e) / p->n;
  if (p->gap == 0.0 || e == 1.0) {
    for (int i = 0; i < p->n && i < 20; i++) {
      char var[2 * SPEC_NAME];
      (void)snprintf(var, sizeof var, "s%d.vx", i);
      const double chain = (i == 0) ? together - e * v : together;
      const double apart = (i == p->n - 1) ? v : 0.0;
      BASE_TRY(kit_expect(s, var, s->duration, p->gap == 0.0 ? chain : apart, 0.0,
                          p->gap == 0.0 ? "one simultaneous impact" : "n-1 binary impacts", err));
      BASE_TRY(spec_check_only(kit_last(s), "velocity", err));
      BASE_TRY(spec_check_only(kit_last(s), "regularized", err));
    }
  }
  spec_check *c;
  BASE_TRY(spec_add_check(s, CHECK_MOMENTUM_X, NULL, &c, err));
  kit_source(c, "no force from outside along x");
  c->t = s->duration;
  c->value = v;
  c->tol.abs = 1e-9 * v;
  return kit_energy(s, 1e-9 * v * v, 0.0, err);
}

static base_status build(const void *param, scene_spec *s, base_error *err) {
  const cradle *p = param;
  const double r = 0.1, start = 0.05;
  const double travel = (start + p->gap * p->n) / p->speed;
  kit_world(s, 2, 0.0, 2.0 * travel + 0.05 / p->speed,
            fmin(start, p->gap > 0.0 ? p->gap : start) / (3.0 * p->speed));
  for (int i = 0; i < p->n; i++) {
    char name[SPEC_NAME];
    const double pos[2] = {i * (2.0 * r + p->gap) + (i > 0 ? start - p->gap : 0.0), 0.0};
    spec_body *b;
    kit_name(name, "s", i);
    BASE_TRY(kit_ball(s, name, 1.0, r, pos, &b, err));
    b->lock = SPEC_RZ;
    b->vel[0] = (i == 0) ? p->speed : 0.0;
  }
  s->restitution.dflt = p->restitution;
  s->effects = EFFECT_CONTACT | EFFECT_RESTITUTION;
  s->n_not_applicable = (p->restitution > 0.0) ? 1 : 0;
  BASE_TRY(spec_text(s->not_applicable[0], SPEC_NAME, "position", "not_applicable", err));
  BASE_TRY(spec_add_observe(s, "s0.vx", err));
  return predict(s, p, err);
}

KIT_SCENE(cradle, "Newton's cradle", "brogliato2016",
          "A ball hits a row of equal ones. Touching, a simultaneous Newton impact sends the row "
          "off as one body: momentum and energy are right and the picture is wrong, a documented "
          "limit of the impact law, not of a solver. With gaps larger than a step's travel the "
          "impacts are binary and only the last ball leaves (MATHEMATICS B7).",
          .situation = SITUATION_IMPACT);
