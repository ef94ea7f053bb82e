/* Static capacity of a faceted cone. */
#include "problems/scenes/kit.h"

typedef struct capacity {
  double angle_deg, rate, mu, mass, gravity;
  int facets;
} capacity;

static const base_field fields[] = {
    BASE_FIELD(capacity, angle_deg, BASE_REAL, "deg", 45.0, 0.0, 90.0, "direction of the push"),
    BASE_FIELD(capacity, facets, BASE_INT, "1", 4, 4, 64, "facets of the prediction"),
    BASE_FIELD(capacity, rate, BASE_REAL, "N/s", 4.0, 1e-6, 1e6, "growth of the push"),
    BASE_FIELD(capacity, mu, BASE_REAL, "1", 0.5, 1e-3, 10.0, "friction coefficient"),
    BASE_FIELD(capacity, mass, BASE_REAL, "kg", 2.0, 1e-6, 1e6, "mass"),
    BASE_FIELD(capacity, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

/* The inscribed nd-gon holds mu N cos(pi/nd)/cos((phi mod 2pi/nd) - pi/nd) (MATHEMATICS S2). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const capacity *p = param;
  const double phi = kit_radians(p->angle_deg), nd = p->facets, F = p->mu * p->mass * p->gravity;
  const double share = cos(KIT_PI / nd) / cos(fmod(phi, 2.0 * KIT_PI / nd) - KIT_PI / nd);
  const double circle = F / p->rate, facet = share * circle;
  spec_body *b;
  spec_load *l;
  kit_world(s, 3, p->gravity, 1.2 * circle, circle / 250.0);
  BASE_TRY(spec_add_body(s, "puck", &b, err));
  b->mass = p->mass;
  b->lock = SPEC_ROT;
  BASE_TRY(kit_floor(s, err));
  BASE_TRY(spec_add_load(s, &l, err));
  l->kind = SPEC_FORCE_RAMP;
  l->rate = p->rate;
  l->dir[0] = cos(phi);
  l->dir[1] = sin(phi);
  s->friction.dflt = p->mu;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION;
  s->facets = p->facets;
  BASE_TRY(spec_add_observe(s, "puck.pos", err));
  BASE_TRY(
      kit_rests(s, "puck.pos", 1e-8, "holds mu N cos(pi/nd)/cos(phi mod 2pi/nd - pi/nd)", err));
  kit_last(s)->t1 = 0.99 * facet;
  kit_last(s)->nd = p->facets;
  spec_check *c;
  BASE_TRY(kit_drift(s, "puck.pos", 1e-7, 0.0, &c, err));
  c->t1 = 0.99 * circle;
  kit_source(c, "a circular cone holds mu N");
  BASE_TRY(spec_check_only(c, "coulomb", err));
  return kit_moves(s, "puck.pos", 1e-4 * p->rate / p->mass, "slips in the end", err);
}

KIT_SCENE(capacity, "static capacity of friction cones", "anitescu1997",
          "A growing push at an angle to the facets: the inscribed polyhedral cone lets go at a "
          "share cos(pi/nd) of the true limit in the worst direction and then slides along the "
          "bisector, not along the push. A circular cone holds the same in every direction "
          "(MATHEMATICS S2).",
          .situation = SITUATION_OTHER);
