#include "harness/control/error_run.h"

#include "harness/measure/check_eval.h"
#include "harness/measure/predictions.h"
#include "lcp/base/fields.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

/* Ratio of the tolerances of one run and the next. */
static const double least_ratio = 2.0, most_ratio = 64.0;
static const double first_step = 1.0 / 8.0; /* longest of the first run, over its duration */
/* Tolerances of the first two runs, which show the way, over E; later ones are chosen so that the estimate is `aim` E. */
static const double first_tolerance = 256.0, second_tolerance = 64.0, aim = 0.7;
/* Two refinements in a row after which more than this of the difference is left: the runs do not converge. */
static const double no_nearer = 0.8;

/* ---- what was asked -------------------------------------------------------------------------- */

base_status error_parse(const char *text, error_asked *out, base_error *err) {
  static const char *const units[] = {"", "%", "m", "m/s", "rad", "rad/s", "J", "N s", "N m s"};
  char number[64];
  size_t n = strlen(text);
  /* the unit is what stands behind the last digit or point */
  while (n > 0 && !isdigit((unsigned char)text[n - 1]) && text[n - 1] != '.') {
    n--;
  }
  const char *unit = text + n + strspn(text + n, " ");
  bool known = false;
  for (int i = 0; i < BASE_COUNT(units); i++) {
    known = known || strcmp(unit, units[i]) == 0;
  }
  *out = (error_asked){.limit = ERROR_LIMIT};
  (void)snprintf(number, sizeof number, "%.*s", (int)n, text);
  if (n >= sizeof number || !known || !base_parse_real(number, &out->E) || !(out->E > 0.0)) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "--error %.60s: need a number above 0, alone, with %% or with a unit (m m/s "
                     "rad rad/s J)",
                     text);
  }
  if (strcmp(unit, "%") == 0) {
    out->E *= 0.01;
  } else {
    (void)snprintf(out->unit, sizeof out->unit, "%s", unit);
  }
  return BASE_OK;
}

static const char all_places[] = "places of all bodies at the end";

/* ---- quantities of a run --------------------------------------------------------------------- */

/* A run and what was read from it. */
typedef struct made {
  series record;
  sim_result out;
  step_list kept;
  run_places places;
  int n_quantity;
  error_quantity quantity[ERROR_QUANTITIES];
} made;

static void made_close(made *m) {
  series_close(&m->record);
  step_list_close(&m->kept);
  run_places_close(&m->places);
  *m = (made){0};
}

static bool holds_for(const error_asked *a, const char *unit) {
  return a->unit[0] == '\0' || strcmp(a->unit, unit) == 0;
}

/* Does this check look at a state that any step can come near to? */
static bool of_state(const spec_check *c, double duration) {
  const double last = (c->t1 > 0.0 && c->t1 < HUGE_VAL) ? fmax(c->t, c->t1) : c->t;
  return (c->kind == CHECK_STATE || c->kind == CHECK_WINDOW_MAX || c->kind == CHECK_WINDOW_MIN ||
          c->kind == CHECK_MAX_DRIFT) &&
         last <= duration * (1.0 + 1e-9);
}

static double column_range(const series *s, int column) {
  double most = 0.0;
  for (int k = 0; k < s->n_row; k++) {
    most = fmax(most, fabs(s->column[column][k] - s->column[column][0]));
  }
  return most;
}

static double column_most(const series *s, int column) {
  double most = 0.0;
  for (int k = 0; k < s->n_row; k++) {
    most = fmax(most, fabs(s->column[column][k]));
  }
  return most;
}

/* Scale of a unit, from the record of a run. */
static double scale_of(const made *m, const char *unit) {
  const series *s = &m->record;
  const run_places *p = &m->places;
  const double end = s->column[SERIES_TIME][s->n_row - 1];
  double most = 0.0;
  const bool way = strcmp(unit, "m") == 0;
  if (strcmp(unit, "rad") == 0) {
    return 1.0;
  }
  for (int i = 0; i < s->n_var; i++) {
    if (strcmp(world_observe_unit(s->var[i].var), unit) == 0) {
      const int c = s->var[i].column;
      most = fmax(most, way ? column_range(s, c) : column_most(s, c));
    }
  }
  if (way) {
    most = fmax(most, fmax(p->travel, p->size));
  } else if (strcmp(unit, "m/s") == 0) {
    most = fmax(fmax(most, column_most(s, SERIES_SPEED)), fmax(p->travel, p->size) / end);
  } else if (strcmp(unit, "rad/s") == 0) {
    most = fmax(most, 1.0 / end);
  }
  return (most > 0.0) ? most : 1.0;
}

static void add(made *m, const error_asked *asked, const char *name, const char *unit,
                double value) {
  if (m->n_quantity == ERROR_QUANTITIES || !holds_for(asked, unit)) {
    return;
  }
  error_quantity *e = &m->quantity[m->n_quantity++];
  (void)snprintf(e->name, sizeof e->name, "%s", name);
  e->unit = unit;
  e->value = value;
  e->scale = scale_of(m, unit);
  e->estimate = HUGE_VAL;
}

/* The checks of one state at one time ask once, however many formulations they are made for. */
static bool named(const made *m, const char *name) {
  for (int i = 0; i < m->n_quantity; i++) {
    if (strcmp(m->quantity[i].name, name) == 0) {
      return true;
    }
  }
  return false;
}

static void read_checks(const sim_request *q, const error_asked *asked, made *m) {
  const check_context ctx = prediction_context(q, &m->record, &m->out);
  for (int i = 0; i < q->spec->n_check; i++) {
    const spec_check *c = &q->spec->check[i];
    check_result got;
    char label[80];
    char name[112];
    if (!of_state(c, q->duration)) {
      continue;
    }
    check_evaluate(c, &ctx, &got);
    check_label(c, label, sizeof label);
    if (c->kind == CHECK_STATE) {
      (void)snprintf(name, sizeof name, "%s at %.4g s", label, c->t);
    } else {
      (void)snprintf(name, sizeof name, "%s from %.4g s", label, c->t0);
    }
    if (got.known && !named(m, name)) {
      add(m, asked, name, world_observe_unit(c->var), got.got);
    }
  }
}

static void read_quantities(const sim_request *q, const error_asked *asked, made *m) {
  read_checks(q, asked, m);
  for (int i = 0; i < q->spec->n_observe; i++) {
    spec_check c = {0};
    double value;
    char name[112];
    memcpy(c.var, q->spec->observe[i], sizeof c.var);
    const series_var *v = series_find_var(&m->record, &c);
    (void)snprintf(name, sizeof name, "%s at the end", c.var);
    if (v != NULL && series_at(&m->record, v->column, q->duration, &value) && !named(m, name)) {
      add(m, asked, name, world_observe_unit(c.var), value);
    }
  }
  if (m->n_quantity == 0) {
    add(m, asked, all_places, "m", m->places.travel);
  }
}

/* Of quantity i between two runs. */
static double difference(const made *a, const made *b, int i) {
  if (strcmp(a->quantity[i].name, all_places) != 0) {
    return fabs(a->quantity[i].value - b->quantity[i].value);
  }
  double most = 0.0;
  for (int k = 0; k < 3 * a->places.n; k++) {
    most = fmax(most, fabs(a->places.end[k] - b->places.end[k]));
  }
  return most;
}

/* ---- runs ------------------------------------------------------------------------------------ */

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a;
  const double y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Times that checks look at: a value between two rows would be a chord's. Returns how many, the last is the end. */
static int stops_of(const sim_request *q, double *stop) {
  const double end = q->duration;
  int n = 0;
  for (int i = 0; i < q->spec->n_check; i++) {
    const spec_check *c = &q->spec->check[i];
    const double at[] = {c->t, c->t0, c->t1};
    for (int k = 0; k < BASE_COUNT(at); k++) {
      if (at[k] > 1e-9 * end && at[k] < end * (1.0 - 1e-9)) {
        stop[n++] = at[k];
      }
    }
  }
  qsort(stop, (size_t)n, sizeof *stop, ascending);
  int kept = 0;
  for (int i = 0; i < n; i++) {
    if (kept == 0 || stop[i] > stop[kept - 1] + 1e-9 * end) {
      stop[kept++] = stop[i];
    }
  }
  stop[kept++] = end;
  return kept;
}

static void refuse(error_result *r, const char *why) {
  r->promised = false;
  (void)snprintf(r->reason, sizeof r->reason, "%s", why);
}

/* Compares two runs whose tolerances have this ratio: estimates, and the largest difference over E. */
static double compare(error_result *r, made *now, const made *before, double ratio) {
  const bool relative = r->asked.unit[0] == '\0';
  double most = 0.0;
  r->estimate = 0.0;
  for (int i = 0; i < now->n_quantity; i++) {
    error_quantity *e = &now->quantity[i];
    const double unit = relative ? e->scale : 1.0;
    const double change = (i < before->n_quantity) ? difference(now, before, i) : HUGE_VAL;
    e->estimate = ERROR_SAFETY * change / (ratio - 1.0);
    r->estimate = fmax(r->estimate, (e->estimate == e->estimate) ? e->estimate / unit : HUGE_VAL);
    most = fmax(most, (change == change) ? change / (unit * r->asked.E) : HUGE_VAL);
  }
  return most;
}

/* Did the last two refinements leave the difference as it was? */
static bool diverges(const error_result *r) {
  const int k = r->n_level - 1;
  return k >= 3 && r->level[k].change > no_nearer * r->level[k - 1].change &&
         r->level[k - 1].change > no_nearer * r->level[k - 2].change;
}

/* E as a length: what a step may be off [m]. */
static double length_of(const sim_request *q, const error_asked *a, double scale) {
  if (strcmp(a->unit, "m") == 0) {
    return a->E;
  }
  if (strcmp(a->unit, "m/s") == 0) {
    return a->E * q->duration;
  }
  return a->E * scale;
}

/* What a run has to say for itself before it is compared with others; false: it is the last. */
static bool complete(error_result *r, const error_level *l, const sim_result *out) {
  if (out->status != RUN_OK) {
    char why[200];
    (void)snprintf(why, sizeof why, "a step is %s: %.150s", run_status_name(out->status),
                   out->note);
    refuse(r, why);
    return false;
  }
  if (!l->account.ended) {
    refuse(r, "the limit of work comes first");
    return false;
  }
  return true;
}

typedef struct ladder {
  const sim_request *q;
  error_result *result;
  step_rule rule;
  made now, before;
  sim_times spent; /* by all runs */
} ladder;

static base_status one_run(ladder *l, base_error *err) {
  error_result *r = l->result;
  error_level *level = &r->level[r->n_level];
  made_close(&l->before);
  l->before = l->now;
  l->now = (made){0};
  made *m = &l->now;
  l->rule.limit = r->asked.limit - r->solved;
  BASE_TRY(simulate_controlled(l->q, &l->rule, &m->record, &m->out, &m->kept, &m->places,
                               &level->account, err));
  r->n_level++;
  r->solved += level->account.solved;
  level->tolerance = l->rule.tolerance;
  level->seconds = sim_total_seconds(&m->out);
  level->change = HUGE_VAL;
  sim_times_add(&l->spent, &m->out.time);
  read_quantities(l->q, &r->asked, m);
  return (m->n_quantity > 0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL, "--error: the scene is asked for nothing in %s",
                         r->asked.unit);
}

/* What an impact is off by in the last run, and two runs may have in common: over E [1]. */
static double located(const ladder *l) {
  const error_result *r = l->result;
  const double scale = fmax(l->now.places.travel, l->now.places.size);
  return r->level[r->n_level - 1].account.located / length_of(l->q, &r->asked, scale);
}

/* Judges the run just made; false: it is the last. */
static bool go_on(ladder *l, double ratio) {
  error_result *r = l->result;
  error_level *level = &r->level[r->n_level - 1];
  if (!complete(r, level, &l->now.out)) {
    return false;
  }
  if (r->n_level == 1) {
    return true;
  }
  level->change = compare(r, &l->now, &l->before, ratio);
  r->estimate = fmax(r->estimate, r->asked.E * located(l));
  r->promised = r->estimate <= r->asked.E;
  if (r->promised) {
    return false;
  }
  if (diverges(r)) {
    refuse(r, "runs with finer steps do not come nearer to each other");
  } else if (r->n_level == ERROR_LEVELS) {
    refuse(r, "the limit of refinements came first");
  }
  return r->reason[0] == '\0';
}

/* How much finer the next run is. After the first the scale of the scene is known; later the estimate tells. */
static double next_ratio(const ladder *l) {
  const error_result *r = l->result;
  if (l->q->form->form->memory == 0) {
    return least_ratio; /* their error is not of first order in the step: what two runs differ by counts whole */
  }
  if (r->n_level > 1) {
    return fmin(fmax(r->estimate / (aim * r->asked.E), least_ratio), most_ratio);
  }
  const double scale = fmax(l->now.places.travel, l->now.places.size);
  const double next = second_tolerance * length_of(l->q, &r->asked, scale);
  return fmin(fmax(l->rule.tolerance / next, least_ratio), most_ratio);
}

static base_status climb(ladder *l, base_error *err) {
  double ratio = 1.0;
  BASE_TRY(one_run(l, err));
  while (go_on(l, ratio)) {
    ratio = next_ratio(l);
    l->rule.tolerance /= ratio;
    l->rule.most /= ratio; /* or two runs that take the longest steps would be one */
    l->rule.first = fmin(l->rule.first, l->rule.most);
    BASE_TRY(one_run(l, err));
  }
  return BASE_OK;
}

base_status error_first_scale(const sim_request *q, double *scale, base_error *err) {
  world *w;
  BASE_TRY(world_open(&w, q->spec, q->effects, err));
  *scale = fmax(world_size(w), world_max_speed(w) * q->duration);
  world_close(w);
  return BASE_OK;
}

/* The finest run that came to its end, or the one that failed. */
static void hand_over(ladder *l, series *record, sim_result *out, step_list *kept) {
  const int last = l->result->n_level - 1;
  const bool cut = l->now.out.status == RUN_OK && !l->result->level[last].account.ended;
  made *m = (cut && last > 0) ? &l->before : &l->now;
  *record = m->record;
  *out = m->out;
  *kept = m->kept;
  m->record = (series){0};
  m->kept = (step_list){0};
  out->time = l->spent;
  l->result->n_quantity = m->n_quantity;
  memcpy(l->result->quantity, m->quantity, sizeof m->quantity);
}

base_status error_run(const sim_request *q, const error_asked *asked, series *record,
                      sim_result *out, step_list *kept, error_result *result, base_error *err) {
  *result = (error_result){.asked = *asked, .estimate = HUGE_VAL};
  *record = (series){0};
  *kept = (step_list){0};
  double scale;
  BASE_TRY(error_first_scale(q, &scale, err));
  double *stop = calloc(3 * (size_t)q->spec->n_check + 1, sizeof *stop);
  if (stop == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the times of the checks");
  }
  ladder l = {.q = q, .result = result};
  const double longest = first_step * q->duration;
  l.rule = (step_rule){.tolerance = first_tolerance * length_of(q, asked, scale),
                       .first = (q->form->form->memory == 0) ? longest : fmin(q->h, longest),
                       .most = longest,
                       .least = 1e-9 * q->duration,
                       .stop = stop,
                       .n_stop = stops_of(q, stop)};
  const base_status done = climb(&l, err);
  if (done == BASE_OK) {
    hand_over(&l, record, out, kept);
  }
  made_close(&l.now);
  made_close(&l.before);
  free(stop);
  return done;
}
