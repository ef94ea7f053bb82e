/* step_sight.c - what happens in a step and neither of its ends tells of.
 *
 * A side may come to another that no contact at the start of a step has told of, or that opens again within it: how much deeper bodies
 * are in each other at its end counts as what changes; where two come near each other and are gone at the end (world_first_touch), the
 * step is tried again up to there; and where two come into each other and part again in a step of even acceleration, so that no solve gave an
 * impact, twice the speed at which they do counts, as long as velocities last, and as `jump`.
 *
 * A side of a body may end under another within a step, which both of its ways see only from the next step on. Where bodies carry each
 * other whose sides end, a step behind the one just tried tells: it is halved until what velocities do otherwise there makes no
 * difference. */
#include "harness/control/step_state.h"

/* Is the step just tried one of an even acceleration, so that two sides that come into each other at this speed and part again do so without an
 * impact? What contacts give at once would show. Of the first step nothing was known before. */
static bool is_even(const controlled *c, double h, double speed) {
  static const double slight = 0.05;
  return (!step_changes(c) || c->kept->n == 0) && c->bend < slight * speed * h;
}

/* A side may come to another that no contact at the start of the step has told of, and may be gone at its end: *at is when one does. How much
 * deeper bodies are in each other behind the step counts. */
static base_status look_back(controlled *c, double h, double *e, double *at, base_error *err) {
  world *w = c->run.w;
  double depth;
  double passed;
  if (!c->rule->extrapolate) {
    return BASE_OK;
  }
  if (c->smooth) {
    world_extrapolate(w, c->pair.coarse.state, c->pair.fine.state);
  }
  BASE_TRY(world_depth(w, &depth, err));
  BASE_TRY(world_first_touch(w, h, c->pair.start.state, step_shallow(c), at, &passed, err));
  if (c->smooth) {
    world_load(w, c->pair.fine.state);
  }
  const double share = step_share(c, h);
  c->passed = is_even(c, h, passed) ? 2.0 * passed : 0.0;
  const double missed = c->passed * (step_reach(c) + h);
  const double deeper = fmax(depth - c->pair.coarse.start, missed);
  c->located = fmax(c->located, deeper);
  *e = fmax(*e, deeper / share / step_tolerance(c));
  return BASE_OK;
}

/* The length of a step in the place of one of h behind which a steady turning is so much faster that what is off it has grown by more than a
 * step may see; HUGE_VAL: it is not. */
static double spun_up(const controlled *c, double h) {
  static const double spare = 1.5;
  const double longest = step_longest(c);
  return (h > spare * longest) ? fmax(0.5 * h, longest) : HUGE_VAL;
}

/* A contact that carries may end with a side of its body, and neither way over the step knows when. A step behind it tells: by as much as velocities
 * go another way in that, bodies may have gone another way since the middle of this one. *at: where to look for it; h or more: it makes no
 * difference. */
static base_status look_ahead(controlled *c, double h, double *at, base_error *err) {
  static const double still = 1e-6; /* of the smallest body */
  static const double slight =
      0.1; /* of what velocities change by in a step: forces that fade out do no more */
  sim *s = &c->run;
  world *w = s->w;
  double position;
  double velocity;
  const step_end *fine = &c->pair.fine;
  if (!c->rule->extrapolate || step_changes(c) || !world_sides_touch(w)) {
    return BASE_OK;
  }
  world_saved_distance(w, c->pair.start.state, fine->state, &position, &velocity);
  if (!(position > still * c->places->size)) {
    return BASE_OK;
  }
  const int row = c->record->n_row - 1;
  const double deep =
      c->record->column[SERIES_PENETRATION][row]; /* the step behind tells it again */
  BASE_TRY(step_pair_begin(&c->ahead, s, c->record, fine->carrying, h, err));
  c->account->solved = ++c->pair.solved;
  world_extrapolate(w, c->pair.start.state, fine->state); /* as the step has gone */
  world_save(w, c->ahead.fine.state);
  const saved_step own = {h, c->pair.start.state, NULL, fine->state};
  const saved_step next = {h, c->ahead.fine.state, NULL, c->ahead.coarse.state};
  const double swerve = world_saved_swerve(w, &own, &next, slight);
  const bool ends = c->ahead.coarse.good && c->ahead.coarse.event && !c->ahead.coarse.more;
  BASE_TRY(step_pair_undo(&c->ahead, s, c->record, err));
  c->record->column[SERIES_PENETRATION][row] = deep;
  const double late = ends ? 0.5 * swerve * (step_reach(c) + h) : 0.0;
  c->located = fmax(c->located, late);
  c->off = fmax(c->off, late);
  *at = (late > step_tolerance(c) * step_share(c, h)) ? fmin(*at, 0.5 * h) : *at;
  return BASE_OK;
}

/* Does the step of h just tried end where friction gives way or a contact opens, as near as is known? What slips in its second half did so
 * before that, at a time which only a step before it tells. */
static bool has_aimed(const controlled *c, double h, aim aimed) {
  return aimed == AIM_SLIP || aimed == AIM_OPENING ||
         (aimed == AIM_BEFORE_SLIP && !break_away_in(c->pair.load, h).told);
}

base_status step_look(controlled *c, double h, aim aimed, double *e, double *at, base_error *err) {
  *at = HUGE_VAL;
  if (*e <= 1.0) {
    BASE_TRY(look_back(c, h, e, at, err));
    const double gives_way = fmin(break_away_in(c->pair.load, h).at, step_opens(c, h));
    *at = has_aimed(c, h, aimed) ? *at : fmin(*at, gives_way);
    *at = fmin(*at, spun_up(c, h));
    BASE_TRY(look_ahead(c, h, at, err));
  }
  return BASE_OK;
}
