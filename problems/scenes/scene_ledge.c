/* Particle leaving a ledge. */
#include "problems/scenes/kit.h"

typedef struct ledge {
  double speed, run, gravity;
} ledge;

static const base_field fields[] = {
    BASE_FIELD(ledge, speed, BASE_REAL, "m/s", 2.0, 1e-2, 1e2, "speed along the ledge"),
    BASE_FIELD(ledge, run, BASE_REAL, "m", 0.2, 1e-3, 1e2, "distance to the edge"),
    BASE_FIELD(ledge, gravity, BASE_REAL, "m/s^2", 9.81, 1e-6, 1e3, "gravity"),
};

/* Straight on to the edge, then a parabola: a contact must end where the surface does. */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const ledge *p = param;
  const double v = p->speed, g = p->gravity, leave = p->run / v, T = 2.0 * leave;
  const double half[2] = {2.0 * p->run, 0.25 * p->run}, pos[2] = {-2.0 * p->run, -0.25 * p->run};
  spec_body *b;
  kit_world(s, 2, g, T, leave / 50.0);
  BASE_TRY(kit_box(s, "shelf", 1.0, half, pos, &b, err));
  b->kinematic = true;
  BASE_TRY(spec_add_body(s, "dot", &b, err));
  b->mass = 1.0;
  b->lock = SPEC_RZ;
  b->pos[0] = -p->run;
  b->vel[0] = v;
  s->effects = EFFECT_CONTACT;
  BASE_TRY(spec_add_observe(s, "dot.pos", err));
  BASE_TRY(kit_expect(s, "dot.x", T, v * T - p->run, 0.0, "no force along the ledge", err));
  kit_last(s)->tol.abs = 1e-6 * p->run;
  return kit_expect(s, "dot.y", T, -g * (T - leave) * (T - leave) / 2.0, 3.0 * g * leave,
                    "free fall behind the edge", err);
}

KIT_SCENE(ledge, "particle leaving a ledge", "stewart1996",
          "A particle slides off a shelf. Behind the edge free space is not convex, and a scheme "
          "that keeps the half-space of the shelf's top would carry it on through the air or push "
          "it back sideways (MATHEMATICS B20).",
          .situation = SITUATION_OTHER);
