/* step_control.c - drives a run: tries steps, keeps those within their share, goes on to the end. */
#include "harness/control/step_state.h"

#include <stdlib.h>

/* ---- one step -------------------------------------------------------------------------------- */

static base_status count(controlled *c, double h, unsigned way, base_error *err) {
  step_account *a = c->account;
  run_places_note(c->places, c->run.w);
  c->fastest = fmax(c->fastest, world_max_speed(c->run.w));
  a->tolerance = step_tolerance(c);
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
static base_status keep_law(controlled *c, const step_end *end, double h, base_error *err) {
  const world *w = c->run.w;
  const int n = world_n_dof(w);
  if (end->friction.bent && c->law == NULL) {
    c->law = calloc((size_t)n, sizeof *c->law);
    if (c->law == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for the velocities of %d dofs", n);
    }
  }
  for (int k = 0; end->friction.bent && k < n; k++) {
    c->law[k] += end->law[k];
  }
  const double speed = (c->law != NULL) ? world_speed_at(w, c->law) : 0.0;
  c->account->law += h * speed;
  c->account->law_speed = fmax(c->account->law_speed, speed);
  c->account->left = fmax(c->account->left, end->friction.left * step_reach(c));
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
  const bool changed = step_changes(c);
  a->forced += e > 1.0;
  a->changed += changed && c->kept->n > 0;
  a->located = fmax(a->located, c->located);
  a->jump = fmax(a->jump, fmax(c->passed, fmax(c->slipped, c->late_speed)));
  a->doubt = fmax(a->doubt, c->pair.fine.doubt * step_reach(c));
  BASE_TRY(keep_law(c, &c->pair.fine, h, err));
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

/* Do contacts hold in one of the steps just tried and slip in another, while something turns? The first step from an extrapolated state has
 * other normal forces than the next one then, by what holds a body on its curved way, and may hold or let slip what the next one does not. */
static bool mixed(const controlled *c, double h) {
  return step_modes_differ(c) && c->rule->extrapolate && !c->run.turned && !step_changes(c) &&
         world_turns(c->run.w, h);
}

/* Both ways over h, or the coarse one alone where that tells that the step is too long. */
static base_status both_ways(controlled *c, double h, bool *too_long, base_error *err) {
  sim *s = &c->run;
  BASE_TRY(step_pair_begin(&c->pair, s, c->record, c->carrying, h, err));
  *too_long = step_is_foreseen(c, h);
  return *too_long ? BASE_OK : step_pair_finish(&c->pair, s, c->record, h, err);
}

/* The same with contacts that turn in the steps from the first time on that it matters, until others carry. */
static base_status try_pair(controlled *c, double h, bool *too_long, base_error *err) {
  sim *s = &c->run;
  /* a gap is known as all steps so far are, and to the share of a step however short */
  s->near = c->account->off + step_tolerance(c) * step_share(c, 0.0);
  BASE_TRY(both_ways(c, h, too_long, err));
  if (!*too_long && mixed(c, h) && c->pair.solved + 3 <= c->rule->limit) {
    BASE_TRY(step_pair_undo(&c->pair, s, c->record, err));
    s->turned = true;
    BASE_TRY(both_ways(c, h, too_long, err));
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
  openings_note(&c->opening, aimed == AIM_OPENING, step_changes(c));
  note_held(c, taken, aimed);
  BASE_TRY(keep(c, taken, e, err));
  c->run.turned = c->run.turned && !step_changes(c);
  *h = step_next(c, taken, e);
  *h = step_may_grow(c, met) ? *h : fmin(*h, taken);
  c->strides =
      c->rule->extrapolate && step_changes(c) && c->stride > *h && patience_again(&c->onward);
  if (c->strides) {
    *h = c->stride; /* behind an impact the motion is as smooth as before it */
    c->stride = 0.0;
  }
  return BASE_OK;
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
    double e = too_long ? HUGE_VAL : step_error(c, *h);
    BASE_TRY(step_look(c, *h, aimed, &e, &at, err));
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
    met = met || too_long || step_changes(c);
    if (met && c->stride == 0.0) {
      c->stride = *h;
    }
    BASE_TRY(step_pair_undo(&c->pair, &c->run, c->record, err));
    *h = step_retried(c, *h, passes ? 0.0 : e, at, &aimed);
  }
}

/* ---- the run --------------------------------------------------------------------------------- */

/* The part of the way to the next stop that a step of about h may take: all of it, or about half. Not half where the steps are
 * extrapolated: halves of halves would be the same steps in two runs, and what happens unseen in one of them as well. */
static double towards(const controlled *c, double left, double h) {
  const double half = c->rule->extrapolate ? 0.55 : 0.5;
  return (h >= left - c->rule->least) ? left : fmin(h, half * left);
}

/* What rests and nothing moves in one step over all of the run stays where it is all the while, whatever times steps are to end at: at rest
 * at the end of a step of h, loads that are constant are balanced by its impulses, and half of these balance them in steps of h/2. Where a
 * contact begins to slide beside a body that rests, as on a belt, that is for steps to find. */
static base_status stay(controlled *c, bool *stays, base_error *err) {
  static const double still = 1e-6; /* of the tolerance */
  sim *s = &c->run;
  const step_end *end = &c->pair.coarse;
  const double h = s->q->duration;
  double position;
  double velocity;
  *stays = false;
  if (!c->rule->rests || c->rule->limit < 1) {
    return BASE_OK;
  }
  BASE_TRY(step_pair_begin(&c->pair, s, c->record, c->carrying, h, err));
  c->account->solved = c->pair.solved;
  world_saved_distance(s->w, c->pair.start.state, end->state, &position, &velocity);
  const double off = position + velocity * h;
  const bool slides = end->pushed > 0.0 || end->broke > 0.0;
  *stays = end->good && !slides && off <= still * step_tolerance(c);
  if (!*stays) {
    return step_pair_undo(&c->pair, s, c->record, err);
  }
  c->account->off = off;
  BASE_TRY(keep_law(c, end, h, err));
  return count(c, h, 0, err);
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
    const double wish = fmin(fmin(*h, c->rule->most), step_longest(c));
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
  const int before = s->active;
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
  c->account->came += c->kept->n > 0 && s->active != before;
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
