#include "harness/control/effects_watch.h"

#include "harness/control/checkpoint.h"
#include "harness/control/deviation.h"
#include "harness/util/stop.h"
#include "lcp/base/clock.h"
#include "lcp/base/fields.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Without one of these a step has fewer rows or axes. */
static const unsigned candidates =
    EFFECT_FRICTION | EFFECT_ROLLING | EFFECT_TORSION | EFFECT_ROTATION | EFFECT_SPATIAL;
static const double noise =
    1e-9; /* of the speed scale, in one step: what a verified answer may be off by */
static const double small =
    1e-3; /* of the largest change: what changes less need not come in with it */

enum { MOST_LEFT = 8 };  /* times that something is left out in motion: each may be taken back */
enum { ASK_AFTER = 16 }; /* steps between tries for a change of contacts */
static const double most_repeated = 0.5; /* of all steps: beyond, what comes in stays in */

/* Where deviations grow only while bodies turn or meet, that the end would be off by more than E if they went on to is no reason yet while
 * the deviation by now goes into E often enough: 16 times in the first step of doubt, 64, 144, ... times in those that follow it. */
static double room(int doubts) {
  return 16.0 * doubts * doubts;
}

/* By so much below E must be what is to be left out while deviations grow, as foreseen. */
static const double spare = 3.0;

static const double moving =
    1e-3; /* of the speed scale: by so much a body moves; less may be what a change of effects leaves */

typedef struct watch {
  sim *s;
  const sim_request *q;
  series *record;
  watch_result *result;
  deviation_scale scale;
  world_inertia *inertia; /* of each body */
  world_deviation *point; /* of each, before the step */
  deviation off, before;  /* before: before the step */
  unsigned by;            /* the effects that `off` is by */
  checkpoint clean;       /* nothing left out has acted up to here */
  checkpoint last;        /* before the step, where something has */
  bool took_last;         /* before effects were left out there */
  sim_carrying carrying;  /* before the step */
  bool waits;             /* for contacts that stay, to leave something out */
  bool moved; /* something that could meet anything has, since effects were last left out at rest */
  /* Contacts that carried in the last step, when all that could meet anything lay still; 0: not all did. */
  uint64_t lay;
  long next;  /* step from which on something may be left out in motion again, */
  long pause; /* and steps from there to the next try */
  long asked; /* the last step at which a change of contacts was a reason to try */
  int left;   /* how often something was */
  int doubts; /* steps of doubt in a row, none between them without growth */
} watch;

static double step_of(const sim_request *q, long k) {
  return (q->step != NULL) ? q->step[k] : q->h;
}

/* A change of velocity in one step that is none: all of them together are a tenth of E at most. */
static double least_change(const watch *w) {
  const double E = w->result->level, n = (double)w->s->out->steps_planned;
  const double reach = fmin(w->scale.speed, w->scale.size / w->q->duration);
  return fmin(noise * w->scale.speed, 0.1 * E * reach / n);
}

/* Enters what the step left out could have changed; false: nothing left out has acted up to now. */
static bool add_step(watch *w, double h) {
  w->scale.speed = fmax(w->scale.speed, world_max_speed(w->s->w));
  deviation_add(&w->off, &w->scale, w->s->omitted, w->s->grown, h);
  return w->off.any;
}

/* How far body i may be off by the end, over the scales. */
static deviation_forecast to_the_end(const watch *w, int i) {
  const double left = fmax(w->q->duration - world_time(w->s->w), 0.0);
  return deviation_after(&w->off, i, &w->scale, left);
}

static bool grows(const watch *w) {
  bool some = false;
  for (int i = 0; i < w->off.n && !some; i++) {
    some = w->off.body[i].grows > 0.0;
  }
  return some;
}

static unsigned left_out(const watch *w) {
  const effects_plan *p = &w->result->plan;
  return w->q->effects & ~p->span[p->n - 1].effects;
}

/* Nothing left out has acted up to the step now reached. */
static base_status take_clean(watch *w, base_error *err) {
  const checkpoint *c = &w->clean;
  const bool there = c->n_row > 0 && c->out->steps == w->s->out->steps;
  return there ? BASE_OK : checkpoint_take(&w->clean, w->s, w->record, err);
}

/* From the step now reached on. All wake where these are others than in the step before it. */
static base_status change_effects(watch *w, unsigned now, base_error *err) {
  effects_plan *p = &w->result->plan;
  p->n -= (p->span[p->n - 1].from == w->s->out->steps) ? 1 : 0;
  const bool others = p->n == 0 || p->span[p->n - 1].effects != now;
  if (others) {
    p->span[p->n++] = (effects_span){w->s->out->steps, now};
  }
  BASE_TRY(sim_change_effects(w->s, now, err));
  return others ? sim_wake(w->s, true, err) : BASE_OK;
}

/* The stiffness of bristles goes with the mass that they move, which is another where bodies may turn. */
static unsigned with_friction(const sim_request *q, unsigned more) {
  const bool bristles = (q->form->form->model & FORM_REGULARISED) != 0;
  return (bristles && (more & EFFECT_FRICTION) != 0)
             ? q->effects & (EFFECT_ROTATION | EFFECT_GYROSCOPIC | EFFECT_SPATIAL)
             : 0u;
}

/* From the step now reached on with more effects than before it. */
static base_status add_effects(watch *w, unsigned more, base_error *err) {
  effects_plan *p = &w->result->plan;
  while (p->n > 1 && p->span[p->n - 1].from > w->s->out->steps) {
    p->n--;
  }
  more |= with_friction(w->q, more);
  unsigned now = p->span[p->n - 1].effects | more;
  if (p->n + 1 == EFFECTS_SPANS) {
    now = w->q->effects;
  }
  now |= ((now & EFFECT_ROTATION) != 0) ? w->q->effects & EFFECT_GYROSCOPIC : 0u;
  return change_effects(w, now, err);
}

/* Before the step just taken, with what acted in it for the first time. */
static base_status step_back(watch *w, unsigned more, base_error *err) {
  BASE_TRY(checkpoint_return(&w->last, w->s, w->record, err));
  w->result->repeated++;
  w->lay = 0;
  deviation_copy(&w->off, &w->before);
  w->by = deviation_by(&w->off, small);
  w->doubts = 0;
  return add_effects(w, more, err);
}

/* From the clean step on with more effects: to stay, once that has been dear. */
static base_status go_back(watch *w, unsigned more, base_error *err) {
  const sim_result *out = w->s->out;
  const long reached = out->steps;
  BASE_TRY(checkpoint_return(&w->clean, w->s, w->record, err));
  w->result->repeated += reached - out->steps;
  deviation_clear(&w->off);
  w->by = 0;
  w->result->bound = 0.0;
  w->doubts = 0;
  w->moved = false; /* it may have been what was taken back */
  w->lay = 0;
  w->pause = 1;
  w->next = reached + w->pause; /* not before what it came in for */
  w->s->would_deviate = false;
  if ((double)w->result->repeated > most_repeated * (double)out->steps_planned) {
    w->result->watched &= ~more;
  }
  return add_effects(w, more, err);
}

/* Would the end be off by more than E if it went on as in the last step, or in the last two, which left their contacts as they were?
 * *bound: how far it may be off without anything more. The first impact in which something acts is simulated with it if it takes a third
 * of E: it may leave again behind it. */
static bool goes_too_far(watch *w, bool changed, double *bound) {
  const double E = w->result->level;
  const bool first = changed && !w->before.any;
  bool some = false, sure = false;
  *bound = 0.0;
  for (int i = 0; i < w->off.n; i++) {
    const deviation_forecast f = to_the_end(w, i);
    const bool far = f.free > E || (!changed && f.both > E), grown = w->off.body[i].grows > 0.0;
    some = some || far;
    sure = sure || (far && (!grown || room(w->doubts + 1) * f.now > E)) ||
           (first && grown && spare * f.free > E);
    *bound = fmax(*bound, f.free);
  }
  w->doubts = grows(w) ? w->doubts + some : 0;
  return sure;
}

/* Did a body fall asleep that is off? What was left out may have gone on to act on it, which nothing tells of from here on. */
static bool sleeps_off(const watch *w) {
  bool some = false;
  for (int i = 0; i < w->off.n && w->s->slept && !some; i++) {
    const deviation_body *b = &w->off.body[i];
    const bool off = b->v > 0.0 || b->w > 0.0 || b->x > 0.0 || b->a > 0.0;
    some = off && world_just_fell_asleep(w->s->w, i);
  }
  return some;
}

/* What follows from the step just taken. A step that fails proves nothing of the whole scene: everything comes in. */
static base_status judge(watch *w, double h, bool *taken, base_error *err) {
  sim *s = w->s;
  if (!*taken || s->out->status != w->clean.out->status) {
    *taken = true;
    return go_back(w, w->q->effects, err);
  }
  const unsigned earlier = w->by;
  const bool changed = s->carrying.ids != w->carrying.ids;
  const bool acts = add_step(w, h);
  if (!acts) {
    return BASE_OK;
  }
  const unsigned by = w->by = deviation_by(&w->off, small);
  if (sleeps_off(w)) {
    return go_back(w, by, err);
  }
  double bound;
  const bool too_far = goes_too_far(w, changed, &bound);
  if (w->before.any && (by & ~earlier) != 0 && bound > w->result->level) {
    return step_back(w, by & ~earlier, err);
  }
  if (!s->alike && earlier != 0) {
    return go_back(w, earlier, err); /* the impact's own come in when it is reached again */
  }
  if (!s->alike || too_far) {
    return go_back(w, by, err);
  }
  w->result->bound = bound;
  w->result->speed = w->scale.speed;
  return BASE_OK;
}

static unsigned with_gyroscopic(const sim_request *q, unsigned without) {
  return without | (((without & EFFECT_ROTATION) != 0) ? q->effects & EFFECT_GYROSCOPIC : 0u);
}

/* Where what is to come is known from. */
typedef enum outlook {
  NEXT_STEP,  /* what is sure to act in it */
  GOES_ON,    /* that, to the end of the run */
  AS_IT_ACTED /* what acted in the last step does so to the end, and deviations grow as in it */
} outlook;

/* As in the last step, in which it was simulated. */
static void foresee_as_it_acted(const watch *w) {
  sim *s = w->s;
  for (int i = 0; i < w->off.n; i++) {
    const double gyration = w->inertia[i].gyration;
    world_growth *g = &s->grown[i];
    const bool turns = g->turned && gyration > 0.0;
    g->moved = fmax(g->moved, g->acted);
    g->spun = g->held + (turns ? g->acted / (gyration * gyration) : 0.0);
    for (int e = 0; e < EFFECT_COUNT; e++) {
      const unsigned bit = w->result->watched & s->effects & 1u << e;
      const double did = (bit == EFFECT_FRICTION) ? g->acted : g->held;
      if ((bit & (EFFECT_FRICTION | EFFECT_ROLLING | EFFECT_TORSION)) != 0) {
        s->omitted[e] = fmax(s->omitted[e], did);
      }
    }
  }
}

/* No deviation grows: it is not known, or does not matter. */
static void grow_nothing(const watch *w) {
  for (int i = 0; i < w->off.n; i++) {
    w->s->grown[i] = (world_growth){.group = i};
  }
}

/* Of what the run may do without: what is to come, and does more than E. *touches: a contact is closed. */
static base_status foresee(watch *w, outlook from, unsigned *acts, bool *touches, base_error *err) {
  contact_set set;
  const double h = step_of(w->q, w->s->out->steps);
  BASE_TRY(world_contacts(w->s->w, h, -1.0, &set, err));
  *touches = false;
  for (int i = 0; i < set.n_contact && !*touches; i++) {
    *touches = set.gap[i] <= set.tol;
  }
  const bool known = from == AS_IT_ACTED;
  if (!known) {
    grow_nothing(w);
  }
  world_foreseen(w->s->w, w->result->watched & (known ? EFFECT_SPATIAL : ~0u), w->s->omitted,
                 w->s->grown);
  if (known) {
    foresee_as_it_acted(w);
  }
  deviation_copy(&w->before, &w->off);
  const bool any = add_step(w, h);
  const double most = w->result->level / (grows(w) ? spare : 1.0);
  bool enough = false;
  for (int i = 0; i < w->off.n && any && !enough; i++) {
    const deviation_forecast f = to_the_end(w, i);
    enough = ((from == NEXT_STEP) ? f.free : f.last) > most;
  }
  for (int e = 0; e < EFFECT_COUNT; e++) {
    w->off.sum[e] -= w->before.sum[e]; /* of this step alone */
  }
  *acts = enough ? deviation_by(&w->off, small) : 0u;
  deviation_copy(&w->off, &w->before);
  return BASE_OK;
}

/* Less of what the run may do without, from here on: what does not move, and is not foreseen to act. */
static base_status leave_out(watch *w, outlook from, base_error *err) {
  const unsigned in = w->result->watched & w->s->effects;
  unsigned acts;
  bool touches;
  BASE_TRY(foresee(w, from, &acts, &touches, err));
  unsigned without = in & candidates & ~acts;
  without &= ~world_moves(w->s->w, without, least_change(w));
  without &= ~with_friction(w->q, w->s->effects & ~without);
  without = with_gyroscopic(w->q, without);
  if (without == 0) {
    return BASE_OK;
  }
  w->left++;
  /* with what is to be left out as it is */
  w->took_last = w->off.any;
  BASE_TRY(w->off.any ? checkpoint_take(&w->last, w->s, w->record, err) : take_clean(w, err));
  return change_effects(w, w->s->effects & ~without, err);
}

/* The same contacts carried twice, after a beginning without any. Once a run. */
static base_status leave_at_contact(watch *w, base_error *err) {
  w->waits = false;
  return leave_out(w, NEXT_STEP, err);
}

/* All that could meet anything lies still, on the same contacts as a step before: what came in goes. What comes in again from rest
 * stays in until something of it has moved. */
static bool lies(watch *w) {
  const sim *s = w->s;
  const double speed = world_meeting_speed(s->w);
  const uint64_t before = w->lay;
  w->moved = w->moved || speed > moving * w->scale.speed;
  w->lay = (speed <= least_change(w) && s->carrying.n > 0) ? s->carrying.ids : 0;
  const bool so = w->moved && w->lay != 0 && w->lay == before;
  w->moved = w->moved && !so;
  return so;
}

/* The step just taken was on the same contacts as the one before, and what it would have made of deviations is known. That is asked for
 * ever more seldom, and behind a change of contacts now and then. */
static bool is_known(watch *w, bool stay) {
  sim *s = w->s;
  const bool asked = s->would_deviate;
  const long now = s->out->steps;
  if (asked) {
    w->pause *= 2;
    w->next = now + w->pause;
  } else if (!stay && now >= w->asked + ASK_AFTER && w->next < LONG_MAX) {
    w->next = w->asked = now;
  }
  s->would_deviate = !asked && stay && now >= w->next && w->left < MOST_LEFT;
  return asked && stay;
}

/* What came in goes where all lies still, or where nothing left out has acted and what it will have done by the end is foreseen to be
 * less than E: it came in at an impact that is over. */
static base_status leave_again(watch *w, bool stay, base_error *err) {
  const sim *s = w->s;
  const bool some = (w->result->watched & s->effects & candidates) != 0;
  const bool may = some && w->result->plan.n + 2 <= EFFECTS_SPANS;
  const bool followed =
      !w->off.any || s->watched != 0; /* what is off goes on only where it is watched */
  const bool still = may && followed && lies(w);
  if (still || !may || w->off.any) {
    w->s->would_deviate = false;
    return still ? leave_out(w, GOES_ON, err) : BASE_OK;
  }
  return is_known(w, stay) ? leave_out(w, AS_IT_ACTED, err) : BASE_OK;
}

/* What the step just taken shows not to be called for any more. */
static base_status leave(watch *w, base_error *err) {
  const sim *s = w->s;
  const bool stay = s->carrying.n > 0 && s->carrying.ids == w->carrying.ids;
  if (w->result->watched == 0 || s->out->steps == s->out->steps_planned || (w->waits && !stay)) {
    return BASE_OK;
  }
  const double from = base_seconds();
  BASE_TRY(w->waits ? leave_at_contact(w, err) : leave_again(w, stay, err));
  w->s->out->time.watch += base_seconds() - from;
  return BASE_OK;
}

/* One step, and what follows from what it left out. */
static base_status step(watch *w, bool *taken, base_error *err) {
  sim *s = w->s;
  sim_result *out = s->out;
  const double h = step_of(w->q, out->steps);
  s->watched = left_out(w);
  s->least = least_change(w);
  s->off = w->off.any ? w->point : NULL;
  w->carrying = s->goes_on;
  if (s->watched == 0) {
    BASE_TRY(sim_step(s, w->record, h, taken, err));
    return *taken ? leave(w, err) : BASE_OK;
  }
  double from = base_seconds();
  deviation_points(&w->off, w->point);
  deviation_copy(&w->before, &w->off);
  if (!w->took_last) {
    BASE_TRY(w->off.any ? checkpoint_take(&w->last, s, w->record, err) : take_clean(w, err));
  }
  w->took_last = false;
  out->time.watch += base_seconds() - from;
  BASE_TRY(sim_step(s, w->record, h, taken, err));
  from = base_seconds();
  BASE_TRY(judge(w, h, taken, err));
  out->time.watch += base_seconds() - from;
  return leave(w, err);
}

/* Before contacts touch, or joints are rows, leaving out saves nothing: everything is in but what the formulation does not
 * simulate. */
static base_status begin(watch *w, base_error *err) {
  const sim_request *q = w->q;
  const double from = base_seconds();
  unsigned acts;
  bool touches;
  if (w->result->watched == 0) {
    return BASE_OK;
  }
  BASE_TRY(foresee(w, GOES_ON, &acts, &touches, err));
  w->waits = !touches && (q->effects & EFFECT_JOINTS) == 0;
  acts |= with_friction(q, acts | (q->effects & ~w->result->watched));
  const unsigned in = w->result->watched & (w->waits ? ~q->form->form->lacks : acts);
  const base_status done = (in != 0) ? change_effects(w, w->s->effects | in, err) : BASE_OK;
  w->s->out->time.watch += base_seconds() - from;
  return done;
}

/* What is kept of each body. */
static base_status open_bodies(watch *w, base_error *err) {
  const int n = w->q->spec->n_body;
  const size_t count = (size_t)n + 1;
  w->inertia = malloc(count * sizeof *w->inertia);
  w->point = malloc(count * sizeof *w->point);
  w->s->grown = calloc(count, sizeof *w->s->grown);
  if (w->inertia == NULL || w->point == NULL || w->s->grown == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for what %d bodies are off by", n);
  }
  for (int i = 0; i < n; i++) {
    w->inertia[i] = world_inertia_of(w->s->w, w->q->effects, i);
  }
  BASE_TRY(deviation_open(&w->off, n, w->inertia, err));
  return deviation_open(&w->before, n, w->inertia, err);
}

static base_status run(watch *w, base_error *err) {
  sim_result *out = w->s->out;
  if (w->result->watched != 0) {
    BASE_TRY(open_bodies(w, err));
  }
  BASE_TRY(checkpoint_open(&w->clean, w->s, err));
  BASE_TRY(checkpoint_open(&w->last, w->s, err));
  BASE_TRY(begin(w, err));
  bool late = false;
  for (bool taken = true;
       taken && !late && out->steps < out->steps_planned && !sim_hopeless(w->s);) {
    BASE_TRY(step(w, &taken, err));
    late = stop_due(w->q->until);
  }
  return BASE_OK;
}

/* What a run may do without. */
static unsigned unneeded(const sim_request *q) {
  const bool own = (q->form->form->model & FORM_NO_LCP) != 0 || q->form->form->memory == 0;
  if (q->spec->model != NULL || own) {
    return 0;
  }
  unsigned without = q->effects & candidates;
  without &= (q->spec->dim == 2) ? ~(unsigned)EFFECT_ROTATION : ~0u;
  without &= ~world_moved_by(q->spec, without);
  return with_gyroscopic(q, without);
}

static bool has_friction(const sim_request *q) {
  return (q->effects & EFFECT_FRICTION) != 0;
}

static formulation_friction friction_of(const sim_request *q) {
  return formulation_friction_of(q->form->form, q->spec->dim, q->form->opt);
}

/* What none of the bounds tells of stays in: whether a contact has slid (friction_kinetic), which goes with how the feet of a body share its load,
 * and so with all that turns it; the plane where the facets of a cone do not lie in
 * it, or where turning in it turns a body out of it; and everything where bodies that are in each other are pushed apart. */
static base_status kept_in(const watch *w, unsigned *kept, base_error *err) {
  const sim_request *q = w->q;
  const scene_spec *spec = q->spec;
  const bool slid = spec->friction_kinetic.dflt >= 0.0 || spec->friction_kinetic.n_pair > 0;
  const bool aslant = has_friction(q) && friction_of(q).aslant;
  double depth = 0.0;
  if ((q->form->form->model & FORM_POSITION) != 0) {
    BASE_TRY(world_depth(w->s->w, &depth, err));
  }
  *kept = slid ? ~0u : 0u;
  *kept |= (spec->dim == 3 && (aslant || world_turns_out_of_plane(w->s->w))) ? EFFECT_SPATIAL : 0u;
  *kept |= (depth > 1e-9 * w->scale.size) ? ~0u : 0u;
  *kept &= w->result->watched;
  return BASE_OK;
}

/* Before the first step. */
static base_status keep_in(watch *w, base_error *err) {
  unsigned kept = 0;
  world_set_friction_reach(w->s->w, friction_of(w->q).most);
  if (w->result->watched != 0) {
    BASE_TRY(kept_in(w, &kept, err));
  }
  if (kept == 0) {
    return BASE_OK;
  }
  w->result->watched &= ~kept;
  return add_effects(w, kept, err);
}

base_status watch_run(const sim_request *q, double level, series *record, sim_result *out,
                      watch_result *result, base_error *err) {
  sim s;
  sim_request first = *q;
  *result = (watch_result){.level = level, .watched = unneeded(q)};
  result->plan.n = 1;
  result->plan.span[0].effects = first.effects = q->effects & ~result->watched;
  first.plan = NULL;
  watch w = {.s = &s, .q = q, .record = record, .result = result, .next = LONG_MAX};
  base_status done = sim_open(&s, &first, record, out, err);
  if (done == BASE_OK) {
    w.scale = deviation_scale_of(q->spec, s.w, q->duration);
    result->size = w.scale.size;
    result->speed = w.scale.speed;
    done = keep_in(&w, err);
  }
  if (done == BASE_OK) {
    done = run(&w, err);
  }
  if (done == BASE_OK) {
    sim_finish(&s, record);
    result->plan.sleep = out->n_asleep_max > 0;
  }
  deviation_close(&w.off);
  deviation_close(&w.before);
  free(w.inertia);
  free(w.point);
  free(s.grown);
  checkpoint_close(&w.clean);
  checkpoint_close(&w.last);
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

/* "friction from step 12", "friction to step 9, from step 12", or "dropped friction". */
static size_t print_effect(const effects_plan *p, int which, char *text, size_t cap) {
  size_t used = 0;
  bool in = false;
  for (int k = 0; k < p->n && used < cap; k++) {
    const bool now = (p->span[k].effects & 1u << which) != 0;
    if (now != in) {
      used += (size_t)snprintf(text + used, cap - used, "%s %s step %ld",
                               (used == 0) ? effect_name(which) : "", now ? "from" : "to",
                               p->span[k].from + (now ? 1 : 0));
    }
    in = now;
  }
  return (used > 0) ? used : (size_t)snprintf(text, cap, "dropped %s", effect_name(which));
}

void watch_print(const watch_result *r, unsigned declared, char text[EFFECTS_TEXT]) {
  size_t used = 0;
  text[0] = '\0';
  for (int i = 0; i < EFFECT_COUNT && used < EFFECTS_TEXT; i++) {
    const unsigned bit = 1u << i;
    if ((declared & (candidates | EFFECT_GYROSCOPIC) & bit) == 0) {
      continue;
    }
    used += (size_t)snprintf(text + used, EFFECTS_TEXT - used, "%s", (used > 0) ? ", " : "");
    if (used < EFFECTS_TEXT) {
      used += print_effect(&r->plan, i, text + used, EFFECTS_TEXT - used);
    }
  }
}
