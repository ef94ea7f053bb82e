/* world_steady.c - what a step makes of bodies that are not where they should be: does a deviation keep its velocity, do contacts act
 * alike with it? */
#include "problems/vec.h"
#include "problems/world/world_residual.h"

static const double turning =
    1e-8; /* of the speed of a body, and of what gravity gives it in a step: rounding */

/* Do the loads not depend on places? */
static bool loads_stay(const world *w) {
  for (int k = 0; k < w->spec.n_load; k++) {
    const spec_load_kind kind = w->spec.load[k].kind;
    if (kind != SPEC_FORCE && kind != SPEC_FORCE_RAMP && kind != SPEC_FORCE_SINE) {
      return false;
    }
  }
  return true;
}

static bool on_planes(const world *w, const double *impulse) {
  const set_store *s = &w->store;
  for (int i = 0; i < w->set.n_contact; i++) {
    if (impulse[s->row_start[i]] > 0.0 && s->item[s->key[i].item].b < w->n_body) {
      return false;
    }
  }
  return true;
}

/* Does body i turn at the start of the step, or at its end? */
static bool turns(const world *w, int i, const double *v_next) {
  const body *b = &w->body[i];
  double speed[3], spin[3];
  world_side_motion(w, i, v_next, b->at.x, speed, spin);
  const double most = fmax(v3_norm(spin), v3_norm(b->v + 3));
  return b->bound * most > turning * (v3_norm(speed) + w->h * v3_norm(w->spec.gravity));
}

bool world_steady(const world *w, unsigned effects, const double *v_next, const double *impulse) {
  if (w->n_joint > 0 || !loads_stay(w) || !on_planes(w, impulse)) {
    return false;
  }
  for (int i = 0; i < w->n_body; i++) {
    if (!world_is_ball(w, i) && turns(w, i, v_next)) {
      return false;
    }
  }
  return world_stands_firmly(w, effects, impulse);
}

/* ---- impacts ---------------------------------------------------------------------------------- */

/* Of contact i, at the dofs' velocities v: what its sides part with along the normal [m/s]. */
static double parting(const world *w, int i, const double *v) {
  const contact_item *c = &w->store.item[w->store.key[i].item];
  double ua[3], ub[3], spin[3];
  world_side_motion(w, c->a, v, c->x, ua, spin);
  world_side_motion(w, c->b, v, c->x, ub, spin);
  v3_sub(ua, ub, ua);
  return v3_dot(ua, w->store.frame + 9 * (ptrdiff_t)i);
}

/* Do the contacts that carry body `own` push along the normal of contact i, or across it? */
static bool upright(const world *w, int i, int own, const double *impulse) {
  const set_store *s = &w->store;
  for (int k = 0; k < w->set.n_contact; k++) {
    if (impulse[s->row_start[k]] > 0.0 && s->item[s->key[k].item].a == own) {
      const double d = fabs(v3_dot(s->frame + 9 * (ptrdiff_t)i, s->frame + 9 * (ptrdiff_t)k));
      if (d > 1e-9 && d < 1.0 - 1e-9) {
        return false;
      }
    }
  }
  return true;
}

/* Contact i, which an approach at `before` meets: does it bounce, or not, by more than `unsure` [m/s]? An approach of some steps of load
 * is rest; how many is the formulation's to say. */
static bool bounces_alike(const world *w, int i, double before, double unsure,
                          const double *impulse) {
  static const double fewest = 1.0, most = 4.0;
  if (w->set.restitution == NULL || w->set.restitution[i] == 0.0) {
    return true;
  }
  const double gain = fmax(0.0, before - parting(w, i, w->store.v_free));
  const bool decided = -before < fewest * gain - unsure || -before > most * gain + unsure;
  return decided && upright(w, i, w->store.item[w->store.key[i].item].a, impulse);
}

bool world_contacts_alike(const world *w, const double *v_next, const double *impulse, double place,
                          double speed) {
  static const unsigned laws = EFFECT_FRICTION | EFFECT_ROLLING | EFFECT_TORSION;
  const double tol = w->set.tol;
  for (int i = 0; i < w->set.n_contact; i++) {
    const int row = w->store.row_start[i];
    const double before = w->store.u_before[row], after = parting(w, i, v_next);
    const double unsure = 2.0 * speed + turning * (fabs(before) + w->h * v3_norm(w->spec.gravity));
    const bool carries = impulse[row] > 0.0;
    const bool rests = fabs(before) <= unsure && fabs(after) <= unsure;
    const bool passes = !carries && (after > unsure || w->store.gap[i] > place + 100.0 * tol);
    const double gap = w->store.gap[i], gap_before = gap - w->h * before; /* of the last step */
    const bool hits = carries && before < -unsure && gap <= tol - place &&
                      gap_before > tol + place && bounces_alike(w, i, before, unsure, impulse);
    if (!rests && !passes && !hits) {
      return false;
    }
  }
  return (w->effects & laws) == 0;
}
