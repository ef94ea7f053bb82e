/* world_omitted.c - what effects that are left out would do in a step, from the step without them.
 *
 * The step without an effect is one with it where the force that the effect would add is zero. So each effect has a
 * residual: along axes that are locked the impulse that contacts, joints and loads leave over; at contacts without
 * friction (rolling, torsion) what Coulomb's law could exert at the velocity there. */
#include "problems/vec.h"
#include "problems/world/world_residual.h"

/* ---- laws that are left out at contacts ------------------------------------------------------- */

static double inverse_mass(const world *w, int side) {
  return (side < w->n_body && w->body[side].n_dof > 0) ? 1.0 / w->body[side].mass : 0.0;
}

static double inverse_inertia(const world *w, int side) {
  const bool turns = side < w->n_body && w->body[side].spins && w->body[side].n_dof > 0;
  return turns ? 1.0 / world_least_inertia(w, side) : 0.0;
}

static void add_to_sides(const world *w, const contact_item *c, size_t field, double value) {
  const int side[2] = {c->a, c->b};
  for (int k = 0; k < 2; k++) {
    if (side[k] < w->n_body) {
      *(double *)(void *)((char *)world_residual(w, side[k]) + field) += value;
    }
  }
}

/* No force exceeds mu p, nor what stops the sliding: u over the mobility of the two sides. */
static double most_of(double coefficient, double press, double speed, double mobility) {
  const double most = coefficient * press;
  return (mobility > 0.0) ? fmin(most, speed / mobility) : most;
}

static void add_laws(const world *w, unsigned omitted, int i, const double *v_next, double press) {
  const set_store *s = &w->store;
  const contact_item *c = &s->item[s->key[i].item];
  const double *n = s->frame + 9 * (ptrdiff_t)i;
  double ua[3], ub[3], wa[3], wb[3];
  world_side_motion(w, c->a, v_next, c->x, ua, wa);
  world_side_motion(w, c->b, v_next, c->x, ub, wb);
  v3_sub(ua, ub, ua);
  v3_sub(wa, wb, wa);
  v3_add_scaled(ua, -v3_dot(ua, n), n, ua);
  if ((omitted & EFFECT_FRICTION) != 0) {
    const double mu = fmax(pair_value(&w->mu, c->a, c->b), pair_value(&w->mu_kinetic, c->a, c->b));
    const double mobility = inverse_mass(w, c->a) + inverse_mass(w, c->b);
    add_to_sides(w, c, offsetof(residual, rub), most_of(mu, press, v3_norm(ua), mobility));
  }
  const double turning = inverse_inertia(w, c->a) + inverse_inertia(w, c->b);
  const double about = v3_dot(wa, n);
  v3_add_scaled(wa, -about, n, wa);
  double resist = 0.0;
  if ((omitted & EFFECT_TORSION) != 0) {
    resist += most_of(pair_value(&w->torsion, c->a, c->b), press, fabs(about), turning);
  }
  if ((omitted & EFFECT_ROLLING) != 0) {
    resist += most_of(pair_value(&w->rolling, c->a, c->b), press, v3_norm(wa), turning);
  }
  add_to_sides(w, c, offsetof(residual, resist), resist);
  const double e = pair_value(&w->restitution, c->a, c->b);
  if ((omitted & EFFECT_RESTITUTION) != 0) {
    add_to_sides(w, c, offsetof(residual, bounce), -e * fmin(s->u_before[s->row_start[i]], 0.0));
  }
}

/* ---- the whole -------------------------------------------------------------------------------- */

static void raise(double change[EFFECT_COUNT], unsigned effects, double speed) {
  for (int e = 0; e < EFFECT_COUNT; e++) {
    if ((effects & 1u << e) != 0) {
      change[e] = fmax(change[e], speed);
    }
  }
}

/* Is there a moment on an axis that the effects would free, beyond what rounding of the contact forces makes? */
static bool any_moment(const world *w, unsigned effects, const double *impulse) {
  static const double rounding = 1e-12;
  double press = 0.0;
  for (int i = 0; i < w->set.n_contact; i++) {
    press += fmax(impulse[w->store.row_start[i]], 0.0);
  }
  for (int i = 0; i < w->n_body; i++) {
    const unsigned locked = world_locked_now(w, i, effects);
    const double least = rounding * press * w->body[i].bound;
    for (int k = 3; k < AXES; k++) {
      if ((locked & 1u << k) != 0 && fabs(world_residual(w, i)->wrench[k]) > least) {
        return true;
      }
    }
  }
  return false;
}

/* still: the contacts can share their forces so that no body turns; firm: and what rubs a body too. */
static void judge_body(const world *w, int i, unsigned effects, bool still, bool firm,
                       double change[EFFECT_COUNT]) {
  const unsigned omitted = effects & ~w->effects;
  const unsigned locked = world_locked_now(w, i, effects);
  const body *b = &w->body[i];
  const residual *r = world_residual(w, i);
  if (w->spec.body[i].kinematic) {
    return;
  }
  const double reach =
      b->bound / world_least_inertia(w, i); /* velocity a moment gives its points */
  for (int k = 0; k < AXES; k++) {
    if ((locked & 1u << k) != 0 && !(k >= 3 && still)) {
      raise(change, world_axis_needs(k, w->dim) & omitted,
            fabs(r->wrench[k]) * (k < 3 ? 1.0 / b->mass : reach));
    }
  }
  const bool can_turn =
      (world_free_axes(w, i, effects) & (unsigned)SPEC_ROT) != 0 && !(firm && !world_is_ball(w, i));
  const double arm = can_turn ? b->bound * reach : 0.0;
  raise(change, omitted & EFFECT_FRICTION, r->rub * (1.0 / b->mass + arm));
  raise(change, omitted & (EFFECT_ROLLING | EFFECT_TORSION), r->resist * reach);
  raise(change, omitted & EFFECT_RESTITUTION, 2.0 * r->bounce);
}

/* Is there a law left out that could act on a body? */
static bool any_law(const world *w) {
  bool any = false;
  for (int i = 0; i < w->n_body; i++) {
    const residual *r = world_residual(w, i);
    any = any || r->rub > 0.0 || r->resist > 0.0 || r->bounce > 0.0;
  }
  return any;
}

world_growth world_omitted(const world *w, unsigned effects, bool deviates, const double *v_next,
                           const double *impulse, double change[EFFECT_COUNT]) {
  const unsigned omitted = effects & ~w->effects;
  world_growth growth = {0};
  memset(change, 0, EFFECT_COUNT * sizeof *change);
  if (w->model != NULL || (omitted == 0 && !deviates)) {
    return growth;
  }
  memset(w->residual, 0, (size_t)w->n_body * sizeof(residual));
  const bool locks = (omitted & (EFFECT_ROTATION | EFFECT_SPATIAL)) != 0;
  for (int i = 0; i < w->set.n_contact; i++) {
    const double press = impulse[w->store.row_start[i]];
    if (press > 0.0) {
      add_laws(w, omitted, i, v_next, press);
    }
  }
  const bool acts = deviates || any_law(w);
  if (locks || acts) {
    world_add_wrenches(w, impulse);
  }
  const bool pulls = locks && any_moment(w, effects, impulse);
  bool firm = false;
  if (acts || pulls) {
    growth = world_grown(w, effects, v_next, impulse);
    firm = !growth.turned;
  }
  const bool still = pulls && (firm || world_stands(w, effects, impulse));
  for (int i = 0; i < w->n_body; i++) {
    judge_body(w, i, effects, still, firm, change);
  }
  return growth;
}
