#include "harness/control/step_control.h"

#include "harness/control/break_away.h"
#include "harness/control/extrapolation.h"
#include "harness/control/patience.h"

#include <stdlib.h>
#include <string.h>

/* Share of the tolerance that each step with a change of contacts may take, and that every step may take: the error of a
 * very short one is that of its solves, however short it is. */
static const double event_share = 1.0 / 32.0, least_share = 1.0 / 16384.0;
/* PI control of a step whose error for a share that grows with it is of first order (Gustafsson 1991). */
static const double safety = 0.9, integral = 0.7, proportional = 0.4, shrink = 0.2, grow = 4.0;

typedef struct controlled {
  sim run;
  const step_rule *rule;
  series *record;
  step_list *kept;
  run_places *places;
  step_account *account;
  step_pair pair, ahead;
  bool smooth; /* the step just tried: both of its ways together are better than the fine one */
  double off, plain;     /* what it is off by, and would be if it were not extrapolated [m] */
  bool failed;           /* a step of the shortest length has no solution: the run ends there */
  sim_carrying carrying; /* of the last step kept */
  double fastest;        /* largest speed of a body so far [m/s] */
  double located;        /* of the step just tried [m] */
  double passed;         /* that an impact which none of its solves saw would change [m/s] */
  double slipped;        /* what a slip that begins or turns in it is off by at its end [m/s] */
  double sure_until;     /* friction that was foreseen to give way by now does so until then [s] */
  double unseen_for;     /* so long the last step may have held what had given way [s] */
  double late_speed;     /* that this is, of what slips at once in the step just tried [m/s] */
  double bend;           /* of its way, beyond what a constant acceleration explains [m] */
  double hit_until;      /* for so long the last impact may yet be to come [s] */
  double hit_jump;       /* and so much it changes velocities by [m/s] */
  double *
      law; /* n_dof velocities that friction gave so far beyond a round cone's; owned, NULL: none */
  double last;   /* error over its share, of the last step kept [1] */
  double stride; /* of the last step that met something, which is yet to come; 0: nothing is [s] */
  bool strides;  /* the next step is tried with it */
  openings opening;
  patience longer,
      onward; /* with longer steps, and behind an impact with one as long as before it */
} controlled;

static double tolerance_of(const controlled *c) {
  return fmax(c->rule->tolerance, c->rule->of_travel * c->places->travel);
}

double step_beside_growth(const world *w) {
  static const double part = 0.25;
  return part / world_growth_rate(w);
}

/* ---- one step -------------------------------------------------------------------------------- */

/* How far bodies get, as far as is known: points less than they may, so that their size counts, too [m]. */
static double way(const controlled *c) {
  return fmax(c->places->travel, c->places->size);
}

/* How long a difference of velocities lasts: what is left of the run, or the time in which the fastest body has come as
 * far as the bodies get [s]. */
static double reach(const controlled *c) {
  const sim *s = &c->run;
  const double left = fmax(s->q->duration - world_time(s->w), 0.0);
  return (c->fastest * left > way(c)) ? way(c) / c->fastest : left;
}

/* How far a body is aside at the end for each length that an impact is off by [1]: sides of bodies that are round, or turn, push in another direction
 * then, by that length over the size of a body, for as long as velocities last. */
static double lever(const controlled *c) {
  return fmax(1.0, reach(c) * c->fastest / c->places->size);
}

/* Do other contacts carry in the step just tried than before it? */
static bool changes(const controlled *c) {
  return c->pair.coarse.event || c->pair.fine.event;
}

/* Do both ways over a step in which contacts change begin to carry, or neither, and the fine one not for its first half only? A contact that
 * has just let go, and whose gap turning opens, carries again in each step so long that it would close along its normal at the start:
 * twice the fine way less the coarse one, which holds, loses the speed at which it opens, in every step and however short that is. */
static bool both_alike(const step_end *coarse, const step_end *fine, sim_carrying before) {
  return coarse->more == fine->more && (!fine->more || fine->carrying.ids != before.ids);
}

/* Do contacts hold in one of the steps just tried that slip in another? */
static bool modes_differ(const controlled *c) {
  return c->pair.fine.mixed || c->pair.coarse.carrying.slips != c->pair.fine.carrying.slips;
}

/* Do bristles hold by one of the ways over the step and give way by the other, whose velocities are so far apart? What bristles leave of a
 * velocity is what stretches them. Twice the fine way less the coarse one goes against the push then, in every step however short, and a
 * box is held beyond its friction. What is a small part of the change of velocities makes no difference. */
static bool bristles_give_way(const controlled *c, double apart) {
  static const double slight = 0.25;
  if (!modes_differ(c) || (c->run.q->form->form->model & FORM_REGULARISED) == 0) {
    return false;
  }
  double position;
  double change;
  world_saved_distance(c->run.w, c->pair.start.state, c->pair.fine.state, &position, &change);
  return apart > slight * change;
}

/* Error over the share that a step of h may take [1]. */
static double error_of(controlled *c, double h) {
  double position;
  double velocity;
  const sim *s = &c->run;
  const step_end *coarse = &c->pair.coarse;
  const step_end *fine = &c->pair.fine;
  const double part = h / s->q->duration;
  c->smooth = false;
  c->passed = c->slipped = c->late_speed = 0.0;
  if (!coarse->good || !fine->good) {
    return HUGE_VAL;
  }
  world_saved_distance(s->w, coarse->state, fine->state, &position, &velocity);
  const bool event = changes(c);
  c->off = c->plain = position + velocity * reach(c);
  const double here = position + velocity * h;
  double e = c->off / fmax(part, event ? event_share : least_share);
  if (c->rule->extrapolate) {
    const double bend = world_saved_bend(s->w, h, c->pair.start.state, coarse->state, fine->state);
    double both = bend + velocity * h;
    c->bend = bend;
    if (!event) {
      both = fmin(both, step_pair_unsteady(&c->pair, s, h));
    }
    position = fmax(position, bend); /* what came and went in either half */
    c->off = fmax(c->off, bend);
    e = fmax(e, bend / fmax(part, event_share));
    c->smooth = !event || (both_alike(coarse, fine, c->carrying) && both / part <= e);
    if (c->smooth) {
      c->off = position = both;
      e = both / fmax(part, least_share);
    }
    if (c->smooth && !event && bristles_give_way(c, velocity)) {
      c->smooth = false;
      c->off = position = fmax(both, here);
      e = c->off / fmax(part, least_share);
    }
  }
  /* where what closes closes behind the middle, both of its ways together end as deep as the coarse one evenly accelerated */
  const bool behind =
      c->smooth && !event && coarse->closing.at >= 0.5 * h && coarse->closing.at <= h;
  const double sunk = behind ? fmax(coarse->even, fine->held) : fine->sunk;
  c->located = fmax(event ? position : 0.0, sunk * lever(c));
  /* a friction that pushes on is one of before the slip turned round, on both ways alike */
  const double lasts = reach(c) + h;
  const double pushed = event ? 0.0 : fine->pushed;
  /* where a slip breaks away friction falls, and both ways may say so late by half of the step */
  c->slipped = fmax(pushed, 2.0 * fine->broke);
  const double slips = c->slipped * lasts;
  c->located = fmax(c->located, slips);
  /* what slips at once may have done so since the step before held last, at its middle; no shorter step mends that */
  c->late_speed = event ? 0.0 : fine->broke_at_once * c->unseen_for / (0.5 * h);
  c->located = fmax(c->located, c->late_speed * lasts);
  e = fmax(e, fmax(sunk, slips) / fmax(part, event_share)) / tolerance_of(c);
  return (e == e) ? e : HUGE_VAL;
}

/* Half of what a step may sink; no side of a body is missed by it [m]. */
static double shallow(const controlled *c) {
  static const double most = 0.02; /* of the smallest body */
  return fmin(0.5 * tolerance_of(c) * event_share / lever(c), most * c->places->size);
}

/* The length of a step in the place of one of h in which a gap closes: to just behind that, so deep as `shallow`, and so that the gap is open
 * yet at half of it, where the fine way would meet it. h: none does. */
static double to_impact(const controlled *c, double h) {
  static const double most = 1.8; /* of when it closes */
  const sim_closing *closing = &c->pair.coarse.closing;
  const bool met = c->rule->extrapolate && closing->at < HUGE_VAL;
  return met ? fmin(closing->at + shallow(c) / closing->speed, most * closing->at) : h;
}

/* Does the coarse way over h tell that the step is too long: what closes in it sinks by more than its share? */
static bool foreseen(const controlled *c, double h) {
  const step_end *coarse = &c->pair.coarse;
  const double share = tolerance_of(c) * fmax(h / c->run.q->duration, event_share);
  return coarse->good && h > c->rule->least && to_impact(c, h) < 0.9 * h &&
         coarse->closing.deep > share;
}

/* Does the solver find the mode of a contact that takes all of its friction when its slip is at an end, and may hold as well? Sweeps do not. */
static bool decides(const controlled *c) {
  const lcp_solver *solver = c->run.q->solver->solver;
  return solver == NULL || solver->exact || solver->newton;
}

/* The length of a step in the place of one of h in whose second half friction stops: up to there, or just before. 0: none does. */
static double to_rest(const controlled *c, double h) {
  const double before = decides(c) ? 1.0 : 0.99;
  const double at = c->pair.fine.stops;
  const bool met = changes(c);
  return (c->rule->extrapolate && !met && at < 0.9 * h) ? before * at : 0.0;
}

/* By how much a step with error e over its share is shortened. An impact is met by halving: where it lies between the
 * middle and the end of a step, and only the finer way sees it, half of the step ends just behind it. */
static double shorter(const controlled *c, double e) {
  const bool both = c->pair.coarse.event && c->pair.fine.event;
  const bool met = c->pair.coarse.event != c->pair.fine.event || c->pair.fine.sunk > 0.0;
  const double wish = c->smooth ? sqrt(safety / e) : safety / e;
  if (c->rule->extrapolate && both) {
    return fmin(c->smooth ? fmax(safety / e, shrink) : wish, 0.5);
  }
  return fmin(fmax(wish, met ? 0.5 : shrink), 0.5);
}

/* What the length that is tried was aimed at. */
typedef enum aim { AIM_NOTHING, AIM_REST, AIM_BEFORE_SLIP, AIM_SLIP, AIM_OPENING } aim;

/* When a contact opens in the step of h just tried because loads change; HUGE_VAL: none does. Where loads do not change it opens as bodies move,
 * and how these do keeps the steps short. In a step with an impact, what contacts press with tells nothing. */
static double opens(const controlled *c, double h) {
  return (c->opening.asked && !changes(c)) ? opening_in(c->pair.load, h).at : HUGE_VAL;
}

/* Does the step of h just tried end where friction gives way or a contact opens, as near as is known? What slips in its second half did so
 * before that, at a time which only a step before it tells. */
static bool has_aimed(const controlled *c, double h, aim aimed) {
  return aimed == AIM_SLIP || aimed == AIM_OPENING ||
         (aimed == AIM_BEFORE_SLIP && !break_away_in(c->pair.load, h).told);
}

/* The length to try in the place of h, which was off by e over its share; twice in a row none is aimed at where friction stops. */
static double again(const controlled *c, double h, double e, aim *aimed) {
  const double impact = to_impact(c, h);
  if (impact < 0.9 * h) {
    *aimed = AIM_NOTHING;
    return impact;
  }
  const double rest = (*aimed == AIM_NOTHING) ? to_rest(c, h) : 0.0;
  *aimed = (rest > 0.0) ? AIM_REST : AIM_NOTHING;
  return (rest > 0.0) ? rest : h * shorter(c, e);
}

/* The length of the step after one of h that was kept with error e over its share. */
static double next_length(controlled *c, double h, double e) {
  const double now = fmin(fmax(e, 1e-6), 1.0); /* a forced one says nothing of the next */
  const double order = c->smooth ? 0.5 : 1.0;
  const double factor = safety * pow(now, -order * integral) * pow(c->last, order * proportional);
  c->last = now;
  return fmax(h * ((e > 1.0) ? grow : fmin(fmax(factor, shrink), grow)), c->rule->least);
}

static base_status count(controlled *c, double h, unsigned way, base_error *err) {
  step_account *a = c->account;
  run_places_note(c->places, c->run.w);
  c->fastest = fmax(c->fastest, world_max_speed(c->run.w));
  a->tolerance = tolerance_of(c);
  a->least = fmin(a->least, h);
  a->most = fmax(a->most, h);
  return step_list_append(c->kept, h, way | (c->run.turned ? STEP_TURNED : 0), err);
}

/* How far velocities get in the step just tried, and what a place between its ends is off the straight way. */
static void note_way(const controlled *c, double h, bool changed) {
  step_account *a = c->account;
  double position;
  double velocity;
  world_saved_distance(c->run.w, c->pair.start.state, c->pair.fine.state, &position, &velocity);
  a->bow = fmax(a->bow, 0.125 * h * velocity);
  if (!changed) {
    a->gain = fmax(a->gain, velocity);
  }
}

/* Friction that is not of a round cone gives velocities that the bodies keep. */
static base_status keep_law(controlled *c, double h, base_error *err) {
  const world *w = c->run.w;
  const int n = world_n_dof(w);
  if (c->pair.fine.friction.bent && c->law == NULL) {
    c->law = calloc((size_t)n, sizeof *c->law);
    if (c->law == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for the velocities of %d dofs", n);
    }
  }
  for (int k = 0; c->pair.fine.friction.bent && k < n; k++) {
    c->law[k] += c->pair.fine.law[k];
  }
  const double speed = (c->law != NULL) ? world_speed_at(w, c->law) : 0.0;
  c->account->law += h * speed;
  c->account->law_speed = fmax(c->account->law_speed, speed);
  c->account->left = fmax(c->account->left, c->pair.fine.friction.left * reach(c));
  return BASE_OK;
}

/* An impact that the step of h just kept met: it may as well be later by what gaps are off by. */
static void note_hit(controlled *c, double h) {
  double position;
  double velocity;
  world_saved_distance(c->run.w, c->pair.start.state, c->pair.fine.state, &position, &velocity);
  const double u = c->pair.coarse.closing.speed;
  const double speed = (u > 0.0) ? u : velocity;
  const double until = world_time(c->run.w) + c->run.near / speed;
  if (c->hit_until <= world_time(c->run.w) - h || velocity > c->hit_jump) {
    c->hit_jump = velocity;
  }
  c->hit_until = (speed > 0.0) ? fmax(c->hit_until, until) : c->hit_until;
}

/* A time that speeds may be asked at: what may be on its other side. */
static base_status note_jump(controlled *c, double at, base_error *err) {
  bool asked = false;
  for (int k = 0; k < c->rule->n_speed_at; k++) {
    asked = asked || fabs(c->rule->speed_at[k] - at) <= c->rule->least;
  }
  if (!asked) {
    return BASE_OK;
  }
  double speed;
  BASE_TRY(world_nearing(c->run.w, c->run.near, &speed, err));
  const double yet = (at <= c->hit_until) ? c->hit_jump : 0.0;
  c->account->jump = fmax(c->account->jump, fmax(2.0 * speed, yet));
  return BASE_OK;
}

/* The step just tried is kept. */
static base_status keep(controlled *c, double h, double e, base_error *err) {
  step_account *a = c->account;
  const bool changed = changes(c);
  a->forced += e > 1.0;
  a->changed += changed && c->kept->n > 0;
  a->located = fmax(a->located, c->located);
  a->jump = fmax(a->jump, fmax(c->passed, fmax(c->slipped, c->late_speed)));
  a->doubt = fmax(a->doubt, c->pair.fine.doubt * reach(c));
  BASE_TRY(keep_law(c, h, err));
  a->off += c->off;
  a->plain += c->plain;
  note_way(c, h, changed);
  if (changed && c->kept->n > 0) {
    note_hit(c, h);
  }
  c->failed = !c->pair.fine.good;
  c->carrying = c->pair.fine.carrying;
  const bool extrapolated = c->smooth && e <= 1.0;
  const unsigned met = changed ? STEP_MET : 0;
  step_pair_keep(&c->pair, &c->run, h, extrapolated && !changed);
  if (extrapolated) {
    BASE_TRY(step_pair_extrapolate(&c->pair, &c->run, c->record, err));
    return count(c, h, STEP_EXTRAPOLATED | met, err);
  }
  BASE_TRY(count(c, 0.5 * h, 0, err));
  return count(c, 0.5 * h, met, err);
}

/* A longer step that met something, where a shorter one did not, is tried again after 2, 4, 8... steps: until what it met is passed, or
 * for good where it is the length that meets it. */
static bool may_grow(controlled *c, bool met) {
  const bool changed = changes(c);
  if (changed) {
    c->longer = patience_untried();
  } else if (met) {
    patience_lose(&c->longer);
  }
  return changed || patience_again(&c->longer);
}

/* Do contacts hold in one of the steps just tried and slip in another, while something turns? The first step from an extrapolated state has
 * other normal forces than the next one then, by what holds a body on its curved way, and may hold or let slip what the next one does not. */
static bool mixed(const controlled *c, double h) {
  return modes_differ(c) && c->rule->extrapolate && !c->run.turned && !changes(c) &&
         world_turns(c->run.w, h);
}

/* Both ways over h, or the coarse one alone where that tells that the step is too long. */
static base_status both_ways(controlled *c, double h, bool *too_long, base_error *err) {
  sim *s = &c->run;
  BASE_TRY(step_pair_begin(&c->pair, s, c->record, c->carrying, h, err));
  *too_long = foreseen(c, h);
  return *too_long ? BASE_OK : step_pair_finish(&c->pair, s, c->record, h, err);
}

/* The same with contacts that turn in the steps from the first time on that it matters, until others carry. */
static base_status try_pair(controlled *c, double h, bool *too_long, base_error *err) {
  sim *s = &c->run;
  s->near = c->account->off + event_share * tolerance_of(c);
  BASE_TRY(both_ways(c, h, too_long, err));
  if (!*too_long && mixed(c, h) && c->pair.solved + 3 <= c->rule->limit) {
    BASE_TRY(step_pair_undo(&c->pair, s, c->record, err));
    s->turned = true;
    BASE_TRY(both_ways(c, h, too_long, err));
  }
  return BASE_OK;
}

/* Is the step just tried one of an even acceleration, so that two sides that come into each other at this speed and part again do so without an
 * impact? What contacts give at once would show. Of the first step nothing was known before. */
static bool is_even(const controlled *c, double h, double speed) {
  static const double slight = 0.05;
  return (!changes(c) || c->kept->n == 0) && c->bend < slight * speed * h;
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
  BASE_TRY(world_first_touch(w, h, c->pair.start.state, shallow(c), at, &passed, err));
  if (c->smooth) {
    world_load(w, c->pair.fine.state);
  }
  const double share = fmax(h / c->run.q->duration, event_share);
  c->passed = is_even(c, h, passed) ? 2.0 * passed : 0.0;
  const double missed = c->passed * (reach(c) + h);
  const double deeper = fmax(depth - c->pair.coarse.start, missed);
  c->located = fmax(c->located, deeper);
  *e = fmax(*e, deeper / share / tolerance_of(c));
  return BASE_OK;
}

/* The longest step beside what grows off a steady turning, which no step sees: a share of it is off by as much as the steps of the run are of
 * what they see. */
static double beside_growth(const controlled *c) {
  return fmin(1.0, 2.0 * sqrt(tolerance_of(c) / way(c))) * step_beside_growth(c->run.w);
}

/* The length of a step in the place of one of h behind which a steady turning is so much faster that what is off it has grown by more than a
 * step may see; HUGE_VAL: it is not. */
static double spun_up(const controlled *c, double h) {
  static const double spare = 1.5;
  const double longest = beside_growth(c);
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
  if (!c->rule->extrapolate || changes(c) || !world_sides_touch(w)) {
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
  const double late = ends ? 0.5 * swerve * (reach(c) + h) : 0.0;
  c->located = fmax(c->located, late);
  c->off = fmax(c->off, late);
  *at = (late > tolerance_of(c) * fmax(h / s->q->duration, event_share)) ? fmin(*at, 0.5 * h) : *at;
  return BASE_OK;
}

/* Error over the share of the step of h just tried; *at: when something happens in it that neither of its ends tells of, h or more: nothing
 * does. */
static base_status judge(controlled *c, double h, aim aimed, double *e, double *at,
                         base_error *err) {
  *at = HUGE_VAL;
  if (*e <= 1.0) {
    BASE_TRY(look_back(c, h, e, at, err));
    const double gives_way = fmin(break_away_in(c->pair.load, h).at, opens(c, h));
    *at = has_aimed(c, h, aimed) ? *at : fmin(*at, gives_way);
    *at = fmin(*at, spun_up(c, h));
    BASE_TRY(look_ahead(c, h, at, err));
  }
  return BASE_OK;
}

/* From when on friction may have given way unseen, once the step of h just tried is kept: what is foreseen begins to slip by up to `slow` of the
 * time too late, as slips of rounding are none. */
static void note_held(controlled *c, double h, aim aimed) {
  static const double slow = 1e-4;
  const double now = world_time(c->run.w);
  c->sure_until = (aimed == AIM_SLIP) ? (1.0 + slow) * now : c->sure_until;
  c->unseen_for = (now <= c->sure_until) ? 0.0 : 0.5 * h;
}

/* Keeps the step of *h just tried, which was off by e over its share; *h is then the proposal for the next. met: a longer one was tried that met
 * something. */
static base_status take(controlled *c, double *h, double e, bool met, aim aimed, base_error *err) {
  const double taken = *h;
  openings_note(&c->opening, aimed == AIM_OPENING, changes(c));
  note_held(c, taken, aimed);
  BASE_TRY(keep(c, taken, e, err));
  c->run.turned = c->run.turned && !changes(c);
  *h = next_length(c, taken, e);
  *h = may_grow(c, met) ? *h : fmin(*h, taken);
  c->strides = c->rule->extrapolate && changes(c) && c->stride > *h && patience_again(&c->onward);
  if (c->strides) {
    *h = c->stride; /* behind an impact the motion is as smooth as before it */
    c->stride = 0.0;
  }
  return BASE_OK;
}

/* The length to try in the place of h: `at` where nothing but what happens there is against it (e 0), otherwise what its error e asks for. */
static double retried(const controlled *c, double h, double e, double at, aim *aimed) {
  if (e > 0.0) {
    return fmax(again(c, h, e, aimed), c->rule->least);
  }
  const break_away slip = break_away_in(c->pair.load, h);
  if (at == slip.at) {
    *aimed = slip.told ? AIM_SLIP : AIM_BEFORE_SLIP;
  } else if (at == opens(c, h)) {
    *aimed = AIM_OPENING;
  }
  return fmax(at, c->rule->least);
}

/* Tries steps from *h downwards until one is kept; *h is then the proposal for the next, *taken what was kept. */
static base_status step(controlled *c, double *h, bool *limited, double *taken, base_error *err) {
  const step_rule *rule = c->rule;
  const bool strides = c->strides;
  bool met = false;
  aim aimed = AIM_NOTHING;
  c->strides = false;
  for (;;) {
    double at;
    bool too_long;
    if (c->account->solved + 4 > rule->limit || sim_due(&c->run)) {
      *limited = true;
      return BASE_OK;
    }
    BASE_TRY(try_pair(c, *h, &too_long, err));
    c->account->solved = c->pair.solved;
    double e = too_long ? HUGE_VAL : error_of(c, *h);
    BASE_TRY(judge(c, *h, aimed, &e, &at, err));
    const bool passes = e <= 1.0 && at < *h;
    if ((e <= 1.0 && !passes) || *h <= rule->least) {
      c->onward = (strides && !met) ? patience_untried() : c->onward;
      *taken = *h;
      return take(c, h, e, met, aimed, err);
    }
    c->account->rejected++;
    if (strides && !met && !too_long) {
      patience_lose(&c->onward);
    }
    met = met || too_long || changes(c);
    if (met && c->stride == 0.0) {
      c->stride = *h;
    }
    BASE_TRY(step_pair_undo(&c->pair, &c->run, c->record, err));
    *h = retried(c, *h, passes ? 0.0 : e, at, &aimed);
  }
}

/* ---- the run --------------------------------------------------------------------------------- */

/* The part of the way to the next stop that a step of about h may take: all of it, or about half. Not half where the steps are
 * extrapolated: halves of halves would be the same steps in two runs, and what happens unseen in one of them as well. */
static double towards(const controlled *c, double left, double h) {
  const double half = c->rule->extrapolate ? 0.55 : 0.5;
  return (h >= left - c->rule->least) ? left : fmin(h, half * left);
}

/* Is the run at the end of this way where it was at its start, and at rest? */
static bool has_stayed(const controlled *c, const step_end *end, double h) {
  static const double still = 1e-6; /* of the tolerance */
  double position;
  double velocity;
  world_saved_distance(c->run.w, c->pair.start.state, end->state, &position, &velocity);
  return end->good && position + velocity * h <= still * tolerance_of(c);
}

/* What rests and nothing moves in one step over all of the run stays where it is all the while, whatever times steps are to end at. */
static base_status stay(controlled *c, bool *stays, base_error *err) {
  sim *s = &c->run;
  const double h = s->q->duration;
  *stays = false;
  if (!c->rule->rests || c->rule->limit < 3) {
    return BASE_OK;
  }
  BASE_TRY(step_pair_begin(&c->pair, s, c->record, c->carrying, h, err));
  if (has_stayed(c, &c->pair.coarse, h)) {
    BASE_TRY(step_pair_finish(&c->pair, s, c->record, h, err));
    *stays = has_stayed(c, &c->pair.fine, h);
  }
  c->account->solved = c->pair.solved;
  return *stays ? keep(c, h, error_of(c, h), err) : step_pair_undo(&c->pair, s, c->record, err);
}

/* At this pace the limit of work is far from enough: a fiftieth of it is spent, and ten times all of it would not do. */
static bool crawls(const controlled *c) {
  const double limit = (double)c->rule->limit;
  const double spent = (double)c->account->solved;
  const double way = world_time(c->run.w) / c->run.q->duration;
  return spent > 0.02 * limit && spent > 10.0 * limit * way;
}

static base_status run_to(controlled *c, double stop, double *h, bool *limited, base_error *err) {
  sim *s = &c->run;
  const double slack = 0.5 * c->rule->least;
  while (!*limited && !c->failed && !sim_hopeless(s) && world_time(s->w) < stop - slack) {
    const double wish = fmin(fmin(*h, c->rule->most), beside_growth(c));
    double next = towards(c, stop - world_time(s->w), wish);
    const double asked = next;
    double taken = 0.0;
    BASE_TRY(step(c, &next, limited, &taken, err));
    if (!*limited) {
      /* a step cut short to end at a stop says nothing against the longer one */
      *h = (taken == asked && asked < wish) ? fmax(wish, next) : next;
      *limited = crawls(c);
    }
  }
  return *limited ? BASE_OK : note_jump(c, stop, err);
}

/* One step of h unless the run is over or has solved its share. */
static base_status even_step(controlled *c, double h, bool *limited, base_error *err) {
  sim *s = &c->run;
  bool taken;
  *limited = c->account->solved >= c->rule->limit || sim_due(&c->run);
  if (*limited || world_time(s->w) >= s->q->duration) {
    return BASE_OK;
  }
  BASE_TRY(sim_step(s, c->record, h, &taken, err));
  c->account->solved++;
  *limited = !taken && !sim_hopeless(s);
  if (*limited) {
    return BASE_OK;
  }
  BASE_TRY(count(c, h, 0, err));
  c->account->gain = HUGE_VAL; /* nobody looked */
  return BASE_OK;
}

static base_status run_even(controlled *c, bool *limited, base_error *err) {
  double at = 0.0;
  for (int k = 0; k < c->rule->n_stop; k++) {
    const double span = c->rule->stop[k] - at;
    const long n = lround(ceil(span / c->rule->first - SIM_LAST_STEP));
    at = c->rule->stop[k];
    for (long i = 0; i < n && !*limited && !sim_hopeless(&c->run); i++) {
      BASE_TRY(even_step(c, span / (double)n, limited, err));
    }
  }
  return BASE_OK;
}

static base_status run(controlled *c, base_error *err) {
  sim *s = &c->run;
  bool limited = false;
  BASE_TRY(run_places_open(c->places, s->w, err));
  if (s->q->form->form->memory == 0) {
    BASE_TRY(run_even(c, &limited, err));
  } else {
    BASE_TRY(step_pair_open(&c->pair, s, err));
    BASE_TRY(step_pair_open(&c->ahead, s, err));
    s->controlled = true;
    s->presses = (s->q->effects & EFFECT_LOADS) != 0 && spec_loads_vary(s->q->spec);
    openings_begin(&c->opening, s->presses);
    c->carrying = s->carrying;
    c->fastest = world_max_speed(s->w);
    double h = c->rule->first;
    bool stays;
    BASE_TRY(stay(c, &stays, err));
    for (int k = 0; k < c->rule->n_stop && !stays; k++) {
      BASE_TRY(run_to(c, c->rule->stop[k], &h, &limited, err));
    }
  }
  c->account->ended = !limited && !c->failed && !sim_hopeless(s);
  sim_finish(s, c->record);
  return BASE_OK;
}

base_status simulate_controlled(const sim_request *q, const step_rule *rule, series *record,
                                sim_result *out, step_list *kept, run_places *places,
                                step_account *account, base_error *err) {
  controlled c = {.rule = rule,
                  .longer = patience_untried(),
                  .onward = patience_untried(),
                  .record = record,
                  .kept = kept,
                  .places = places,
                  .account = account,
                  .last = 1.0};
  kept->n = kept->n_turned = kept->n_extrapolated = 0;
  *account = (step_account){.least = HUGE_VAL};
  base_status done = sim_open(&c.run, q, record, out, err);
  if (done == BASE_OK) {
    done = run(&c, err);
  }
  step_pair_close(&c.pair);
  step_pair_close(&c.ahead);
  free(c.law);
  sim_close(&c.run);
  return done;
}
