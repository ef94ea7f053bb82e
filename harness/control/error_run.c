#include "harness/control/error_run.h"

#include "harness/control/error_ladder.h"
#include "harness/util/stop.h"

#include <stdlib.h>
#include <string.h>

/* Of the step at which an explicit spring runs away: a sixth of its period. */
static const double spring_step = 0.5;
/* Of the period of a load: no halving of it, nor of what a run takes, falls on its zeros alone. */
static const double swing_step = 1.0 / 6.3;
/* Of how far points may come, what the first run is measured by to begin with. */
static const double point_share = 1e-3;
/* Of the fall of the difference that two orders of convergence stand for, this share shows them; of no fall, that runs converge. */
static const double shown = 0.75;

/* ---- runs ------------------------------------------------------------------------------------ */

static void refuse(error_result *r, const char *why) {
  r->promised = false;
  (void)snprintf(r->reason, sizeof r->reason, "%s", why);
}

/* Largest difference of two runs, over E [1]. */
static double largest_change(const error_result *r, const error_made *now,
                             const error_made *before) {
  double most = 0.0;
  for (int i = 0; i < now->n_quantity; i++) {
    const double change =
        (i < before->n_quantity) ? error_made_difference(now, before, i) : HUGE_VAL;
    const double over = change / (error_unit(&r->asked, &now->quantity[i]) * r->asked.E);
    most = fmax(most, (over == over) ? over : HUGE_VAL);
  }
  return most;
}

/* What an extreme over a time may be off by because no state is there, in its unit: of the length of a velocity, for the straight way from one state
 * to the next is nearer to the origin than both; of one of a place, and of what an even acceleration may be beyond the states, the record
 * tells. */
static double unseen(const error_result *r, const error_quantity *e) {
  const double far = r->level[r->n_level - 1].account.gain;
  const double nearest = e->extreme.nearest;
  return fmax((nearest < HUGE_VAL) ? extreme_nearer(far, nearest) : 0.0, e->extreme.beyond);
}

/* A speed that points of bodies are off by [m/s] in the unit of a quantity; 0: that is no speed. */
static double as_speed(const error_made *m, const error_quantity *e, double speed) {
  const bool turns = strcmp(e->unit, "rad/s") == 0;
  return (turns || strcmp(e->unit, "m/s") == 0) ? speed / (turns ? m->places.size : 1.0) : 0.0;
}

/* What a speed is off by where an impact may be on the other side of the time that it is asked for, in its unit. */
static double jumped(const error_result *r, const error_made *m, const error_quantity *e) {
  return as_speed(m, e, r->level[r->n_level - 1].account.jump);
}

/* Of a speed behind bounces, in its unit: runs that do not tell at which of them a body is may be near each other by chance, but hardly twice in
 * a row. */
static double slipped(const error_result *r, const error_made *before, int i,
                      const error_quantity *e, double change) {
  static const double near = 1.0 / 16.0;
  const double first = (i < before->n_quantity) ? before->quantity[i].change : HUGE_VAL;
  const bool twice = fmax(first, change) <= near * e->leap;
  const bool told = r->level[r->n_level - 2].account.off <= e->known;
  return (e->leap > 0.0 && !told && !twice) ? e->leap : 0.0;
}

/* Estimates from two runs of which the later one is `finer` times as good, and off by `least` over E at least. */
static void estimate(error_result *r, error_made *now, const error_made *before, double finer,
                     double least) {
  error_level *level = &r->level[r->n_level - 1];
  r->estimate = 0.0;
  for (int i = 0; i < now->n_quantity; i++) {
    error_quantity *e = &now->quantity[i];
    const double change =
        (i < before->n_quantity) ? error_made_difference(now, before, i) : HUGE_VAL;
    const double told = ERROR_SAFETY * change / (finer - 1.0);
    const double slip = slipped(r, before, i, e, change);
    const double seen = fmax(unseen(r, e), jumped(r, now, e));
    level->slips = fmax(level->slips, (slip > 0.0) ? level->account.off / e->known : 0.0);
    e->change = change;
    const double unit = error_unit(&r->asked, e);
    const double known = fmax(least * r->asked.E * unit, seen);
    const double off = (told < known) ? known : told;
    e->estimate = (off < slip) ? slip : off;
    level->known = fmax(level->known, (off == off) ? off / (unit * r->asked.E) : HUGE_VAL);
    const double over = e->estimate / unit;
    r->estimate = fmax(r->estimate, (over == over) ? over : HUGE_VAL);
  }
}

/* E as a length: what a step may be off [m]. Of turning, that of a point as far out as the smallest body is large: `scale` is that then. */
static double length_of(const sim_request *q, const error_asked *a, double scale) {
  if (strcmp(a->unit, "m") == 0) {
    return a->E;
  }
  if (strcmp(a->unit, "m/s") == 0) {
    return a->E * q->duration;
  }
  if (strcmp(a->unit, "rad/s") == 0) {
    return a->E * q->duration * scale;
  }
  return a->E * scale;
}

/* Did the last three refinements leave the difference as it was, which says nothing of runs that are at other bounces? */
static bool diverges(const error_result *r) {
  bool same = r->n_level > r->first_level + 4;
  for (int k = r->n_level - 1; same && k >= r->n_level - 3; k--) {
    same = r->level[k].change > shown * r->level[k - 1].change && r->level[k].slips == 0.0;
  }
  return same;
}

/* Does the scene have friction at rest that the formulation has not? */
static bool lacks_static(const sim_request *q) {
  const spec_coefficient *kinetic = &q->spec->friction_kinetic;
  const bool less = kinetic->dflt >= 0.0 && kinetic->dflt < q->spec->friction.dflt;
  const bool two = less || kinetic->n_pair > 0;
  return two && (q->form->form->model & FORM_PENALTY) != 0 && (q->effects & EFFECT_FRICTION) != 0;
}

/* What a run has to say for itself before it is compared with others; false: it is the last. */
static bool complete(error_result *r, const error_level *l, const sim_request *q,
                     const sim_result *out, bool more) {
  if (out->status != RUN_OK) {
    char why[200];
    (void)snprintf(why, sizeof why, "a step is %s: %.150s", run_status_name(out->status),
                   out->note);
    refuse(r, why);
    return false;
  }
  if (!out->verified) {
    refuse(r, "a solve is off by more than the tolerance of its kind");
    return false;
  }
  if (more) {
    refuse(r, "the scene asks for more quantities than are watched");
    return false;
  }
  if (lacks_static(q)) {
    r->other_law = true;
    refuse(r, "the formulation's friction has no static coefficient, and the scene's has one");
    return false;
  }
  if (!l->account.ended) {
    refuse(r, (stop_requested() != 0)      ? "a signal came first"
              : error_late(&r->asked, 0.0) ? "the limit of time comes first"
                                           : "the limit of work comes first");
    return false;
  }
  if ((q->form->form->model & FORM_PENALTY) != 0 && l->account.came > 0) {
    r->other_law = true;
    refuse(r, "contacts come or go, and how they do is by the formulation's own stiffness");
    return false;
  }
  return true;
}

typedef struct climber {
  const sim_request *q;
  error_result *result;
  error_ladder ladder;
  error_made now, before;
  double off_before;   /* what the run before the last is off by, over E, as far as is known [1] */
  double ratio_before; /* of tolerances, of the two runs before the last */
  double
      missed; /* by how much the last run misses a law, over what that allows; 0: not, or its error is more than E yet [1] */
  char law[200];    /* which */
  double *stop;     /* of the last run; owned */
  double *speed_at; /* n_speed_at times that speeds are asked at; owned */
  int n_speed_at;
  sim_times spent; /* by all runs */
} climber;

/* What E is as a length in the last run [m]. */
static double length_now(const climber *l) {
  const run_places *p = &l->now.places;
  return length_of(l->q, &l->result->asked, l->now.turns ? p->size : run_places_length(p));
}

static base_status one_run(climber *l, base_error *err) {
  error_result *r = l->result;
  error_level *level = &r->level[r->n_level];
  error_made_close(&l->before);
  l->before = l->now;
  l->now = (error_made){0};
  error_made *m = &l->now;
  BASE_TRY(error_stops(l->q, (int)lround(ceil(l->ladder.parts)), &l->before, &l->stop,
                       &l->ladder.rule.n_stop, err));
  l->ladder.rule.stop = l->stop;
  l->ladder.rule.speed_at = l->speed_at;
  l->ladder.rule.n_speed_at = l->n_speed_at;
  l->ladder.rule.limit = r->asked.limit - r->solved;
  BASE_TRY(simulate_controlled(l->q, &l->ladder.rule, &m->record, &m->out, &m->kept, &m->places,
                               &level->account, err));
  r->n_level++;
  r->solved += level->account.solved;
  level->tolerance = l->ladder.rule.tolerance =
      fmax(l->ladder.rule.tolerance, level->account.tolerance);
  l->ladder.rule.of_travel = 0.0;
  level->seconds = sim_total_seconds(&m->out);
  level->change = HUGE_VAL;
  level->known = level->slips = 0.0;
  sim_times_add(&l->spent, &m->out.time);
  BASE_TRY(error_made_read(l->q, &r->asked, m, err));
  return (m->n_quantity > 0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL, "--error: the scene is asked for nothing in %s",
                         r->asked.unit);
}

/* What goes with the order of impacts that the last run does not tell: over E [1]. */
static double doubted(const climber *l) {
  return l->result->level[l->result->n_level - 1].account.doubt / length_now(l);
}

/* What friction that is not Coulomb's moves bodies by, and makes of what is asked of speeds, which no step mends: over E [1]. */
static double law_of(const climber *l, const error_level *level) {
  const error_made *m = &l->now;
  double most = (level->account.law + level->account.left) / length_now(l);
  for (int i = 0; i < m->n_quantity; i++) {
    const double speed = as_speed(m, &m->quantity[i], level->account.law_speed);
    const double E = l->result->asked.E * error_unit(&l->result->asked, &m->quantity[i]);
    most = fmax(most, speed / E);
  }
  return most;
}

/* That of the last run, over E [1]. */
static double bent(const climber *l) {
  return law_of(l, &l->result->level[l->result->n_level - 1]);
}

/* What an impact is off by in the last run, and two runs may have in common, or the law is: over E [1]. */
static double located(const climber *l) {
  const step_account *a = &l->result->level[l->result->n_level - 1].account;
  return fmax(a->located / length_now(l), fmax(doubted(l), bent(l)));
}

/* Did no contact begin or cease to carry in the last run? */
static bool unchanged(const climber *l) {
  return l->result->level[l->result->n_level - 1].account.changed == 0;
}

/* Was the run exact, as far as its steps tell? One run is not enough where contacts come or go, for other impacts may have been missed. A window or
 * a drift looks at states between its own, which are off a chord. */
static bool as_if_exact(climber *l) {
  error_result *r = l->result;
  const step_account *a = &r->level[r->n_level - 1].account;
  const double off = a->off / length_now(l);
  if (!l->ladder.rule.extrapolate || !l->now.at_stops || a->forced > 0 || !unchanged(l) ||
      !(off <= ERROR_EXACT)) {
    return false;
  }
  const double bow = l->now.between ? ERROR_SAFETY * a->bow : 0.0;
  r->estimate = r->asked.E * fmax(fmax(off / ERROR_EXACT, located(l)), bow / length_now(l));
  for (int i = 0; i < l->now.n_quantity; i++) {
    const error_quantity *e = &l->now.quantity[i];
    const double more = fmax(jumped(r, &l->now, e), unseen(r, e));
    r->estimate = fmax(r->estimate, more / error_unit(&r->asked, e));
  }
  for (int i = 0; i < l->now.n_quantity; i++) {
    error_quantity *e = &l->now.quantity[i];
    e->estimate = r->estimate * error_unit(&r->asked, e);
  }
  return r->estimate <= r->asked.E;
}

/* How much better the last run is than the one before. Extrapolated steps: first order in the step is counted on, second where no contact
 * begins or ceases to carry and three runs show it, or the steps of the run do: together they are off by that much less, and by
 * no more than E. An impact is off by as much as it is late: three runs over one that seem of second order are near each other by chance. */
static double finer_by(const climber *l) {
  static const double nearly = 3.0, shows = 10.0; /* E: what is farther off is of no order yet */
  const error_result *r = l->result;
  const error_level *level = &r->level[r->n_level - 1];
  const bool changes = r->n_level > r->first_level + 2 && unchanged(l) && level->change <= shows &&
                       level[-1].change >= shown * l->ratio_before * level->change;
  const bool steps = unchanged(l) && level->change <= nearly &&
                     level->account.off <= length_now(l) &&
                     level[-1].account.off >= shown * l->ladder.ratio * level->account.off;
  return error_ladder_gain(&l->ladder, changes || steps);
}

/* What the last run is off by, over E, as far as is known. */
static double known_off(const climber *l) {
  const error_result *r = l->result;
  const error_level *level = &r->level[r->n_level - 1];
  return (r->n_level > r->first_level + 1) ? level->known : level->account.off / length_now(l);
}

/* What the last run is off by at least, by what the one before is off by: over impacts it is better than that by the ratio of tolerances
 * at most, which is second order for extrapolated steps, however near the two are to each other. The ratio is chosen so that this is E:
 * rounding must not decide. Over E; 0: nothing is known. */
static double fallen(const climber *l) {
  return (l->off_before < HUGE_VAL && !unchanged(l))
             ? l->off_before / (error_ladder_gain(&l->ladder, true) * (1.0 + 1e-12))
             : 0.0;
}

/* Is it the last run of its kind that keeps E? A law that plain steps keep to rounding, as a midpoint rule keeps the energy, is kept to the
 * order of the extrapolation only: a quarter of what is missed takes twice the steps. Plain steps of first order that keep E take as many
 * times these as they would be E off; where that is more the extrapolated ones go on. */
static bool arrived(climber *l) {
  error_result *r = l->result;
  if (!r->promised || l->ladder.steps != ERROR_EXTRAPOLATED) {
    return r->promised;
  }
  l->missed = error_made_misses(l->q, &l->now, l->law, sizeof l->law);
  const double plain = r->level[r->n_level - 1].account.plain / length_now(l);
  r->promised = !(l->missed > 0.0);
  return r->promised || !(sqrt(l->missed) < plain);
}

/* Does the law of friction alone make it more than E, and finer steps not less of it? */
static bool is_bent(const climber *l) {
  const error_level *level = &l->result->level[l->result->n_level - 1];
  const double now = law_of(l, level), before = law_of(l, &level[-1]);
  return bent(l) > 1.0 && (before < 2.0 * now || before == now);
}

/* Judges the run just made; false: it is the last. */
static bool go_on(climber *l) {
  error_result *r = l->result;
  error_level *level = &r->level[r->n_level - 1];
  if (!complete(r, level, l->q, &l->now.out, l->now.more)) {
    return false;
  }
  l->missed = 0.0;
  if (r->n_level == r->first_level + 1) {
    r->promised = as_if_exact(l);
    return !arrived(l);
  }
  level->change = largest_change(r, &l->now, &l->before);
  estimate(r, &l->now, &l->before, finer_by(l), fmax(located(l), fallen(l)));
  r->promised = r->estimate <= r->asked.E;
  if (arrived(l)) {
    return false;
  }
  if (l->missed > 0.0) {
    return r->n_level < r->first_level + ERROR_LEVELS;
  }
  r->other_law = is_bent(l);
  if (r->other_law) {
    refuse(r, "the friction of the formulation is not Coulomb's, by more than E");
  } else if (diverges(r)) {
    refuse(r, "runs with finer steps do not come nearer to each other");
  } else if (r->n_level == r->first_level + ERROR_LEVELS) {
    refuse(r, "the limit of refinements came first");
  }
  return r->reason[0] == '\0';
}

/* To begin with, from the scene as it stands: a length [m], the longest step that its springs bear and its loads show in [s], and whether nothing
 * moves. */
typedef struct start_sizes {
  double scale, bears;
  bool rests, points;
} start_sizes;

static base_status start_open(const sim_request *q, start_sizes *start, base_error *err) {
  world *w;
  BASE_TRY(world_open_over(&w, q->spec, q->effects, err));
  const double speed = world_max_speed(w);
  start->scale = fmax(world_size(w), speed * q->duration);
  start->bears =
      fmin(fmin(spring_step * world_longest_step(w), swing_step * world_shortest_period(w)),
           step_beside_growth(w));
  start->rests = world_may_rest(w);
  start->points = world_of_points(w);
  world_close(w);
  return BASE_OK;
}

base_status error_first_step(const sim_request *q, double *h, base_error *err) {
  start_sizes start;
  BASE_TRY(start_open(q, &start, err));
  *h = fmin(fmin(q->h, q->duration), start.bears);
  return BASE_OK;
}

base_status error_first_scale(const sim_request *q, double *scale, base_error *err) {
  start_sizes start;
  BASE_TRY(start_open(q, &start, err));
  *scale = start.scale;
  return BASE_OK;
}

/* What the last run may be off by between its states, over E [1]. */
static double between(const climber *l) {
  const error_result *r = l->result;
  double most = 0.0;
  for (int i = 0; i < l->now.n_quantity; i++) {
    const error_quantity *e = &l->now.quantity[i];
    most = fmax(most, unseen(r, e) / (error_unit(&r->asked, e) * r->asked.E));
  }
  return most;
}

static base_status climb(climber *l, error_steps steps, const start_sizes *start, base_error *err) {
  /* How far points may come says nothing of how far they do: their way alone is the scale, with the factor that `tolerance` has of others. */
  const double scale = start->points ? point_share * start->scale : start->scale;
  const double length = length_of(l->q, &l->result->asked, scale);
  const bool relative = l->result->asked.unit[0] == '\0';
  error_ladder_begin(&l->ladder, l->q, steps, length, start->bears, start->rests);
  /* how far bodies come, which may be much farther than they are large, the first run finds out on its way */
  const double of_travel = start->points ? l->ladder.rule.tolerance / length : 1.0;
  l->ladder.rule.of_travel = relative ? of_travel * l->result->asked.E : 0.0;
  l->result->first_level = l->result->n_level;
  BASE_TRY(one_run(l, err));
  while (go_on(l)) {
    l->ratio_before = l->ladder.ratio;
    l->off_before = known_off(l);
    const double slips = l->result->level[l->result->n_level - 1].slips;
    error_ladder_finer(&l->ladder, fmax(fmax(l->off_before, slips), l->missed), between(l),
                       (double)l->result->asked.limit);
    BASE_TRY(one_run(l, err));
  }
  return BASE_OK;
}

/* Did the last run that came to its end not tell the order of impacts? A step without a solution is another reason. */
static bool in_doubt(const climber *l) {
  const error_result *r = l->result;
  const bool cut = r->n_level > 1 && !r->level[r->n_level - 1].account.ended;
  return l->now.out.status == RUN_OK &&
         r->level[r->n_level - (cut ? 2 : 1)].account.doubt > length_now(l);
}

/* Keeps the limit that came first, if one did. */
static void refuse_order(error_result *r) {
  const bool limited = !r->level[r->n_level - 1].account.ended;
  char why[200];
  (void)snprintf(why, sizeof why,
                 "bodies are hit so shortly one after the other that the runs do not tell in which "
                 "order%s%.60s",
                 limited ? "; " : "", limited ? r->reason : "");
  refuse(r, why);
}

/* Is half of the work spent, or of the time? */
static bool half_spent(const error_result *r) {
  return r->solved >= r->asked.limit / 2 || error_late(&r->asked, 0.5 * r->asked.seconds);
}

/* Is the last of the extrapolated runs the answer? Otherwise `why_plain` says why not. Where half of the work is spent there is no
 * beginning anew: what keeps E and misses a law stands then. */
static bool extrapolated_stands(climber *l) {
  error_result *r = l->result;
  const bool missed = l->missed > 0.0;
  if (r->other_law) {
    return true;
  }
  if (!r->promised && in_doubt(l)) {
    refuse_order(r);
    return true;
  }
  if (r->promised || half_spent(r)) {
    if (missed) {
      r->promised = true;
      r->reason[0] = '\0';
    }
    return true;
  }
  if (missed) {
    (void)snprintf(r->why_plain, sizeof r->why_plain, "extrapolated steps miss %.160s", l->law);
  } else {
    memcpy(r->why_plain, r->reason, sizeof r->why_plain);
  }
  r->promised = false;
  r->reason[0] = '\0';
  return false;
}

/* The finest run that came to its end, or the one that failed. */
static void hand_over(climber *l, series *record, sim_result *out, step_list *kept) {
  const int last = l->result->n_level - 1;
  const bool cut = l->now.out.status == RUN_OK && !l->result->level[last].account.ended;
  error_made *m = (cut && last > 0) ? &l->before : &l->now;
  *record = m->record;
  *out = m->out;
  *kept = m->kept;
  l->result->extrapolated = kept->n_extrapolated > 0;
  m->record = (series){0};
  m->kept = (step_list){0};
  out->time = l->spent;
  l->result->n_quantity = m->n_quantity;
  l->result->quantity = m->quantity;
  m->quantity = NULL;
}

base_status error_run(const sim_request *q, const error_asked *asked, series *record,
                      sim_result *out, step_list *kept, error_result *result, base_error *err) {
  *result = (error_result){.asked = *asked, .estimate = HUGE_VAL};
  *record = (series){0};
  *kept = (step_list){0};
  start_sizes start;
  BASE_TRY(start_open(q, &start, err));
  climber l = {.q = q, .result = result};
  const error_steps steps = (q->form->form->memory != 0) ? ERROR_EXTRAPOLATED : ERROR_OWN;
  BASE_TRY(error_speed_times(q, &l.speed_at, &l.n_speed_at, err));
  base_status done = climb(&l, steps, &start, err);
  if (done == BASE_OK && steps == ERROR_EXTRAPOLATED && !extrapolated_stands(&l)) {
    done = climb(&l, ERROR_PLAIN, &start, err);
  }
  if (done == BASE_OK) {
    hand_over(&l, record, out, kept);
  }
  error_made_close(&l.now);
  error_made_close(&l.before);
  free(l.stop);
  free(l.speed_at);
  return done;
}

void error_result_close(error_result *r) {
  free(r->quantity);
  r->quantity = NULL;
  r->n_quantity = 0;
}
