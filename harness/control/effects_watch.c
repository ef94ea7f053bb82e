#include "harness/control/effects_watch.h"

#include "harness/control/checkpoint.h"
#include "lcp/base/clock.h"
#include "lcp/base/fields.h"

#include <stdlib.h>
#include <string.h>

static const unsigned candidates = EFFECT_FRICTION | EFFECT_RESTITUTION | EFFECT_ROLLING |
                                   EFFECT_TORSION | EFFECT_ROTATION | EFFECT_SPATIAL;
static const double noise =
    1e-9; /* of the speed scale, in one step: what a verified answer may be off by */
static const double small =
    1e-3; /* of the largest change: what changes less need not come in with it */

/* Scales of a scene. */
typedef struct scales {
  double size, speed, rate; /* [m], [m/s], [1/s] */
} scales;

/* What was left out may have brought by now. */
typedef struct deviation {
  double speed, place;      /* [m/s], [m] */
  double sum[EFFECT_COUNT]; /* of the changes of velocity by each effect [m/s] */
} deviation;

typedef struct watch {
  sim *s;
  const sim_request *q;
  series *record;
  watch_result *result;
  scales scale;
  deviation off;
  checkpoint clean;      /* nothing left out has acted up to here */
  sim_carrying carrying; /* of the last step */
} watch;

static double step_of(const sim_request *q, long k) {
  return (q->step != NULL) ? q->step[k] : q->h;
}

static scales scales_of(const sim_request *q, const world *w) {
  const double *g = q->spec->gravity;
  const double gravity = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  const double size = world_size(w);
  return (scales){.size = size,
                  .speed = fmax(sqrt(gravity * size), size / q->duration),
                  .rate = sqrt(gravity / size)};
}

/* Effects whose part is more than `share` of the largest. */
static unsigned acted(const deviation *d, double share) {
  double most = 0.0;
  unsigned effects = 0;
  for (int e = 0; e < EFFECT_COUNT; e++) {
    most = fmax(most, d->sum[e]);
  }
  for (int e = 0; e < EFFECT_COUNT; e++) {
    effects |= (d->sum[e] > share * most) ? 1u << e : 0u;
  }
  return effects;
}

/* A change of velocity in one step that is none: all of them together are a tenth of E at most. */
static double least_change(const watch *w) {
  const double E = w->result->level, n = (double)w->s->out->steps_planned;
  const double reach = fmin(w->scale.speed, w->scale.size / w->q->duration);
  return fmin(noise * w->scale.speed, 0.1 * E * reach / n);
}

/* Enters what the step left out could have changed. */
static void add_step(watch *w, double h) {
  const double grown = exp(w->scale.rate * h);
  deviation *d = &w->off;
  double change = 0.0;
  w->scale.speed = fmax(w->scale.speed, world_max_speed(w->s->w));
  const double least = least_change(w);
  for (int e = 0; e < EFFECT_COUNT; e++) {
    const double more = w->s->omitted[e];
    if (more > least) {
      d->sum[e] += more;
      change += more;
    }
  }
  d->speed = (d->speed + change) * grown;
  d->place = (d->place + h * d->speed) * grown;
}

/* How far the end may be off, over the scales. */
static double end_bound(const watch *w) {
  const double left = fmax(w->q->duration - world_time(w->s->w), 0.0);
  const double grown = exp(fmin(w->scale.rate * left, 700.0));
  const deviation *d = &w->off;
  if (acted(d, 0.0) == 0) {
    return 0.0;
  }
  return grown * fmax(d->speed / w->scale.speed, (d->place + d->speed * left) / w->scale.size);
}

static unsigned left_out(const watch *w) {
  const effects_plan *p = &w->result->plan;
  return w->q->effects & ~p->span[p->n - 1].effects;
}

/* From the clean step on with more effects. */
static base_status go_back(watch *w, unsigned more, base_error *err) {
  effects_plan *p = &w->result->plan;
  sim_result *out = w->s->out;
  const long reached = out->steps;
  unsigned now = p->span[p->n - 1].effects | more;
  if (p->n + 1 == EFFECTS_SPANS) {
    now = w->q->effects;
  }
  now |= ((now & EFFECT_ROTATION) != 0) ? w->q->effects & EFFECT_GYROSCOPIC : 0u;
  BASE_TRY(checkpoint_return(&w->clean, w->s, w->record, err));
  w->result->repeated += reached - out->steps;
  w->off = (deviation){0};
  if (p->span[p->n - 1].from == out->steps) {
    p->span[p->n - 1].effects = now;
  } else {
    p->span[p->n++] = (effects_span){out->steps, now};
  }
  return sim_change_effects(w->s, now, err);
}

/* What follows from the step just taken. A step that fails proves nothing of the whole scene: everything comes in. */
static base_status judge(watch *w, double h, bool *taken, base_error *err) {
  sim *s = w->s;
  if (!*taken || s->out->status != w->clean.out.status) {
    *taken = true;
    return go_back(w, w->q->effects, err);
  }
  add_step(w, h);
  const unsigned enter = acted(&w->off, small);
  const bool impact = s->carrying.ids != w->carrying.ids && s->out->steps > w->clean.out.steps + 1;
  const double bound = end_bound(w);
  w->carrying = s->carrying;
  if (enter != 0 && (bound > w->result->level || impact)) {
    return go_back(w, enter, err);
  }
  w->result->bound = bound;
  w->result->speed = w->scale.speed;
  return BASE_OK;
}

/* One step, and what follows from what it left out. */
static base_status step(watch *w, bool *taken, base_error *err) {
  sim *s = w->s;
  sim_result *out = s->out;
  const double h = step_of(w->q, out->steps);
  s->watched = left_out(w);
  if (s->watched == 0) {
    return sim_step(s, w->record, h, taken, err);
  }
  double from = base_seconds();
  if (acted(&w->off, 0.0) == 0) {
    BASE_TRY(checkpoint_take(&w->clean, s, w->record, err));
    w->carrying = s->carrying;
  }
  out->time.watch += base_seconds() - from;
  BASE_TRY(sim_step(s, w->record, h, taken, err));
  from = base_seconds();
  const base_status done = judge(w, h, taken, err);
  out->time.watch += base_seconds() - from;
  return done;
}

static base_status run(watch *w, base_error *err) {
  sim_result *out = w->s->out;
  BASE_TRY(checkpoint_open(&w->clean, w->s, err));
  for (bool taken = true; taken && out->steps < out->steps_planned && !sim_hopeless(w->s);) {
    BASE_TRY(step(w, &taken, err));
  }
  return BASE_OK;
}

/* What the run may begin without. */
static unsigned begin_without(const sim_request *q) {
  const bool own = (q->form->form->model & FORM_NO_LCP) != 0 || q->form->form->memory == 0;
  if (q->spec->model != NULL || own) {
    return 0;
  }
  unsigned without = q->effects & candidates;
  without &= (q->spec->dim == 2) ? ~(unsigned)EFFECT_ROTATION : ~0u;
  without &= ~world_moved_by(q->spec, without);
  return without | (((without & EFFECT_ROTATION) != 0) ? q->effects & EFFECT_GYROSCOPIC : 0u);
}

base_status watch_run(const sim_request *q, double level, series *record, sim_result *out,
                      watch_result *result, base_error *err) {
  sim s;
  sim_request first = *q;
  *result = (watch_result){.level = level, .watched = begin_without(q)};
  result->plan.n = 1;
  result->plan.span[0].effects = first.effects = q->effects & ~result->watched;
  first.plan = NULL;
  watch w = {.s = &s, .q = q, .record = record, .result = result};
  base_status done = sim_open(&s, &first, record, out, err);
  if (done == BASE_OK) {
    w.scale = scales_of(q, s.w);
    result->size = w.scale.size;
    result->speed = w.scale.speed;
    done = run(&w, err);
  }
  if (done == BASE_OK) {
    sim_finish(&s, record);
  }
  checkpoint_close(&w.clean);
  sim_close(&s);
  return done;
}

/* ---- texts ------------------------------------------------------------------------------------ */

base_status watch_parse(const char *text, bool *is, double *level, base_error *err) {
  *is = strncmp(text, "auto", 4) == 0;
  if (*is && (text[4] != ':' || !base_parse_real(text + 5, level) || !(*level > 0.0))) {
    return BASE_FAIL(err, BASE_EINVAL, "effects '%s': need auto:E with a number E above 0", text);
  }
  return BASE_OK;
}

base_status watch_check(const char *text, base_error *err) {
  bool is;
  double level;
  effects_plan plan;
  BASE_TRY(watch_parse(text, &is, &level, err));
  return is ? BASE_OK : effects_plan_parse(0, text, &plan, err);
}

/* The step from which on an effect is simulated, -1: never. */
static long entered(const effects_plan *p, unsigned bit) {
  for (int k = 0; k < p->n; k++) {
    if ((p->span[k].effects & bit) != 0) {
      return p->span[k].from;
    }
  }
  return -1;
}

void watch_print(const watch_result *r, unsigned declared, char text[EFFECTS_TEXT]) {
  size_t used = 0;
  text[0] = '\0';
  for (int i = 0; i < EFFECT_COUNT && used < EFFECTS_TEXT; i++) {
    const unsigned bit = 1u << i;
    if ((declared & (candidates | EFFECT_GYROSCOPIC) & bit) == 0) {
      continue;
    }
    const long from = entered(&r->plan, bit);
    const char *comma = (used > 0) ? ", " : "";
    if (from < 0) {
      used +=
          (size_t)snprintf(text + used, EFFECTS_TEXT - used, "%sdropped %s", comma, effect_name(i));
    } else {
      used += (size_t)snprintf(text + used, EFFECTS_TEXT - used, "%s%s from step %ld", comma,
                               effect_name(i), from + 1);
    }
  }
}
