/* Which effects occur in a scene's data, and what it declares of them. */
#include "problems/spec/spec_check.h"
#include "problems/vec.h"

static bool occurs(const spec_coefficient *c) {
  bool any = c->dflt > 0.0;
  for (int i = 0; i < c->n_pair; i++) {
    any = any || c->pair[i].value > 0.0;
  }
  return any;
}

static bool is_round(const scene_spec *s, const spec_body *b) {
  return s->dim == 2 || (b->inertia[0] == b->inertia[1] && b->inertia[1] == b->inertia[2]);
}

static unsigned if_true(bool occurring, unsigned e) {
  return occurring ? e : 0u;
}

static unsigned body_effects(const scene_spec *s, const spec_body *b) {
  if (b->kinematic) {
    return EFFECT_MOTION;
  }
  const unsigned turning = EFFECT_ROTATION | if_true(!is_round(s, b), EFFECT_GYROSCOPIC);
  return if_true(b->prescribed != 0, EFFECT_MOTION) | if_true(spec_can_rotate(s, b), turning);
}

static unsigned present_effects(const scene_spec *s) {
  const bool contact = s->n_body > 1 || (s->n_static > 0 && s->n_body > 0);
  unsigned e = if_true(s->dim == 3, EFFECT_SPATIAL) |
               if_true(v3_norm(s->gravity) > 0.0, EFFECT_GRAVITY) |
               if_true(s->n_joint > 0, EFFECT_JOINTS) | if_true(contact, EFFECT_CONTACT) |
               if_true(contact && occurs(&s->friction), EFFECT_FRICTION) |
               if_true(contact && occurs(&s->restitution), EFFECT_RESTITUTION) |
               if_true(contact && occurs(&s->rolling), EFFECT_ROLLING) |
               if_true(contact && occurs(&s->torsion), EFFECT_TORSION);
  for (int i = 0; i < s->n_body; i++) {
    e |= body_effects(s, &s->body[i]);
  }
  for (int i = 0; i < s->n_static; i++) {
    e |= if_true(v3_norm(s->fixed[i].surface_velocity) > 0.0, EFFECT_MOTION);
  }
  for (int i = 0; i < s->n_load; i++) {
    e |= EFFECT_LOADS | if_true(s->load[i].c > 0.0, EFFECT_DAMPING);
  }
  return e;
}

base_status spec_settle_effects(scene_spec *s, base_error *err) {
  s->present = present_effects(s);
  if (s->model != NULL) {
    return BASE_OK; /* its scene declares them */
  }
  /* A coefficient of zero is a fair value of a declared effect; it just costs nothing. */
  const unsigned may_vanish =
      EFFECT_FRICTION | EFFECT_RESTITUTION | EFFECT_ROLLING | EFFECT_TORSION;
  const unsigned missing = s->effects & ~s->present & ~may_vanish;
  if (missing != 0) {
    char text[160];
    effects_print(missing, text, sizeof text);
    return BASE_FAIL(err, BASE_EINVAL, "scene '%s': declares %s, but nothing in it has that effect",
                     s->id, text);
  }
  /* A coefficient of restitution above zero is itself a declaration: a file that lists only
   * "contact" and gives one expects the bounce. */
  const unsigned always = EFFECT_GRAVITY | EFFECT_JOINTS | EFFECT_LOADS | EFFECT_DAMPING |
                          EFFECT_MOTION | EFFECT_SPATIAL | EFFECT_RESTITUTION;
  const bool declares = s->declares || s->effects != 0;
  s->effects = declares ? s->effects | (s->present & always) : s->present;
  if ((s->effects & EFFECT_ROTATION) != 0) {
    s->effects |= s->present & EFFECT_GYROSCOPIC;
  }
  s->effects &= s->present;
  return BASE_OK;
}
