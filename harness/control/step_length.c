/* step_length.c - how long the next step is, and the next try of one. */
#include "harness/control/step_state.h"

/* PI control of a step whose error for a share that grows with it is of first order (Gustafsson 1991). */
static const double safety = 0.9, integral = 0.7, proportional = 0.4, shrink = 0.2, grow = 4.0;

double step_beside_growth(const world *w) {
  static const double part = 0.25;
  return part / world_growth_rate(w);
}

double step_longest(const controlled *c) {
  return fmin(1.0, 2.0 * sqrt(step_tolerance(c) / step_way(c))) * step_beside_growth(c->run.w);
}

double step_to_impact(const controlled *c, double h) {
  static const double most = 1.8; /* of when it closes */
  const sim_closing *closing = &c->pair.coarse.closing;
  const bool met = c->rule->extrapolate && closing->at < HUGE_VAL;
  return met ? fmin(closing->at + step_shallow(c) / closing->speed, most * closing->at) : h;
}

bool step_is_foreseen(const controlled *c, double h) {
  const step_end *coarse = &c->pair.coarse;
  const double share = step_tolerance(c) * step_share(c, h);
  return coarse->good && h > c->rule->least && step_to_impact(c, h) < 0.9 * h &&
         coarse->closing.deep > share;
}

double step_opens(const controlled *c, double h) {
  return (c->opening.asked && !step_changes(c)) ? opening_in(c->pair.load, h).at : HUGE_VAL;
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
  const bool met = step_changes(c);
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

/* The length to try in the place of h, which was off by e over its share; twice in a row none is aimed at where friction stops. */
static double again(const controlled *c, double h, double e, aim *aimed) {
  const double impact = step_to_impact(c, h);
  if (impact < 0.9 * h) {
    *aimed = AIM_NOTHING;
    return impact;
  }
  const double rest = (*aimed == AIM_NOTHING) ? to_rest(c, h) : 0.0;
  *aimed = (rest > 0.0) ? AIM_REST : AIM_NOTHING;
  return (rest > 0.0) ? rest : h * shorter(c, e);
}

double step_next(controlled *c, double h, double e) {
  const double now = fmin(fmax(e, 1e-6), 1.0); /* a forced one says nothing of the next */
  const double order = c->smooth ? 0.5 : 1.0;
  const double factor = safety * pow(now, -order * integral) * pow(c->last, order * proportional);
  c->last = now;
  return fmax(h * ((e > 1.0) ? grow : fmin(fmax(factor, shrink), grow)), c->rule->least);
}

bool step_may_grow(controlled *c, bool met) {
  const bool changed = step_changes(c);
  if (changed) {
    c->longer = patience_untried();
  } else if (met) {
    patience_lose(&c->longer);
  }
  return changed || patience_again(&c->longer);
}

double step_retried(const controlled *c, double h, double e, double at, aim *aimed) {
  if (e > 0.0) {
    return fmax(again(c, h, e, aimed), c->rule->least);
  }
  const break_away slip = break_away_in(c->pair.load, h);
  if (at == slip.at) {
    *aimed = slip.told ? AIM_SLIP : AIM_BEFORE_SLIP;
  } else if (at == step_opens(c, h)) {
    *aimed = AIM_OPENING;
  }
  return fmax(at, c->rule->least);
}
