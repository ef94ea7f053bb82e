/* Spring-mass with Coulomb friction. */
#include "problems/scenes/kit.h"

typedef struct oscillator {
  double start, stiffness, mass, mu, gravity;
} oscillator;

static const base_field fields[] = {
    BASE_FIELD(oscillator, start, BASE_REAL, "m", 12.0, 1e-6, 1e6, "initial deflection"),
    BASE_FIELD(oscillator, stiffness, BASE_REAL, "N/m", 1.0, 1e-6, 1e9, "stiffness K"),
    BASE_FIELD(oscillator, mass, BASE_REAL, "kg", 1.0, 1e-6, 1e9, "mass"),
    BASE_FIELD(oscillator, mu, BASE_REAL, "1", 0.1, 1e-6, 10.0, "friction coefficient"),
    BASE_FIELD(oscillator, gravity, BASE_REAL, "m/s^2", 10.0, 1e-6, 1e3, "gravity"),
};

/* The deflection falls by 2F/K every half period; rest once |x| <= F/K (MATHEMATICS B17). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const oscillator *p = param;
  const double F = p->mu * p->mass * p->gravity, K = p->stiffness, w = sqrt(K / p->mass);
  const double half[2] = {0.1, 0.05}, pos[2] = {p->start, 0.05}, loss = 2.0 * F / K;
  const int halves = (int)fmin(ceil((p->start - F / K) / loss - 1e-9), 8.0);
  spec_load *l;
  spec_body *b;
  if (p->start <= F / K) {
    return BASE_FAIL(err, BASE_EINVAL, "start = %g: need more than F/K = %g to move at all",
                     p->start, F / K);
  }
  kit_world(s, 2, p->gravity, halves * KIT_PI / w + 0.5 / w, 0.005 / w);
  BASE_TRY(kit_box(s, "block", p->mass, half, pos, &b, err));
  b->lock = SPEC_RZ;
  BASE_TRY(kit_floor(s, err));
  BASE_TRY(spec_add_load(s, &l, err));
  l->kind = SPEC_SPRING;
  l->body = 0;
  l->k = K;
  l->dir[0] = 1.0;
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION;
  BASE_TRY(spec_add_observe(s, "block.x", err));
  for (int i = 1; i <= halves; i++) {
    const double x = (i % 2 == 0 ? 1.0 : -1.0) * (p->start - i * loss);
    BASE_TRY(kit_expect(s, "block.x", i * KIT_PI / w, x, 0.4 * w * p->start * i,
                        "|x| falls by 2F/K a half period", err));
    kit_last(s)->tol.reg_h = w * p->start * i;
    kit_last(s)->tol.reg_v = 2.0 * i / w;
  }
  return kit_energy(s, 1e-9 * K * p->start * p->start, w * K * p->start * p->start, err);
}

KIT_SCENE(oscillator, "spring and dry friction", "denhartog1930",
          "A mass on a spring slides on a rough floor: the amplitude falls by the constant 2F/K "
          "every half period, not by a factor, and the mass stops for good inside |x| <= F/K "
          "(MATHEMATICS B17).",
          .situation = SITUATION_SLIDING);
