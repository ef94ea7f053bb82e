#include "harness/control/error_quantity.h"

#include "harness/measure/check_eval.h"
#include "harness/measure/predictions.h"
#include "harness/util/stop.h"
#include "lcp/base/fields.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

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

bool error_late(const error_asked *a, double left) {
  return stop_due((a->until > 0.0) ? a->until - left : 0.0);
}

static const char all_places[] = "places of all bodies at the end";

/* ---- quantities of a run --------------------------------------------------------------------- */

void error_made_close(error_made *m) {
  series_close(&m->record);
  step_list_close(&m->kept);
  run_places_close(&m->places);
  free(m->met);
  free(m->quantity);
  *m = (error_made){0};
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
static double scale_of(const error_made *m, const char *unit) {
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
    most = fmax(most, run_places_length(p));
  } else if (strcmp(unit, "m/s") == 0) {
    most = fmax(fmax(most, column_most(s, SERIES_SPEED)), run_places_length(p) / end);
  } else if (strcmp(unit, "rad/s") == 0) {
    most = fmax(most, 1.0 / end);
  }
  return (most > 0.0) ? most : 1.0;
}

/* The quantity just added; NULL: E is not for it. */
static error_quantity *add(error_made *m, const error_asked *asked, const char *name,
                           const char *unit, double value) {
  const bool held = holds_for(asked, unit);
  m->more = m->more || (held && m->n_quantity == ERROR_QUANTITIES);
  if (!held || m->n_quantity == ERROR_QUANTITIES) {
    return NULL;
  }
  error_quantity *e = &m->quantity[m->n_quantity++];
  (void)snprintf(e->name, sizeof e->name, "%s", name);
  e->unit = unit;
  e->check = NULL;
  e->value = value;
  e->scale = 0.0;
  for (int i = 0; i + 1 < m->n_quantity && !(e->scale > 0.0); i++) {
    e->scale = (strcmp(m->quantity[i].unit, unit) == 0) ? m->quantity[i].scale : 0.0;
  }
  e->scale = (e->scale > 0.0) ? e->scale : scale_of(m, unit);
  e->estimate = e->change = HUGE_VAL;
  e->extreme = (extreme){.nearest = HUGE_VAL};
  e->leap = e->known = 0.0;
  return e;
}

static bool of_speed(const char *unit) {
  return strcmp(unit, "m/s") == 0 || strcmp(unit, "rad/s") == 0;
}

/* The impacts up to a time that change a speed by more than `least` each. An impact shows where a row differs from how the two before it go on. */
typedef struct bounces {
  int n;
  double last, before; /* how much it changed from one to the next, the last two [unit] */
  double at, since;    /* when the last was, and for how long before that there was none [s] */
} bounces;

/* By how much more the step to row k changes x than the one before it does in as long. */
static double bend_at(const double *t, const double *x, int k) {
  const double now = x[k] - x[k - 1], before = x[k - 1] - x[k - 2];
  const double slope = (t[k - 1] > t[k - 2]) ? before / (t[k - 1] - t[k - 2]) : 0.0;
  return fmin(fabs(now - slope * (t[k] - t[k - 1])), fabs(now) + fabs(before));
}

static bounces bounces_of(const error_made *m, int column, double until, double least) {
  const series *s = &m->record;
  const double *t = s->column[SERIES_TIME], *x = s->column[column];
  bounces found = {0};
  double low = x[0], high = x[0];
  for (int k = 0; k < s->n_row && t[k] <= until * (1.0 + 1e-9); k++) {
    low = fmin(low, x[k]);
    high = fmax(high, x[k]);
    const double change = (m->met[k] != 0 && k >= 2) ? bend_at(t, x, k) : 0.0;
    if (change > least) {
      found = (bounces){found.n + 1, fmax(change, high - low), found.last, t[k], t[k] - found.at};
      low = high = x[k];
    }
  }
  return found;
}

/* How far off a body may be that bounces, so that it is known at which bounce it is: half of the height of the last one, which lasts up to the time
 * that is asked for if that is longer, over the number of bounces whose errors come together. Where each changes less than the one before, to
 * a share e, those are 1 / (1 - e), and all that follow the last take as many times as long as the one before it: then it bounces no more. */
static void note_bounces(const error_made *m, int column, double until, double least,
                         error_quantity *e) {
  const bounces b = bounces_of(m, column, until, least);
  const double many = (b.last < b.before) ? 1.0 / (1.0 - b.last / b.before) : HUGE_VAL;
  if (b.n < 2 || until - b.at > many * b.since) {
    return;
  }
  const double arm = (strcmp(e->unit, "rad/s") == 0) ? m->places.size : 1.0;
  const double height = 0.125 * b.last * arm * fmax(b.since, until - b.at);
  e->leap = b.last;
  e->known = 0.5 * height / fmin((double)b.n, many);
}

double error_unit(const error_asked *asked, const error_quantity *e) {
  return (asked->unit[0] == '\0') ? e->scale : 1.0;
}

/* Do two checks of state look at the same? */
static bool same_question(const spec_check *a, const spec_check *b) {
  const bool along = a->has_dir == b->has_dir && a->dir[0] == b->dir[0] && a->dir[1] == b->dir[1] &&
                     a->dir[2] == b->dir[2];
  return a->kind == b->kind && strcmp(a->var, b->var) == 0 && along && a->t == b->t &&
         a->t0 == b->t0 && a->t1 == b->t1;
}

/* Is this asked already? Checks that are made for several formulations ask the same once. */
static bool is_asked(const error_made *m, const spec_check *c) {
  bool asked = false;
  for (int i = 0; i < m->n_quantity; i++) {
    asked = asked || (m->quantity[i].check != NULL && same_question(m->quantity[i].check, c));
  }
  return asked;
}

static bool is_observed(const error_made *m, const char *name) {
  bool observed = false;
  for (int i = 0; i < m->n_quantity; i++) {
    observed = observed || (m->quantity[i].check == NULL && strcmp(m->quantity[i].name, name) == 0);
  }
  return observed;
}

static bool of_turning(const char *unit) {
  return strcmp(unit, "rad") == 0 || strcmp(unit, "rad/s") == 0;
}

/* Is it known between two states from how far accelerated motion goes from its chord? Speeds keep to it. */
static bool of_bodies(const char *unit) {
  return strcmp(unit, "m") == 0 || strcmp(unit, "m/s") == 0 || of_turning(unit);
}

/* Of one in space that turns, no step tells. */
static bool of_spin(const spec_check *c) {
  const char *dot = strchr(c->var, '.');
  return !c->has_dir && dot != NULL && strcmp(dot, ".omega") == 0;
}

/* What a check of state says of its quantity beside the value. */
static void note_check(const error_asked *asked, const error_made *m, const spec_check *c,
                       error_quantity *e) {
  const series_var *v = series_find_var(&m->record, c);
  if (v != NULL && c->kind == CHECK_STATE && of_speed(e->unit)) {
    note_bounces(m, v->column, c->t, error_unit(asked, e) * asked->E, e);
  }
  if (v != NULL && c->kind != CHECK_STATE) {
    e->extreme = extreme_between(&m->record, m->met, v->column, c);
  }
}

static void read_checks(const sim_request *q, const error_asked *asked, error_made *m) {
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
    } else if (c->t1 > 0.0 && c->t1 < q->duration * (1.0 - 1e-9)) {
      (void)snprintf(name, sizeof name, "%s from %.4g to %.4g s", label, c->t0, c->t1);
    } else {
      (void)snprintf(name, sizeof name, "%s from %.4g s", label, c->t0);
    }
    if (got.known && !is_asked(m, c)) {
      error_quantity *e = add(m, asked, name, world_observe_unit(c->var), got.got);
      const bool state = c->kind == CHECK_STATE;
      if (e != NULL) {
        e->check = c;
        note_check(asked, m, c, e);
      }
      const bool straight = of_bodies(world_observe_unit(c->var)) && !of_spin(c);
      m->at_stops = m->at_stops && (state || straight);
      m->between = m->between || !state;
    }
  }
}

base_status error_made_read(const sim_request *q, const error_asked *asked, error_made *m,
                            base_error *err) {
  const int asks = q->spec->n_check + q->spec->n_observe + 1;
  const size_t most = (asks < ERROR_QUANTITIES) ? (size_t)asks : ERROR_QUANTITIES;
  BASE_TRY(extreme_met(&m->record, &m->kept, &m->met, err));
  m->quantity = malloc(most * sizeof *m->quantity);
  if (m->quantity == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %zu quantities", most);
  }
  m->at_stops = true;
  read_checks(q, asked, m);
  for (int i = 0; i < q->spec->n_observe; i++) {
    spec_check c = {0};
    double value;
    char name[112];
    memcpy(c.var, q->spec->observe[i], sizeof c.var);
    const series_var *v = series_find_var(&m->record, &c);
    (void)snprintf(name, sizeof name, "%s at the end", c.var);
    if (v != NULL && series_at(&m->record, v->column, q->duration, &value) &&
        !is_observed(m, name)) {
      error_quantity *e = add(m, asked, name, world_observe_unit(c.var), value);
      if (e != NULL && of_speed(e->unit)) {
        note_bounces(m, v->column, q->duration, error_unit(asked, e) * asked->E, e);
      }
    }
  }
  if (m->n_quantity == 0) {
    (void)add(m, asked, all_places, "m", m->places.travel);
  }
  for (int i = 0; i < m->n_quantity; i++) {
    m->turns = m->turns || of_turning(m->quantity[i].unit);
  }
  return BASE_OK;
}

/* A law of the whole motion, that some formulations keep to rounding? */
static bool of_law(spec_check_kind k) {
  return k == CHECK_ENERGY_GROWTH_REL || k == CHECK_ENERGY_DRIFT_REL ||
         k == CHECK_ANGULAR_MOMENTUM_DRIFT_REL;
}

double error_made_misses(const sim_request *q, const error_made *m, char *name, size_t cap) {
  const check_context ctx = prediction_context(q, &m->record, &m->out);
  double most = 0.0;
  for (int i = 0; i < q->spec->n_check; i++) {
    const spec_check *c = &q->spec->check[i];
    check_result got;
    if (!of_law(c->kind) || !prediction_applies(q, i)) {
      continue;
    }
    check_evaluate(c, &ctx, &got);
    const double over = got.error / got.tolerance;
    if (!got.ok && !(over <= most)) {
      check_label(c, name, cap);
      most = (over == over) ? over : HUGE_VAL;
    }
  }
  return most;
}

double error_made_difference(const error_made *a, const error_made *b, int i) {
  if (strcmp(a->quantity[i].name, all_places) != 0) {
    return fabs(a->quantity[i].value - b->quantity[i].value);
  }
  double most = 0.0;
  for (int k = 0; k < 3 * a->places.n; k++) {
    most = fmax(most, fabs(a->places.end[k] - b->places.end[k]));
  }
  return most;
}

/* ---- times that checks look at --------------------------------------------------------------- */

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a;
  const double y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Appends those of (0, end). */
static int put_stop(double *stop, int n, double at, double end) {
  if (at > 1e-9 * end && at < end * (1.0 - 1e-9)) {
    stop[n++] = at;
  }
  return n;
}

static const double pi = 3.14159265358979323846;

/* Half periods of a load that swings in the run; 0: none. */
static double half_periods(const spec_load *l, double end) {
  const bool swings = l->kind == SPEC_FORCE_SINE && l->rate != 0.0;
  return swings ? ceil(fabs(l->omega) * end / pi) : 0.0;
}

/* Room for the peaks of all loads; 0: there are none to look at, or so many that no run has as many steps. */
static size_t count_peaks(const sim_request *q) {
  static const double most = 1e6;
  const unsigned needed = EFFECT_LOADS | EFFECT_CONTACT;
  double n = 0.0;
  for (int i = 0; (q->effects & needed) == needed && i < q->spec->n_load; i++) {
    const double halves = half_periods(&q->spec->load[i], q->duration);
    n += (halves > 0.0) ? halves + 1.0 : 0.0;
  }
  return (n < most) ? (size_t)n : 0;
}

/* Appends the times at which loads that swing are largest: what holds before and behind may give way there for a moment. */
static int put_peaks(const sim_request *q, double *stop, int n) {
  for (int i = 0; i < q->spec->n_load; i++) {
    const spec_load *l = &q->spec->load[i];
    const int halves = (int)half_periods(l, q->duration);
    const double turn = (l->omega < 0.0) ? l->phase / pi - 0.5 : 0.5 - l->phase / pi;
    for (int k = 0; k <= halves && halves > 0; k++) {
      n = put_stop(stop, n, (k + turn - floor(turn)) * pi / fabs(l->omega), q->duration);
    }
  }
  return n;
}

base_status error_stops(const sim_request *q, int parts, const error_made *before, double **stop,
                        int *n_stop, base_error *err) {
  const double end = q->duration;
  const size_t peaks = count_peaks(q);
  const size_t most = (size_t)q->spec->n_check * ((size_t)parts + 3) + 1 + ERROR_QUANTITIES + peaks;
  double *at = realloc(*stop, most * sizeof *at);
  if (at == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the times of the checks");
  }
  *stop = at;
  int n = 0;
  for (int i = 0; i < q->spec->n_check; i++) {
    const spec_check *c = &q->spec->check[i];
    n = put_stop(at, n, c->t, end);
    n = put_stop(at, n, c->t0, end);
    n = put_stop(at, n, c->t1, end);
    const double span =
        (of_state(c, end) && c->kind != CHECK_STATE) ? fmin(c->t1, end) - c->t0 : 0.0;
    for (int k = 1; span > 0.0 && k < parts; k++) {
      n = put_stop(at, n, c->t0 + span * k / parts, end);
    }
  }
  for (int i = 0; i < before->n_quantity; i++) {
    n = put_stop(at, n, before->quantity[i].extreme.at, end);
  }
  n = (peaks > 0) ? put_peaks(q, at, n) : n;
  qsort(at, (size_t)n, sizeof *at, ascending);
  int kept = 0;
  for (int i = 0; i < n; i++) {
    if (kept == 0 || at[i] > at[kept - 1] + 1e-9 * end) {
      at[kept++] = at[i];
    }
  }
  at[kept++] = end;
  *n_stop = kept;
  return BASE_OK;
}

base_status error_speed_times(const sim_request *q, double **at, int *n, base_error *err) {
  const double end = q->duration;
  bool ends = false;
  *n = 0;
  *at = malloc(((size_t)q->spec->n_check + 1) * sizeof **at);
  if (*at == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the times of the checks");
  }
  for (int i = 0; i < q->spec->n_check; i++) {
    const spec_check *c = &q->spec->check[i];
    const bool asks = c->kind == CHECK_STATE && of_speed(world_observe_unit(c->var));
    ends = ends || (asks && c->t >= end * (1.0 - 1e-9) && of_state(c, end));
    *n = asks ? put_stop(*at, *n, c->t, end) : *n;
  }
  for (int i = 0; i < q->spec->n_observe; i++) {
    ends = ends || of_speed(world_observe_unit(q->spec->observe[i]));
  }
  qsort(*at, (size_t)*n, sizeof **at, ascending);
  if (ends) {
    (*at)[(*n)++] = end;
  }
  return BASE_OK;
}
