#include "harness/plan/cover.h"

#include <stdlib.h>
#include <string.h>

#define STAGE_NAME_(name) #name,
static const char *const stage_names[] = {COVER_STAGES(STAGE_NAME_)};

const char *cover_stage_name(cover_stage s) {
  return stage_names[s];
}

base_status cover_stage_find(const char *name, cover_stage *out, base_error *err) {
  for (int i = 0; i < COVER_STAGE_COUNT; i++) {
    if (strcmp(stage_names[i], name) == 0) {
      *out = (cover_stage)i;
      return BASE_OK;
    }
  }
  return BASE_FAIL(err, BASE_EINVAL, "--stage %.60s: need quick, values, pairs or rest", name);
}

/* ---- what a cell brings -----------------------------------------------------------------------*/

/* Of every cell: its part, a value of every axis, the names alone of problem, formulation and solver (so that a new name
 * comes before another option of a known one), and the pairs of values. */
enum {
  NAMES = 3,
  VALUES = 1 + AXIS_COUNT + NAMES,
  PAIRS = AXIS_COUNT * (AXIS_COUNT - 1) / 2,
  BRINGS = VALUES + PAIRS
};

/* One of them, before it has a number: value and other by their place among the sorted texts, -1 for none. */
typedef struct feature {
  int part, kind, value, other;
} feature;

static int by_feature(const void *a, const void *b) {
  const feature *x = a;
  const feature *y = b;
  const int of_x[] = {x->part, x->kind, x->value, x->other};
  const int of_y[] = {y->part, y->kind, y->value, y->other};
  int k = 0;
  while (k < BASE_COUNT(of_x) - 1 && of_x[k] == of_y[k]) {
    k++;
  }
  return (of_x[k] > of_y[k]) - (of_x[k] < of_y[k]);
}

/* By the name before the colon, then by the options. */
static int by_name(const void *a, const void *b) {
  const char *x = *(const char *const *)a;
  const char *y = *(const char *const *)b;
  const size_t n = strcspn(x, ":");
  const size_t m = strcspn(y, ":");
  const int names = memcmp(x, y, (n < m) ? n : m);
  const int lengths = (n > m) - (n < m);
  return (names != 0) ? names : (lengths != 0) ? lengths : strcmp(x + n, y + m);
}

typedef struct texts {
  int n;
  const char **text; /* the plan's, sorted by name; owned */
  int *name;         /* [n] the first text with the same name; owned */
} texts;

static int place_of(const texts *t, const char *text) {
  const char **found = bsearch(&text, t->text, (size_t)t->n, sizeof *t->text, by_name);
  return (int)(found - t->text);
}

static base_status texts_open(texts *t, const plan *p, base_error *err) {
  t->n = p->store.n;
  t->text = calloc((size_t)t->n + 1, sizeof *t->text);
  t->name = calloc((size_t)t->n + 1, sizeof *t->name);
  if (t->text == NULL || t->name == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d texts", t->n);
  }
  for (int i = 0; i < t->n; i++) {
    t->text[i] = p->store.item[i];
  }
  qsort(t->text, (size_t)t->n, sizeof *t->text, by_name);
  for (int i = 0; i < t->n; i++) {
    const size_t n = strcspn(t->text[i], ":");
    const bool same =
        i > 0 && strcspn(t->text[i - 1], ":") == n && memcmp(t->text[i - 1], t->text[i], n) == 0;
    t->name[i] = same ? t->name[i - 1] : i;
  }
  return BASE_OK;
}

void cell_values(const cell *c, const char *value[AXIS_COUNT]) {
  const char *const of[AXIS_COUNT] = {[AXIS_problems] = c->problem,
                                      [AXIS_formulations] = c->formulation,
                                      [AXIS_solvers] = c->solver,
                                      [AXIS_steps] = c->step,
                                      [AXIS_durations] = c->duration,
                                      [AXIS_tolerances] = c->tol,
                                      [AXIS_starts] = c->start,
                                      [AXIS_effects] = c->effects,
                                      [AXIS_contact_orders] = c->contact_order,
                                      [AXIS_islands] = c->islands};
  memcpy(value, of, sizeof of);
}

static void features_of(const texts *t, const cell *c, feature out[BRINGS]) {
  static const int named[NAMES] = {AXIS_problems, AXIS_formulations, AXIS_solvers};
  const char *value[AXIS_COUNT];
  int at[AXIS_COUNT];
  const int part = place_of(t, c->part);
  int n = 0;
  int kind = 0;
  cell_values(c, value);
  for (int a = 0; a < AXIS_COUNT; a++) {
    at[a] = place_of(t, value[a]);
  }
  out[n++] = (feature){part, kind++, -1, -1};
  for (int a = 0; a < AXIS_COUNT; a++) {
    out[n++] = (feature){part, kind++, at[a], -1};
  }
  for (int i = 0; i < NAMES; i++) {
    out[n++] = (feature){part, kind++, t->name[at[named[i]]], -1};
  }
  for (int a = 0; a < AXIS_COUNT; a++) {
    for (int b = a + 1; b < AXIS_COUNT; b++) {
      out[n++] = (feature){part, kind++, at[a], at[b]};
    }
  }
}

/* ---- the greedy cover -------------------------------------------------------------------------*/

typedef struct candidate {
  int cell;
  double seconds;
  bool quick, refused, taken;
} candidate;

/* A cell in the order of its texts. */
typedef struct listed {
  const cell *cell;
} listed;

typedef struct covering {
  texts texts;
  int n;
  candidate *of; /* [n] cells with units, cheap ones first; owned */
  int *brings;   /* [n_cell, BRINGS] numbers of features; owned */
  bool *covered; /* [features]; owned */
  feature *all;  /* [n_cell * BRINGS], sorted; owned */
  listed *q;     /* the quick form's cells, sorted; owned */
  int n_quick;
  cover *out;
} covering;

static int by_cost(const void *a, const void *b) {
  const candidate *x = a;
  const candidate *y = b;
  const int costs = (x->seconds > y->seconds) - (x->seconds < y->seconds);
  return (costs != 0) ? costs : (x->cell > y->cell) - (x->cell < y->cell);
}

/* By all texts: the same experiment, in whatever form. */
static int by_texts(const void *a, const void *b) {
  const cell *x = ((const listed *)a)->cell;
  const cell *y = ((const listed *)b)->cell;
  const char *of_x[AXIS_COUNT];
  const char *of_y[AXIS_COUNT];
  int order = strcmp(x->part, y->part);
  cell_values(x, of_x);
  cell_values(y, of_y);
  for (int i = 0; order == 0 && i < AXIS_COUNT; i++) {
    order = strcmp(of_x[i], of_y[i]);
  }
  return order;
}

static void take(covering *s, candidate *c, cover_stage stage) {
  const int *brings = s->brings + (size_t)c->cell * BRINGS;
  for (int i = 0; i < BRINGS; i++) {
    s->covered[brings[i]] = true;
  }
  c->taken = true;
  s->out->cell[s->out->n] = c->cell;
  s->out->stage[s->out->n++] = stage;
}

static int gain(const covering *s, const candidate *c, int from, int to) {
  const int *brings = s->brings + (size_t)c->cell * BRINGS;
  int n = 0;
  for (int i = from; i < to; i++) {
    n += s->covered[brings[i]] ? 0 : 1;
  }
  return n;
}

/* Takes who brings something new of [from, to), the most first. No cell ever brings more than it did, so one pass for
 * each gain takes them in the order of a search for the largest one. */
static void cover_new(covering *s, bool quick, int from, int to, cover_stage stage) {
  for (int refused = 0; refused < 2; refused++) {
    for (int g = to - from; g > 0; g--) {
      for (int i = 0; i < s->n; i++) {
        candidate *c = &s->of[i];
        if (!c->taken && (c->quick || !quick) && c->refused == (refused == 1) &&
            gain(s, c, from, to) == g) {
          take(s, c, stage);
        }
      }
    }
  }
}

static void take_rest(covering *s, bool quick, cover_stage stage) {
  for (int i = 0; i < s->n; i++) {
    if (!s->of[i].taken && (s->of[i].quick || !quick)) {
      take(s, &s->of[i], stage);
    }
  }
}

static base_status allocate(covering *s, const plan *p, const plan *quick, base_error *err) {
  const size_t n = (size_t)p->n_cell + 1;
  s->of = calloc(n, sizeof *s->of);
  s->brings = calloc(n * BRINGS, sizeof *s->brings);
  s->covered = calloc(n * BRINGS, sizeof *s->covered);
  s->all = calloc(n * BRINGS, sizeof *s->all);
  s->q = calloc((size_t)quick->n_cell + 1, sizeof *s->q);
  s->out->cell = calloc(n, sizeof *s->out->cell);
  s->out->stage = calloc(n, sizeof *s->out->stage);
  return (s->of != NULL && s->brings != NULL && s->covered != NULL && s->all != NULL &&
          s->q != NULL && s->out->cell != NULL && s->out->stage != NULL)
             ? BASE_OK
             : BASE_FAIL(err, BASE_ENOMEM, "no memory to order %d cells", p->n_cell);
}

/* Features become numbers: their places among all, sorted. */
static void number_features(covering *s, const plan *p) {
  const size_t n = (size_t)p->n_cell * BRINGS;
  feature one[BRINGS];
  for (int i = 0; i < p->n_cell; i++) {
    features_of(&s->texts, &p->cell[i], s->all + (size_t)i * BRINGS);
  }
  qsort(s->all, n, sizeof *s->all, by_feature);
  size_t distinct = 0;
  for (size_t i = 0; i < n; i++) {
    if (i == 0 || by_feature(&s->all[i], &s->all[distinct - 1]) != 0) {
      s->all[distinct++] = s->all[i];
    }
  }
  for (int i = 0; i < p->n_cell; i++) {
    features_of(&s->texts, &p->cell[i], one);
    for (int k = 0; k < BRINGS; k++) {
      const feature *found = bsearch(&one[k], s->all, distinct, sizeof *s->all, by_feature);
      s->brings[(size_t)i * BRINGS + (size_t)k] = (int)(found - s->all);
    }
  }
}

static void list_candidates(covering *s, const plan *p, const plan *quick, const cover_hint *hint) {
  s->n_quick = quick->n_cell;
  for (int i = 0; i < quick->n_cell; i++) {
    s->q[i].cell = &quick->cell[i];
  }
  qsort(s->q, (size_t)s->n_quick, sizeof *s->q, by_texts);
  for (int u = 0; u < p->n_unit; u++) {
    const int i = p->unit[u].cell;
    const listed c = {&p->cell[i]};
    if (p->unit[u].process == 0) {
      s->of[s->n++] = (candidate){
          .cell = i,
          .seconds = hint[i].seconds,
          .refused = hint[i].refused,
          .quick = bsearch(&c, s->q, (size_t)s->n_quick, sizeof *s->q, by_texts) != NULL};
    }
  }
  qsort(s->of, (size_t)s->n, sizeof *s->of, by_cost);
}

base_status cover_make(const plan *p, const plan *quick, const cover_hint *hint, cover *out,
                       base_error *err) {
  covering s = {.out = out};
  *out = (cover){0};
  base_status done = texts_open(&s.texts, p, err);
  if (done == BASE_OK) {
    done = allocate(&s, p, quick, err);
  }
  if (done == BASE_OK) {
    number_features(&s, p);
    list_candidates(&s, p, quick, hint);
    cover_new(&s, true, 0, VALUES, COVER_quick);
    cover_new(&s, true, VALUES, BRINGS, COVER_quick);
    take_rest(&s, true, COVER_quick);
    cover_new(&s, false, 0, VALUES, COVER_values);
    cover_new(&s, false, VALUES, BRINGS, COVER_pairs);
    take_rest(&s, false, COVER_rest);
  } else {
    cover_free(out);
  }
  free(s.texts.text);
  free(s.texts.name);
  free(s.of);
  free(s.brings);
  free(s.covered);
  free(s.all);
  free(s.q);
  return done;
}

void cover_free(cover *c) {
  free(c->cell);
  free(c->stage);
  *c = (cover){0};
}

int cover_until(const cover *c, cover_stage last) {
  int n = 0;
  while (n < c->n && c->stage[n] <= last) {
    n++;
  }
  return n;
}

void cover_order(const cover *c, plan *p) {
  const int processes = p->campaign->sampling.processes;
  for (int k = 0, u = 0; k < c->n; k++) {
    for (int process = 0; process < processes; process++) {
      p->unit[u++] = (unit){c->cell[k], process};
    }
  }
}
