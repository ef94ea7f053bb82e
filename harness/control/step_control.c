#include "harness/control/step_control.h"

#include "harness/control/checkpoint.h"
#include "lcp/base/fields.h"
#include "lcp/base/output.h"

#include <stdlib.h>
#include <string.h>

/* Share of the tolerance that each step with a change of contacts may take, and that every step may take: the error of a
 * very short one is that of its solves, however short it is. */
static const double event_share = 1.0 / 32.0, least_share = 1.0 / 16384.0;
/* PI control of a step whose error for a share that grows with it is of first order (Gustafsson 1991). */
static const double safety = 0.9, integral = 0.7, proportional = 0.4, shrink = 0.2, grow = 4.0;

/* One way over a step. */
typedef struct step_end {
  double *state;     /* where it ends: world_save */
  uint64_t carrying; /* the contacts that carried last */
  bool event;        /* others than before the step carried on the way */
  double sunk;       /* how much deeper than at its start bodies are in each other at its end [m] */
  bool good;         /* nothing failed */
} step_end;

typedef struct controlled {
  sim run;
  const step_rule *rule;
  series *record;
  step_list *kept;
  run_places *places;
  step_account *account;
  checkpoint start;
  step_end coarse, fine;
  bool failed;       /* a step of the shortest length has no solution: the run ends there */
  uint64_t carrying; /* of the last step kept */
  double fastest;    /* largest speed of a body so far [m/s] */
  double located;    /* of the step just tried [m] */
  double last;       /* error over its share, of the last step kept [1] */
} controlled;

/* ---- lists of steps -------------------------------------------------------------------------- */

static base_status append(step_list *l, double h, base_error *err) {
  if (l->n == l->cap) {
    const long cap = 2 * l->cap + 64;
    double *grown = realloc(l->h, (size_t)cap * sizeof *grown);
    if (grown == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory for %ld steps", cap);
    }
    l->h = grown;
    l->cap = cap;
  }
  l->h[l->n++] = h;
  return BASE_OK;
}

static base_status read_lines(step_list *l, FILE *from, const char *path, base_error *err) {
  char line[80];
  for (long at = 1; fgets(line, sizeof line, from) != NULL; at++) {
    double h;
    line[strcspn(line, "\n")] = '\0';
    if (!base_parse_real(line, &h) || !(h > 0.0)) {
      return BASE_FAIL(err, BASE_EINVAL, "%.200s, line %ld: need a step above 0 [s]", path, at);
    }
    BASE_TRY(append(l, h, err));
  }
  return BASE_OK;
}

base_status step_list_read(step_list *l, const char *path, double duration, base_error *err) {
  *l = (step_list){0};
  FILE *from = fopen(path, "r");
  if (from == NULL) {
    return BASE_FAIL(err, BASE_EIO, "%.200s: cannot be read", path);
  }
  const base_status done = read_lines(l, from, path, err);
  (void)fclose(from);
  BASE_TRY(done);
  double sum = 0.0;
  for (long i = 0; i < l->n; i++) {
    sum += l->h[i];
  }
  if (!(fabs(sum - duration) <= 1e-6 * duration)) {
    return BASE_FAIL(err, BASE_EINVAL, "%.200s: its steps cover %g s of a run of %g s", path, sum,
                     duration);
  }
  return BASE_OK;
}

base_status step_list_write(const step_list *l, const char *path, base_error *err) {
  base_out file;
  BASE_TRY(base_out_open(&file, path, err));
  for (long i = 0; i < l->n; i++) {
    (void)fprintf(file.to, "%.17g\n", l->h[i]);
  }
  return base_out_finish(&file, BASE_OK, err);
}

void step_list_close(step_list *l) {
  free(l->h);
  *l = (step_list){0};
}

/* ---- one step -------------------------------------------------------------------------------- */

/* `n` steps of h from where the run stands. */
static base_status go(controlled *c, double h, int n, step_end *end, base_error *err) {
  sim *s = &c->run;
  const run_status before = s->out->status;
  double start = 0.0;
  *end = (step_end){.state = end->state, .good = true};
  for (int i = 0; i < n && end->good; i++) {
    bool taken;
    BASE_TRY(sim_step(s, c->record, h, &taken, err));
    c->account->solved++;
    end->good = taken && s->out->status == before;
    end->carrying = s->carrying;
    end->event = end->event || s->carrying != c->carrying;
    start = (i == 0) ? s->depth[0] : start;
    end->sunk = fmax(0.0, s->depth[1] - start);
  }
  world_save(s->w, end->state);
  return BASE_OK;
}

/* How long a difference of velocities lasts: what is left of the run, or the time in which the fastest body has come as
 * far as the bodies get [s]. */
static double reach(const controlled *c) {
  const sim *s = &c->run;
  const double way = fmax(c->places->travel, c->places->size);
  const double left = fmax(s->q->duration - world_time(s->w), 0.0);
  return (c->fastest * left > way) ? way / c->fastest : left;
}

/* Error over the share that a step of h may take [1]. */
static double error_of(controlled *c, double h) {
  double position;
  double velocity;
  const sim *s = &c->run;
  const double end = s->q->duration;
  if (!c->coarse.good || !c->fine.good) {
    return HUGE_VAL;
  }
  world_saved_distance(s->w, c->coarse.state, c->fine.state, &position, &velocity);
  const bool event = c->coarse.event || c->fine.event;
  const double share = fmax(h / end, event ? event_share : least_share);
  c->located = event ? fmax(position, c->fine.sunk) : c->fine.sunk;
  const double e =
      fmax((position + velocity * reach(c)) / share, c->fine.sunk / fmax(h / end, event_share)) /
      c->rule->tolerance;
  return (e == e) ? e : HUGE_VAL;
}

/* By how much a step with error e over its share is shortened. An impact is met by halving: where it lies between the
 * middle and the end of a step, and only the finer way sees it, half of the step ends just behind it. */
static double shorter(const controlled *c, double e) {
  const bool met = c->coarse.event != c->fine.event || c->fine.sunk > 0.0;
  return fmin(fmax(safety / e, met ? 0.5 : shrink), 0.5);
}

/* Tries steps from *h downwards until one is kept; *h is then the proposal for the next, *taken what was kept. */
static base_status step(controlled *c, double *h, bool *limited, double *taken, base_error *err) {
  sim *s = &c->run;
  const step_rule *rule = c->rule;
  BASE_TRY(checkpoint_take(&c->start, s, c->record, err));
  for (;;) {
    if (c->account->solved + 3 > rule->limit) {
      *limited = true;
      return BASE_OK;
    }
    BASE_TRY(go(c, *h, 1, &c->coarse, err));
    BASE_TRY(checkpoint_return(&c->start, s, c->record, err));
    BASE_TRY(go(c, 0.5 * *h, 2, &c->fine, err));
    const double e = error_of(c, *h);
    const bool least = *h <= rule->least;
    if (e <= 1.0 || least) {
      c->account->forced += e > 1.0;
      c->failed = !c->fine.good;
      c->account->located = fmax(c->account->located, c->located);
      const double now = fmin(fmax(e, 1e-6), 1.0); /* a forced one says nothing of the next */
      const double factor = safety * pow(now, -integral) * pow(c->last, proportional);
      c->last = now;
      c->carrying = c->fine.carrying;
      *taken = *h;
      *h = fmax(*h * ((e > 1.0) ? grow : fmin(fmax(factor, shrink), grow)), rule->least);
      return BASE_OK;
    }
    c->account->rejected++;
    BASE_TRY(checkpoint_return(&c->start, s, c->record, err));
    *h = fmax(*h * shorter(c, e), rule->least);
  }
}

/* ---- the run --------------------------------------------------------------------------------- */

/* The part of the way to the next stop that a step of about h may take: all of it, or half. */
static double towards(double left, double h, double least) {
  return (h >= left - least) ? left : fmin(h, 0.5 * left);
}

void run_places_close(run_places *p) {
  free(p->start);
  *p = (run_places){0};
}

static base_status places_open(run_places *p, const world *w, base_error *err) {
  run_places_close(p);
  p->n = world_n_body(w);
  p->size = world_size(w);
  p->start = calloc(6 * (size_t)p->n + 1, sizeof *p->start);
  if (p->start == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the places of %d bodies", p->n);
  }
  p->end = p->start + 3 * (size_t)p->n;
  double quat[4];
  for (int i = 0; i < p->n; i++) {
    world_body_pose(w, i, p->start + 3 * (size_t)i, quat);
  }
  memcpy(p->end, p->start, 3 * (size_t)p->n * sizeof *p->end);
  return BASE_OK;
}

static void places_note(run_places *p, const world *w) {
  for (int i = 0; i < p->n; i++) {
    double quat[4];
    const double *from = p->start + 3 * (size_t)i;
    double *to = p->end + 3 * (size_t)i;
    world_body_pose(w, i, to, quat);
    p->travel = fmax(p->travel, sqrt(pow(to[0] - from[0], 2) + pow(to[1] - from[1], 2) +
                                     pow(to[2] - from[2], 2)));
  }
}

static base_status count(controlled *c, double h, base_error *err) {
  step_account *a = c->account;
  places_note(c->places, c->run.w);
  c->fastest = fmax(c->fastest, world_max_speed(c->run.w));
  a->least = fmin(a->least, h);
  a->most = fmax(a->most, h);
  return append(c->kept, h, err);
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
    const double wish = fmin(*h, c->rule->most);
    double next = towards(stop - world_time(s->w), wish, c->rule->least);
    const double asked = next;
    double taken = 0.0;
    BASE_TRY(step(c, &next, limited, &taken, err));
    if (!*limited) {
      /* a step cut short to end at a stop says nothing against the longer one */
      *h = (taken == asked && asked < wish) ? fmax(wish, next) : next;
      BASE_TRY(count(c, 0.5 * taken, err));
      BASE_TRY(count(c, 0.5 * taken, err));
      *limited = crawls(c);
    }
  }
  return BASE_OK;
}

/* One step of h unless the run is over or has solved its share. */
static base_status even_step(controlled *c, double h, bool *limited, base_error *err) {
  sim *s = &c->run;
  bool taken;
  *limited = c->account->solved >= c->rule->limit;
  if (*limited || world_time(s->w) >= s->q->duration) {
    return BASE_OK;
  }
  BASE_TRY(sim_step(s, c->record, h, &taken, err));
  c->account->solved++;
  return count(c, h, err);
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
  BASE_TRY(places_open(c->places, s->w, err));
  if (s->q->form->form->memory == 0) {
    BASE_TRY(run_even(c, &limited, err));
  } else {
    BASE_TRY(checkpoint_open(&c->start, s, err));
    const size_t n = world_saved_size(s->w);
    c->coarse.state = malloc(2 * n * sizeof *c->coarse.state);
    if (c->coarse.state == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory to compare steps");
    }
    c->fine.state = c->coarse.state + n;
    s->controlled = true;
    c->carrying = s->carrying;
    c->fastest = world_max_speed(s->w);
    double h = c->rule->first;
    for (int k = 0; k < c->rule->n_stop; k++) {
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
                  .record = record,
                  .kept = kept,
                  .places = places,
                  .account = account,
                  .last = 1.0};
  kept->n = 0;
  *account = (step_account){.least = HUGE_VAL};
  base_status done = sim_open(&c.run, q, record, out, err);
  if (done == BASE_OK) {
    done = run(&c, err);
  }
  checkpoint_close(&c.start);
  free(c.coarse.state);
  sim_close(&c.run);
  return done;
}
