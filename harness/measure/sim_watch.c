#include "harness/measure/sim_watch.h"

#include <string.h>

uint64_t sim_hash(uint64_t hash, const double *x, int n) {
  for (int i = 0; i < n; i++) {
    const double value = x[i] + 0.0;
    unsigned char byte[sizeof value];
    memcpy(byte, &value, sizeof value);
    for (size_t b = 0; b < sizeof byte; b++) {
      hash = (hash ^ byte[b]) * 0x100000001b3u;
    }
  }
  return hash;
}

static unsigned contact_effects(const contact_set *set, const formulation_answer *a, int i) {
  const double *row = a->impulse + set->row_start[i];
  const contact_rows rows = set->rows[i];
  unsigned seen = 0;
  if (!(row[0] > 0.0)) {
    return seen;
  }
  seen |= EFFECT_CONTACT;
  int k = 1;
  for (int end = k + rows.tangent; k < end; k++) {
    seen |= (row[k] != 0.0) ? EFFECT_FRICTION : 0u;
  }
  for (int end = k + rows.torsion; k < end; k++) {
    seen |= (row[k] != 0.0) ? EFFECT_TORSION : 0u;
  }
  for (int end = k + rows.rolling; k < end; k++) {
    seen |= (row[k] != 0.0) ? EFFECT_ROLLING : 0u;
  }
  if (set->restitution != NULL && set->restitution[i] > 0.0) {
    /* a bounce: the bias asks for e times the approach (rounding at rest asks for nothing) */
    const double bounce = set->restitution[i] * set->u_before[set->row_start[i]];
    const bool asked = a->bias == NULL || a->bias[i] <= 0.999 * bounce;
    seen |= (bounce < 0.0 && asked) ? EFFECT_RESTITUTION : 0u;
  }
  return seen;
}

/* Rotational dofs that moved: spatial bodies keep three rates after the translations. */
static unsigned rotation_effects(const scene_spec *spec, const contact_set *set,
                                 const formulation_answer *a) {
  for (int b = 0; b < set->n_body; b++) {
    for (int d = set->dof_start[b] + spec->dim; d < set->dof_start[b + 1]; d++) {
      if (a->v_next[d] != 0.0) {
        return EFFECT_ROTATION;
      }
    }
  }
  return 0;
}

unsigned sim_effects_seen(const scene_spec *spec, const contact_set *set,
                          const formulation_answer *a) {
  unsigned seen = 0;
  for (int i = 0; a->impulse != NULL && i < set->n_contact; i++) {
    seen |= contact_effects(set, a, i);
  }
  for (int i = set->row_start[set->n_contact]; a->impulse != NULL && i < set->n_row; i++) {
    seen |= (a->impulse[i] != 0.0) ? EFFECT_JOINTS : 0u;
  }
  if (a->v_next != NULL && spec->model == NULL) {
    seen |= rotation_effects(spec, set, a);
  }
  for (int d = 0; d < 3; d++) {
    seen |= (spec->gravity[d] != 0.0) ? EFFECT_GRAVITY : 0u;
  }
  return seen | (spec->effects & (EFFECT_SPATIAL | EFFECT_LOADS | EFFECT_MOTION | EFFECT_DAMPING));
}
