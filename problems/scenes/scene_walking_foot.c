/* Foot pressed to the ground by a shifting load. */
#include "problems/scenes/kit.h"

typedef struct walking_foot {
  int multiplicity;
  double load, push, frequency, mu, duration;
} walking_foot;

static const base_field fields[] = {
    BASE_FIELD(walking_foot, multiplicity, BASE_INT, "1", 10, 1, SPEC_COPIES,
               "times each of the four contact points is listed"),
    BASE_FIELD(walking_foot, load, BASE_REAL, "N", 700.0, 0.0, 1e6, "weight on the foot"),
    BASE_FIELD(walking_foot, push, BASE_REAL, "1", 0.6, 0.0, 5.0,
               "amplitude of the horizontal force over what friction holds"),
    BASE_FIELD(walking_foot, frequency, BASE_REAL, "Hz", 2.0, 1e-3, 1e3, "frequency of the push"),
    BASE_FIELD(walking_foot, mu, BASE_REAL, "1", 0.6, 1e-3, 10.0, "friction coefficient"),
    BASE_FIELD(walking_foot, duration, BASE_REAL, "s", 0.5, 1e-3, 1e2, "time simulated"),
};

/* Holds iff the push stays below mu (m g + load). */
static base_status build(const void *param, scene_spec *s, base_error *err) {
  const walking_foot *p = param;
  const double half[3] = {0.14, 0.05, 0.02}, pos[3] = {0.0, 0.0, 0.02}, g = 9.81, m = 1.0;
  const double N = m * g + p->load;
  spec_load *l;
  kit_world(s, 3, g, p->duration, 0.005);
  BASE_TRY(kit_box(s, "foot", m, half, pos, NULL, err));
  BASE_TRY(kit_floor(s, err));
  BASE_TRY(spec_add_load(s, &l, err));
  l->kind = SPEC_FORCE;
  l->force[2] = -p->load;
  BASE_TRY(spec_add_load(s, &l, err));
  l->kind = SPEC_FORCE_SINE;
  l->dir[0] = 1.0;
  l->rate = p->push * p->mu * N;
  l->omega = 2.0 * KIT_PI * p->frequency;
  s->friction.dflt = p->mu;
  s->contact_multiplicity = p->multiplicity;
  s->effects = EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  BASE_TRY(spec_add_observe(s, "foot.x", err));
  BASE_TRY(
      kit_force(s, "foot", "floor", false, p->duration / 2.0, p->duration, N, 1e-6 * N, NULL, err));
  kit_source(kit_last(s), "m g + load, however split");
  if (p->push < 0.99) {
    return kit_rests(s, "foot.x", 1e-7, "push below mu N", err);
  }
  return (p->push > 1.2) ? kit_moves(s, "foot.vx", 0.0, "slips", err) : BASE_OK;
}

KIT_SCENE(walking_foot, "foot on many redundant contacts", "peiret2019",
          "A stiff sole under the weight of a walker, pushed back and forth below the friction "
          "limit. Every contact point is listed many times over, as collision detectors do: totals "
          "are unique, single forces are not, and the answer must not depend on the copies.",
          .situation = SITUATION_OTHER, .redundant = true);
