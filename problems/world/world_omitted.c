/* world_omitted.c - what effects that are left out would do in a step, from the step without them.
 *
 * The step without an effect is one with it where the force that the effect would add is zero. So each effect has a
 * residual: along axes that are locked the impulse that contacts, joints and loads leave over; at contacts without
 * friction (rolling, torsion) what Coulomb's law could exert at the velocity there. And where axes are locked, what friction makes of
 * the load that bodies may take off each other, of which the step has one share of many. */
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

/* No force exceeds mu p, nor what stops the sliding: u over the mobility of the two sides. What does not slide needs none, though the
 * axes along which it could are locked. */
static double most_of(double coefficient, double press, double speed, double mobility) {
  const double most = coefficient * press;
  return (mobility > 0.0) ? fmin(most, speed / mobility) : (speed > 0.0) ? most : 0.0;
}

/* Of a force against the sliding, the moment about the normal. */
static void add_yaw(const world *w, int side, const double *x, const double *n, const double *f,
                    double sign) {
  double arm[3], moment[3];
  if (side < w->n_body) {
    v3_sub(x, w->body[side].at.x, arm);
    v3_cross(arm, f, moment);
    world_residual(w, side)->yaw += sign * v3_dot(moment, n);
  }
}

/* Is each side of c a ball, or does not move? */
static bool are_balls(const world *w, const contact_item *c) {
  return world_is_ball(w, c->a) && (c->b >= w->n_body || world_is_ball(w, c->b));
}

/* The most that friction gives over the normal force [1]. */
static double law_of(const world *w, const contact_item *c) {
  return fmax(pair_value(&w->mu, c->a, c->b), pair_value(&w->mu_kinetic, c->a, c->b)) *
         w->friction_reach;
}

/* Rolling resistance may shift the load of a foot by its coefficient, though nothing turns: what that changes of the moment of a friction
 * that is simulated, where it slides somewhere, per length [N s]. */
static double shifted(const world *w, const contact_item *c, double press) {
  return are_balls(w, c) ? 0.0 : law_of(w, c) * press;
}

static const contact_item *item_of(const world *w, int i) {
  return &w->store.item[w->store.key[i].item];
}

/* Of the first side of contact i over the second: how it slides, u [m/s], and turns, spin [rad/s]. */
static void relative_motion(const world *w, int i, const double *v_next, double *u, double *spin) {
  const double *n = w->store.frame + 9 * (ptrdiff_t)i;
  world_contact_motion(w, i, v_next, u, spin);
  v3_add_scaled(u, -v3_dot(u, n), n, u);
}

/* Friction of contact i in the step. */
typedef struct grip {
  double speed; /* that it slides with [m/s] */
  double f[3],
      most; /* the friction, and what it could be while sliding or at rest, the smaller [N s] */
  double rolling; /* by so much its load may be shifted [m] */
} grip;

static grip grip_of(const world *w, int i, const double *v_next, const double *impulse) {
  const contact_item *c = item_of(w, i);
  const double *n = w->store.frame + 9 * (ptrdiff_t)i;
  const double mu = fmin(pair_value(&w->mu, c->a, c->b), pair_value(&w->mu_kinetic, c->a, c->b));
  const double press = fmax(impulse[w->store.row_start[i]], 0.0);
  double u[3], spin[3], moment[3];
  grip g = {.most = mu * press, .rolling = pair_value(&w->rolling, c->a, c->b)};
  relative_motion(w, i, v_next, u, spin);
  world_contact_impulse(w, i, impulse, g.f, moment);
  v3_add_scaled(g.f, -v3_dot(g.f, n), n, g.f);
  g.speed = (law_of(w, c) * press > 0.0) ? v3_norm(u) : 0.0;
  return g;
}

/* The contacts from `first` on that are of the same two sides and have one normal end before this one. */
static int group_end(const world *w, int first) {
  const contact_item *c = item_of(w, first);
  const double *n = w->store.frame + 9 * (ptrdiff_t)first;
  int i = first + 1;
  while (i < w->set.n_contact && item_of(w, i)->a == c->a && item_of(w, i)->b == c->b &&
         v3_dot(w->store.frame + 9 * (ptrdiff_t)i, n) > 1.0 - 1e-9) {
    i++;
  }
  return i;
}

/* Do they slide, or nearly? What they hold together counts, a force and a moment about where they press: how they share it is not told. Where
 * rotation is left out the loads are in no balance, and feet count alike, their moment not at all. */
static bool group_slides(const world *w, int first, int end, const double *v_next,
                         const double *impulse, double least) {
  /* of what friction can do, and of the mean distance of the feet from their centre: a load that is shifted by that leaves each of them
   * more than that much of its friction */
  static const double near = 0.5, shift = 0.25;
  const bool turns = (w->effects & EFFECT_ROTATION) != 0;
  const double *n = w->store.frame + 9 * (ptrdiff_t)first;
  double all = 0.0, weight = 0.0, centre[3] = {0}, force[3] = {0}, pulls = 0.0, rolling = 0.0;
  for (int i = first; i < end; i++) {
    const grip g = grip_of(w, i, v_next, impulse);
    if (g.speed > least) {
      return true;
    }
    const double counts = turns ? g.most : 1.0;
    rolling = fmax(rolling, g.rolling);
    all += g.most;
    pulls += v3_norm(g.f);
    weight += counts;
    v3_add_scaled(centre, counts, item_of(w, i)->x, centre);
    v3_add_scaled(force, 1.0, g.f, force);
  }
  if (!(all > 0.0) || !(pulls > 0.0)) {
    return pulls > 0.0;
  }
  double turn = 0.0, reach = 0.0;
  v3_scale(1.0 / weight, centre, centre);
  for (int i = first; i < end; i++) {
    const grip g = grip_of(w, i, v_next, impulse);
    double arm[3], moment[3];
    v3_sub(item_of(w, i)->x, centre, arm);
    v3_cross(arm, g.f, moment);
    turn += turns ? v3_dot(moment, n) : 0.0;
    reach += (turns ? g.most : 1.0) / weight * v3_norm(arm);
  }
  const bool shifts = !are_balls(w, item_of(w, first)) && rolling > shift * reach;
  return shifts || v3_norm(force) * reach + fabs(turn) > near * all * reach;
}

/* Does friction slide somewhere, or nearly? Otherwise it holds wherever rolling lets the loads lie. */
static bool slides(const world *w, unsigned effects, const double *v_next, const double *impulse,
                   double least) {
  bool some = false;
  for (int i = 0; i < w->set.n_contact && !some && (effects & EFFECT_FRICTION) != 0;) {
    const int end = group_end(w, i);
    some = group_slides(w, i, end, v_next, impulse, least);
    i = end;
  }
  return some;
}

static void add_laws(const world *w, unsigned omitted, bool slide, int i, const double *v_next,
                     double press) {
  const set_store *s = &w->store;
  const contact_item *c = item_of(w, i);
  const double *n = s->frame + 9 * (ptrdiff_t)i;
  double ua[3], wa[3];
  relative_motion(w, i, v_next, ua, wa);
  if ((omitted & EFFECT_FRICTION) != 0) {
    const double mu = law_of(w, c);
    const double mobility = inverse_mass(w, c->a) + inverse_mass(w, c->b);
    const double speed = v3_norm(ua), rub = most_of(mu, press, speed, mobility);
    add_to_sides(w, c, offsetof(residual, rub), rub);
    if (w->dim == 3 && speed > 0.0) {
      v3_scale(-rub / speed, ua, ua);
      add_yaw(w, c->a, c->x, n, ua, 1.0);
      add_yaw(w, c->b, c->x, n, ua, -1.0);
    }
  }
  const double turning = inverse_inertia(w, c->a) + inverse_inertia(w, c->b);
  const double about = v3_dot(wa, n);
  v3_add_scaled(wa, -about, n, wa);
  double resist = 0.0;
  if ((omitted & EFFECT_TORSION) != 0) {
    resist += most_of(pair_value(&w->torsion, c->a, c->b), press, fabs(about), turning);
  }
  if ((omitted & EFFECT_ROLLING) != 0) {
    const double rolling = pair_value(&w->rolling, c->a, c->b);
    resist += most_of(rolling, press, v3_norm(wa), turning);
    resist += slide ? rolling * shifted(w, c, press) : 0.0;
  }
  if (resist > 0.0) {
    add_to_sides(w, c, offsetof(residual, resist), resist);
  }
  if ((omitted & EFFECT_RESTITUTION) != 0) {
    const double e = pair_value(&w->restitution, c->a, c->b);
    add_to_sides(w, c, offsetof(residual, bounce), -e * fmin(s->u_before[s->row_start[i]], 0.0));
  }
}

/* ---- load that bodies take off each other ------------------------------------------------------ */

static const double one_plane = 1e-9; /* of the length of its normal */

/* Notes of a side the friction on it of a contact that slides, sign f over its load, and the normal n. */
static void note_slide(const world *w, int side, const double *f, double sign, const double *n) {
  double own[3], apart[3];
  if (side >= w->n_body) {
    return;
  }
  residual *r = world_residual(w, side);
  v3_scale(sign, f, own);
  if (r->slides == 0.0) {
    r->slides = 1.0;
    v3_copy(own, r->rubs);
    v3_copy(n, r->plane);
  }
  v3_sub(own, r->rubs, apart);
  r->unlike = fmax(r->unlike, v3_norm(apart));
  r->slides = v3_along(n, r->plane, one_plane) ? r->slides : 2.0;
}

/* Does anything slide? */
static bool note_slides(const world *w, const double *v_next, const double *impulse, double least) {
  bool some = false;
  for (int i = 0; i < w->set.n_contact; i++) {
    const contact_item *c = item_of(w, i);
    const double *n = w->store.frame + 9 * (ptrdiff_t)i;
    double u[3], spin[3];
    if (!(impulse[w->store.row_start[i]] > 0.0)) {
      continue;
    }
    relative_motion(w, i, v_next, u, spin);
    const double speed = v3_norm(u);
    if (speed > least) {
      some = true;
      v3_scale(-law_of(w, c) / speed, u, u);
      note_slide(w, c->a, u, 1.0, n);
      note_slide(w, c->b, u, -1.0, n);
    }
  }
  return some;
}

/* What friction on the sides of contact i, which presses with `press`, changes by the load that one takes off the other. */
static void add_taken(const world *w, int i, double press, double least) {
  static const double rounding = 1e-9; /* of two directions that are one */
  const contact_item *c = item_of(w, i);
  const double *n = w->store.frame + 9 * (ptrdiff_t)i;
  if (!(press > 0.0) || !(inverse_mass(w, c->a) > 0.0) || !(inverse_mass(w, c->b) > 0.0)) {
    return;
  }
  const residual *a = world_residual(w, c->a), *b = world_residual(w, c->b);
  const double *plane = (a->slides > 0.0) ? a->plane : b->plane;
  const bool one = fmax(a->slides, b->slides) <= 1.0 && (a->slides == 0.0 || b->slides == 0.0 ||
                                                         v3_along(a->plane, b->plane, one_plane));
  double apart[3], across[3];
  v3_sub(a->rubs, b->rubs, apart);
  v3_cross(n, plane, across);
  const double alone = fmax(v3_norm(a->rubs), v3_norm(b->rubs));
  const bool meet = w->store.u_before[w->store.row_start[i]] < -least; /* and may part again */
  const double unlike = fmax(v3_norm(apart), meet ? alone : 0.0) + a->unlike + b->unlike;
  if (unlike > rounding) {
    const double held = law_of(w, c) * press * (one ? v3_norm(across) : 1.0);
    add_to_sides(w, c, offsetof(residual, taken), held * unlike);
  }
}

/* Two bodies that hold each other by friction may take load off each other, by all that it can hold along the normals of what slides, at the
 * press of the step. Those that slide alike go on alike, unless they meet in the step. Where one of them slides otherwise than the other, or
 * does not, their motion goes with it, and the full run takes another share than one of fewer axes, or of fewer contacts in the plane. */
static void add_all_taken(const world *w, const double *v_next, const double *impulse,
                          double least) {
  if (!note_slides(w, v_next, impulse, least)) {
    return;
  }
  for (int i = 0; i < w->set.n_contact; i++) {
    add_taken(w, i, impulse[w->store.row_start[i]], least);
  }
}

void world_set_friction_reach(world *w, double reach) {
  w->friction_reach = reach;
}

void world_acted(const world *w, const double *impulse, world_growth *grown) {
  const set_store *s = &w->store;
  for (int i = 0; i < w->n_body; i++) {
    grown[i].acted = grown[i].held = 0.0;
  }
  for (int i = 0; i < w->set.n_contact; i++) {
    const contact_item *c = &s->item[s->key[i].item];
    const double *n = s->frame + 9 * (ptrdiff_t)i;
    const int side[2] = {c->a, c->b};
    double f[3], m[3];
    world_contact_impulse(w, i, impulse, f, m);
    v3_add_scaled(f, -v3_dot(f, n), n, f);
    for (int k = 0; k < 2; k++) {
      if (side[k] < w->n_body) {
        const double reach = w->body[side[k]].bound * inverse_inertia(w, side[k]);
        grown[side[k]].acted += v3_norm(f) * inverse_mass(w, side[k]);
        grown[side[k]].held += v3_norm(m) * reach;
      }
    }
  }
}

/* Without one of these, bodies have fewer axes. */
static const unsigned locking = EFFECT_ROTATION | EFFECT_SPATIAL;

/* ---- the whole -------------------------------------------------------------------------------- */

/* Where one body's changes go to. */
typedef struct change_of {
  double least, *change;
  world_growth *body;
} change_of;

static void raise(const change_of *to, unsigned effects, double moved, double spun) {
  const double speed = moved + spun;
  if (!(speed > to->least) || effects == 0) {
    return;
  }
  for (int e = 0; e < EFFECT_COUNT; e++) {
    if ((effects & 1u << e) != 0) {
      to->change[e] = fmax(to->change[e], speed);
    }
  }
  to->body->moved += moved;
  to->body->spun += spun;
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

/* Do contacts of bodies that are no balls resist rolling or torsion? Then their forces may lie aside of where they would be without, and
 * where friction slides no balance tells where. */
static bool resists(const world *w, unsigned effects, const double *impulse) {
  const set_store *s = &w->store;
  const bool declared = (effects & (EFFECT_ROLLING | EFFECT_TORSION)) != 0;
  bool some = false;
  for (int i = 0; i < w->set.n_contact && declared && !some; i++) {
    const contact_item *c = &s->item[s->key[i].item];
    const bool balls = are_balls(w, c);
    const double rolling =
        ((effects & EFFECT_ROLLING) != 0) ? pair_value(&w->rolling, c->a, c->b) : 0.0;
    const double torsion =
        ((effects & EFFECT_TORSION) != 0) ? pair_value(&w->torsion, c->a, c->b) : 0.0;
    some = impulse[s->row_start[i]] > 0.0 && !balls && (rolling > 0.0 || torsion > 0.0);
  }
  return some;
}

/* still: the contacts can share their forces so that no body turns; firm: and what rubs a body too. */
static void judge_body(const world *w, int i, unsigned effects, bool still, bool firm,
                       const change_of *to) {
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
      const double by = fabs(r->wrench[k]);
      raise(to, world_axis_needs(k, w->dim) & omitted, (k < 3) ? by / b->mass : 0.0,
            (k < 3) ? 0.0 : by * reach);
    }
  }
  const bool can_turn = (world_free_axes(w, i, effects) & (unsigned)SPEC_ROT) != 0;
  const double most = b->bound * r->rub; /* moment */
  const double not_held = (firm && !world_is_ball(w, i)) ? fmin(fabs(r->yaw), most) : most;
  raise(to, omitted & EFFECT_FRICTION, r->rub / b->mass, can_turn ? not_held * reach : 0.0);
  raise(to, omitted & (EFFECT_ROLLING | EFFECT_TORSION), 0.0, r->resist * reach);
  raise(to, omitted & EFFECT_RESTITUTION, r->bounce, r->bounce);
  raise(to, omitted & locking, r->taken / b->mass, 0.0);
}

static bool all_firm(const world *w, const world_growth *grown) {
  bool all = true;
  for (int i = 0; i < w->n_body && all; i++) {
    all = !grown[i].turned;
  }
  return all;
}

/* Is there a law left out that could act on a body? */
static bool any_law(const world *w) {
  bool any = false;
  for (int i = 0; i < w->n_body; i++) {
    const residual *r = world_residual(w, i);
    any = any || r->rub > 0.0 || r->resist > 0.0 || r->bounce > 0.0 || r->taken > 0.0;
  }
  return any;
}

void world_omitted(const world *w, unsigned effects, bool deviates, double least,
                   const double *v_next, const double *impulse, double change[EFFECT_COUNT],
                   world_growth *grown) {
  const unsigned omitted = effects & ~w->effects;
  memset(change, 0, EFFECT_COUNT * sizeof *change);
  for (int i = 0; i < w->n_body; i++) {
    grown[i] = (world_growth){.group = i};
  }
  if (w->model != NULL || (omitted == 0 && !deviates)) {
    return;
  }
  memset(w->residual, 0, (size_t)w->n_body * sizeof(residual));
  const bool locks = (omitted & locking) != 0;
  const bool slide = resists(w, effects, impulse) && slides(w, effects, v_next, impulse, least);
  for (int i = 0; i < w->set.n_contact; i++) {
    const double press = impulse[w->store.row_start[i]];
    if (press > 0.0) {
      add_laws(w, omitted, slide && (w->effects & EFFECT_FRICTION) != 0, i, v_next, press);
    }
  }
  if (locks && (w->effects & EFFECT_FRICTION) != 0) {
    add_all_taken(w, v_next, impulse, least);
  }
  const bool acts = deviates || any_law(w);
  if (!locks && !acts) {
    return;
  }
  world_add_wrenches(w, impulse);
  const bool pulls = locks && any_moment(w, effects, impulse);
  const bool sharing = pulls && !slide;
  bool still = sharing && !acts && world_stands(w, effects, impulse);
  const bool asks = acts || (pulls && !still);
  if (asks) {
    world_grown(w, effects, v_next, impulse, grown);
  }
  still = still || (sharing && acts && (all_firm(w, grown) || world_stands(w, effects, impulse)));
  for (int i = 0; i < w->n_body; i++) {
    const change_of to = {least, change, &grown[i]};
    judge_body(w, i, effects, still, asks && !grown[i].turned, &to);
  }
}
