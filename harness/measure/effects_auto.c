#include "harness/measure/effects_auto.h"

#include "lcp/base/clock.h"

#include <string.h>

/* What may be left out: unknowns and rows. Gravity, contact, joints, loads and motion are the scene
 * itself, and may act later than any pilot sees. */
static const unsigned candidates = EFFECT_FRICTION | EFFECT_RESTITUTION | EFFECT_ROLLING |
                                   EFFECT_TORSION | EFFECT_ROTATION | EFFECT_GYROSCOPIC |
                                   EFFECT_DAMPING | EFFECT_SPATIAL;

/* One run of the pilot. */
typedef struct pilot {
  series record;
  sim_result result;
} pilot;

static sim_request pilot_request(const sim_request *q, unsigned effects) {
  sim_request p = *q;
  const double steps = fmin(fmax(ceil(0.01 * q->duration / q->h), AUTO_STEPS_MIN), AUTO_STEPS_MAX);
  p.duration = fmin(steps * q->h, q->duration);
  p.effects = effects;
  p.trajectory = NULL;
  return p;
}

/* ---- change -----------------------------------------------------------------------------------*/

/* Largest |value| among the columns of one unit. */
static double scale_of(const series *s, const char *unit, double floor) {
  double most = floor;
  for (int i = 0; i < s->n_var; i++) {
    if (strcmp(world_observe_unit(s->var[i].var), unit) != 0) {
      continue;
    }
    for (int k = 0; k < s->n_row; k++) {
      most = fmax(most, fabs(s->column[s->var[i].column][k]));
    }
  }
  return most;
}

static double column_change(const series *a, const series *b, int ca, int cb, double scale) {
  double most = 0.0;
  for (int k = 0; k < a->n_row; k++) {
    const double d = fabs(a->column[ca][k] - b->column[cb][k]);
    if (!(d <= most)) {
      most = d; /* NaN included */
    }
  }
  return (most == 0.0) ? 0.0 : most / scale;
}

static double column_max(const series *s, int column) {
  double most = 0.0;
  for (int k = 0; k < s->n_row; k++) {
    most = fmax(most, fabs(s->column[column][k]));
  }
  return most;
}

/* Both records come from the same spec, hence have the same columns. HUGE_VAL: not comparable. */
static double change_of(const sim_request *q, const pilot *full, const pilot *without) {
  const series *a = &full->record;
  const series *b = &without->record;
  if (without->result.status != RUN_OK || a->n_row != b->n_row) {
    return HUGE_VAL;
  }
  const double *g = q->spec->gravity;
  const double gravity = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  const double T = a->column[SERIES_TIME][a->n_row - 1];
  const double speed = fmax(column_max(a, SERIES_SPEED), gravity * T);
  double most = column_change(a, b, SERIES_SPEED, SERIES_SPEED, speed);
  most =
      fmax(most, column_change(a, b, SERIES_ENERGY, SERIES_ENERGY, column_max(a, SERIES_ENERGY)));
  for (int i = 0; i < a->n_var; i++) {
    const char *unit = world_observe_unit(a->var[i].var);
    const double floor = (strcmp(unit, "m") == 0)     ? 0.5 * gravity * T * T
                         : (strcmp(unit, "m/s") == 0) ? speed
                                                      : 0.0;
    const int c = a->var[i].column;
    most = fmax(most, column_change(a, b, c, c, scale_of(a, unit, floor)));
  }
  const double longer = q->duration / T;
  return (most == most) ? most * longer * longer : HUGE_VAL;
}

/* ---- pilots -----------------------------------------------------------------------------------*/

/* Runs without `dropped` and compares with the whole; a scene that cannot do without (a joint's
 * body, a quantity that is gone) is a change without bounds, its reason in *why. */
static double change_without(const sim_request *q, const pilot *full, unsigned dropped,
                             base_error *why) {
  pilot p;
  const sim_request request = pilot_request(q, q->spec->effects & ~dropped);
  const base_status done = simulate(&request, &p.record, &p.result, why);
  const double change = (done == BASE_OK) ? change_of(q, full, &p) : HUGE_VAL;
  series_close(&p.record);
  return change;
}

/* "dropped friction 3e-12": one entry of the report. */
static void say(effects_choice *out, const char *word, int bit, double change) {
  const size_t used = strlen(out->text);
  const char *comma = (used > 0) ? ", " : "";
  if (change < 0.0) {
    const char *rule = effects_rule(&out->rules, 1u << bit);
    (void)snprintf(out->text + used, sizeof out->text - used, "%s%s %s (%s)", comma, word,
                   effect_name(bit), rule != NULL ? rule : "unseen");
  } else {
    (void)snprintf(out->text + used, sizeof out->text - used, "%s%s %s %.2g", comma, word,
                   effect_name(bit), change);
  }
}

/* Takes effects back, largest change first, until the rest together stays below the level. */
static void settle(const sim_request *q, const pilot *full, double change[EFFECT_COUNT],
                   effects_choice *out) {
  base_error why = {0};
  while (out->dropped != 0 &&
         (out->change = change_without(q, full, out->dropped, &why)) > out->level) {
    int worst = -1;
    for (int i = 0; i < EFFECT_COUNT; i++) {
      if ((out->dropped & 1u << i) != 0 && (worst < 0 || change[i] > change[worst])) {
        worst = i;
      }
    }
    out->dropped &= ~(1u << worst);
    change[worst] = out->change;
  }
  out->change = (out->dropped != 0) ? out->change : 0.0;
}

static void report(const sim_request *q, unsigned seen, const double change[EFFECT_COUNT],
                   effects_choice *out) {
  for (int i = 0; i < EFFECT_COUNT; i++) {
    const unsigned bit = 1u << i;
    if ((q->spec->effects & candidates & bit) == 0) {
      continue;
    }
    const double shown =
        ((seen & bit) != 0 && effects_rule(&out->rules, bit) == NULL) ? change[i] : -1.0;
    say(out, (out->dropped & bit) != 0 ? "dropped" : "kept", i, shown);
  }
}

/* Judges by pilots what the rules leave to them. */
static base_status pilots(sim_request *q, unsigned left, effects_choice *out, base_error *err) {
  const sim_request request = pilot_request(q, q->spec->effects);
  pilot full;
  double change[EFFECT_COUNT];
  base_status done = simulate(&request, &full.record, &full.result, err);
  if (done == BASE_OK && full.result.status != RUN_OK) {
    done = BASE_FAIL(err, BASE_EUNSUPPORTED, "effects auto: the pilot is %s: %.160s",
                     run_status_name(full.result.status), full.result.note);
  }
  if (done == BASE_OK) {
    const unsigned seen = full.result.effects_seen;
    for (int i = 0; i < EFFECT_COUNT; i++) {
      base_error why = {0};
      const bool asked = (left & seen & 1u << i) != 0;
      change[i] = asked ? change_without(q, &full, 1u << i, &why) : HUGE_VAL;
      out->dropped |= (change[i] < out->level) ? 1u << i : 0u;
    }
    settle(q, &full, change, out);
    report(q, seen, change, out);
    out->pilot_steps = full.result.steps;
    q->effects = q->spec->effects & ~out->dropped;
  }
  series_close(&full.record);
  return done;
}

static base_status choose(sim_request *q, effects_choice *out, base_error *err) {
  const double from = base_seconds();
  const effects_span span = {q->h, q->duration, out->level};
  BASE_TRY(effects_rules(q->spec, &span, &out->rules, err));
  unsigned left = 0; /* to be judged by pilots */
  for (int i = 0; i < EFFECT_COUNT; i++) {
    const unsigned bit = candidates & q->spec->effects & 1u << i;
    left |= (bit != 0 && effects_rule(&out->rules, bit) == NULL) ? bit : 0u;
  }
  if (left != 0) {
    BASE_TRY(pilots(q, left, out, err));
  } else {
    const double none[EFFECT_COUNT] = {0};
    report(q, 0, none, out);
    q->effects = q->spec->effects;
  }
  out->pilot_seconds = base_seconds() - from;
  return BASE_OK;
}

/* Is text "auto:E"? The level, then. */
static base_status automatic(const char *text, bool *is, double *level, base_error *err) {
  *is = strncmp(text, "auto", 4) == 0;
  if (*is && (text[4] != ':' || !base_parse_real(text + 5, level) || !(*level > 0.0))) {
    return BASE_FAIL(err, BASE_EINVAL, "effects '%s': need auto:E with a number E above 0", text);
  }
  return BASE_OK;
}

base_status effects_check(const char *text, base_error *err) {
  bool is;
  double level;
  unsigned mask;
  BASE_TRY(automatic(text, &is, &level, err));
  return is ? BASE_OK : effects_override(0, text, &mask, err);
}

base_status effects_choose(sim_request *q, const char *text, effects_choice *out, base_error *err) {
  *out = (effects_choice){0};
  BASE_TRY(automatic(text, &out->automatic, &out->level, err));
  if (!out->automatic) {
    return effects_override(q->spec->effects, text, &q->effects, err);
  }
  q->judged = true;
  return choose(q, out, err);
}
