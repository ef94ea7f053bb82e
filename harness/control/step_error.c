/* step_error.c - what a step is off by, over its share. */
#include "harness/control/step_state.h"

/* Share of the tolerance that each step with a change of contacts may take, and that every step may take: the error of a
 * very short one is that of its solves, however short it is. */
static const double event_share = 1.0 / 32.0, least_share = 1.0 / 16384.0;

static double share_of(const controlled *c, double h, double least) {
  return fmax(h / c->run.q->duration, least);
}

double step_share(const controlled *c, double h) {
  return share_of(c, h, event_share);
}

double step_tolerance(const controlled *c) {
  return fmax(c->rule->tolerance, c->rule->of_travel * c->places->travel);
}

double step_way(const controlled *c) {
  return fmax(c->places->travel, c->places->size);
}

double step_reach(const controlled *c) {
  const sim *s = &c->run;
  const double left = fmax(s->q->duration - world_time(s->w), 0.0);
  return (c->fastest * left > step_way(c)) ? step_way(c) / c->fastest : left;
}

/* How far a body is aside at the end for each length that an impact is off by [1]: sides of bodies that are round, or turn, push in another direction
 * then, by that length over the size of a body, for as long as velocities last. */
static double lever(const controlled *c) {
  return fmax(1.0, step_reach(c) * c->fastest / c->places->size);
}

bool step_changes(const controlled *c) {
  return c->pair.coarse.event || c->pair.fine.event;
}

/* Do both ways over a step in which contacts change begin to carry, or neither, and the fine one not for its first half only? A contact that
 * has just let go, and whose gap turning opens, carries again in each step so long that it would close along its normal at the start:
 * twice the fine way less the coarse one, which holds, loses the speed at which it opens, in every step and however short that is. */
static bool both_alike(const step_end *coarse, const step_end *fine, sim_carrying before) {
  return coarse->more == fine->more && (!fine->more || fine->carrying.ids != before.ids);
}

bool step_modes_differ(const controlled *c) {
  return c->pair.fine.mixed || c->pair.coarse.carrying.slips != c->pair.fine.carrying.slips;
}

/* Do bristles hold by one of the ways over the step and give way by the other, whose velocities are so far apart? What bristles leave of a
 * velocity is what stretches them. Twice the fine way less the coarse one goes against the push then, in every step however short, and a
 * box is held beyond its friction. What is a small part of the change of velocities makes no difference. */
static bool bristles_give_way(const controlled *c, double apart) {
  static const double slight = 0.25;
  if (!step_modes_differ(c) || (c->run.q->form->form->model & FORM_REGULARISED) == 0) {
    return false;
  }
  double position;
  double change;
  world_saved_distance(c->run.w, c->pair.start.state, c->pair.fine.state, &position, &change);
  return apart > slight * change;
}

/* What the step of h is off by over its share where it may end where both of its ways together point, which are apart by *position and
 * `velocity`, e over the share if it does not [m]. *position: what it is off by if contacts change in it. */
static double both_together(controlled *c, double h, double e, double velocity, double *position) {
  const sim *s = &c->run;
  const step_end *coarse = &c->pair.coarse;
  const step_end *fine = &c->pair.fine;
  const bool event = step_changes(c);
  const double here = *position + velocity * h;
  const double bend = world_saved_bend(s->w, h, c->pair.start.state, coarse->state, fine->state);
  double both = bend + velocity * h;
  c->bend = bend;
  if (!event) {
    both = fmin(both, step_pair_unsteady(&c->pair, s, h));
  }
  *position = fmax(*position, bend); /* what came and went in either half */
  c->off = fmax(c->off, bend);
  e = fmax(e, bend / step_share(c, h));
  c->smooth = !event || (both_alike(coarse, fine, c->carrying) && both / (h / s->q->duration) <= e);
  if (c->smooth) {
    c->off = *position = both;
    e = both / share_of(c, h, least_share);
  }
  if (c->smooth && !event && bristles_give_way(c, velocity)) {
    c->smooth = false;
    c->off = *position = fmax(both, here);
    e = c->off / share_of(c, h, least_share);
  }
  return e;
}

/* How deep bodies come into each other in the step of h [m]. Where what closes closes behind the middle, both of its ways together end as
 * deep as the coarse one evenly accelerated. */
static double sunk_in(const controlled *c, double h) {
  const step_end *coarse = &c->pair.coarse;
  const step_end *fine = &c->pair.fine;
  const double at = coarse->closing.at;
  const bool behind = c->smooth && !step_changes(c) && at >= 0.5 * h && at <= h;
  return behind ? fmax(coarse->even, fine->held) : fine->sunk;
}

/* Notes what friction that turns round, or gives way, in the step of h is off by [m/s]: one that pushes on is of before the slip turned
 * round, on both ways alike; where a slip breaks away friction falls, and both ways may say so late by half of the step. What slips at once
 * may have done so since the step before held last, at its middle; no shorter step mends that. */
static void note_slips(controlled *c, double h) {
  const step_end *fine = &c->pair.fine;
  const bool event = step_changes(c);
  c->slipped = fmax(event ? 0.0 : fine->pushed, 2.0 * fine->broke);
  c->late_speed = event ? 0.0 : fine->broke_at_once * c->unseen_for / (0.5 * h);
}

double step_error(controlled *c, double h) {
  double position;
  double velocity;
  const step_end *coarse = &c->pair.coarse;
  const step_end *fine = &c->pair.fine;
  c->smooth = false;
  c->passed = c->slipped = c->late_speed = 0.0;
  if (!coarse->good || !fine->good) {
    return HUGE_VAL;
  }
  world_saved_distance(c->run.w, coarse->state, fine->state, &position, &velocity);
  const bool event = step_changes(c);
  const double lasts = step_reach(c);
  c->off = c->plain = position + velocity * lasts;
  double e = c->off / share_of(c, h, event ? event_share : least_share);
  if (c->rule->extrapolate) {
    e = both_together(c, h, e, velocity, &position);
  }
  note_slips(c, h);
  const double sunk = sunk_in(c, h), slips = c->slipped * (lasts + h);
  const double changed = fmax(event ? position : 0.0, sunk * lever(c));
  c->located = fmax(changed, fmax(slips, c->late_speed * (lasts + h)));
  e = fmax(e, fmax(sunk, slips) / step_share(c, h)) / step_tolerance(c);
  return (e == e) ? e : HUGE_VAL;
}

double step_shallow(const controlled *c) {
  static const double most = 0.02; /* of the smallest body */
  return fmin(0.5 * step_tolerance(c) * event_share / lever(c), most * c->places->size);
}
