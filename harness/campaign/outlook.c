#include "harness/campaign/outlook.h"

#include "harness/campaign/ladder.h"
#include "harness/campaign/runner.h"
#include "harness/measure/verdict.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of a process: to start and to write its rows [s], and its time over that of the evaluations that are clocked: the
 * judge, the checks and the stored answers are not. Both from the quick campaigns of results/reference. */
static const double START = 0.005, UNCLOCKED = 1.3;

static bool was_killed(const record *r) {
  return strcmp(r->status, run_status_name(RUN_TIMEOUT)) == 0;
}

/* The mean over the rows of one cell. */
static double evaluation(const row_ref *row, int n) {
  double sum = 0.0;
  int timed = 0;
  for (int i = 0; i < n; i++) {
    if (row[i].r->t_total_s >= 0.0) {
      sum += row[i].r->t_total_s;
      timed++;
    }
  }
  return (timed > 0) ? sum / timed : was_killed(row[0].r) ? -1.0 : 0.0;
}

static int by_problem(const void *a, const void *b) {
  return strcmp(((const outlook_row *)a)->r->problem, ((const outlook_row *)b)->r->problem);
}

base_status outlook_open(outlook *out, const record_table *rows, int n_table, base_error *err) {
  int total = 0;
  for (int t = 0; t < n_table; t++) {
    total += rows[t].n;
  }
  *out = (outlook){calloc((size_t)total + 1, sizeof *out->row), 0};
  if (out->row == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d rows", total);
  }
  for (int t = 0; t < n_table; t++) {
    row_ref *by_cell = NULL;
    BASE_TRY(record_table_by_cell(&rows[t], &by_cell, err));
    for (int i = 0, n; i < rows[t].n; i += n) {
      n = record_same_cell(by_cell + i, rows[t].n - i);
      out->row[out->n++] = (outlook_row){by_cell[i].r, evaluation(by_cell + i, n)};
    }
    free(by_cell);
  }
  qsort(out->row, (size_t)out->n, sizeof *out->row, by_problem);
  return BASE_OK;
}

void outlook_close(outlook *o) {
  free(o->row);
  *o = (outlook){0};
}

/* Is `name` what `text`, NAME or NAME:options, calls? */
static bool calls(const char *text, const char *name) {
  const size_t n = strcspn(text, ":");
  return strlen(name) == n && strncmp(text, name, n) == 0;
}

enum { SAME_PART = 1, SAME_FORMULATION = 2, SAME_FAMILY = 4, SAME_SOLVER = 8, SAME_PROBLEM = 16 };

static int agreement(const cell *c, const record *r) {
  return (strcmp(c->problem, r->problem) == 0 ? SAME_PROBLEM : 0) +
         (calls(c->solver, r->solver) ? SAME_SOLVER : 0) +
         (ladder_same_family(c->problem, r->problem) ? SAME_FAMILY : 0) +
         (calls(c->formulation, r->formulation) ? SAME_FORMULATION : 0) +
         (strcmp(c->part, r->part) == 0 ? SAME_PART : 0);
}

/* Steps of the cell over those of the row, where both tell. A duration of the cell's own comes before that of its problem. */
static double more_steps(const cell *c, const record *r) {
  const double h = strtod(c->step, NULL);
  const double own = strtod(c->duration, NULL);
  const double duration = (own > 0.0) ? own : ladder_value(c->problem, "duration", 0.0);
  const double finer = (h > 0.0 && r->step_s > 0.0) ? r->step_s / h : 1.0;
  return finer * ((duration > 0.0 && r->duration_s > 0.0) ? duration / r->duration_s : 1.0);
}

/* One evaluation of the cell as this row foretells it [s]. */
static double foretold(const outlook_row *row, const cell *c, double limit) {
  if (row->seconds >= 0.0) {
    return fmin(row->seconds * more_steps(c, row->r), limit);
  }
  const double was = row->r->t_limit_s;
  return (was > 0.0 && was < limit) ? sqrt(was * limit) : limit;
}

/* The whole process: a warm-up, unless one sample is all that is asked, and samples until the budget is spent. */
static double process_seconds(const campaign *c, double evaluation) {
  const campaign_sampling *s = &c->sampling;
  const double usual = 0.5 * (s->samples + s->max_samples);
  const double sample = (s->max_samples > 1) ? fmax(evaluation, s->inner) : evaluation;
  const double samples = fmin(usual, 1.0 + floor(s->budget / fmax(sample, 1e-9)));
  const double warm_up = (s->max_samples > 1) ? 1.0 : 0.0;
  const double whole = START + UNCLOCKED * (warm_up + samples) * sample;
  return fmin(whole, c->limits.time + c->limits.grace);
}

/* The first row of a problem, or of the next one. */
static int first_of(const outlook *o, const char *problem) {
  int from = 0;
  int to = o->n;
  while (from < to) {
    const int mid = from + (to - from) / 2;
    if (strcmp(o->row[mid].r->problem, problem) < 0) {
      from = mid + 1;
    } else {
      to = mid;
    }
  }
  return from;
}

/* Sums over the rows that tell of a cell. */
typedef struct telling {
  outlook_cell sum;
  int n;
} telling;

static void add_row(telling *t, const outlook_row *row, double growth, const campaign *m,
                    const cell *c) {
  const bool refused = row->seconds == 0.0;
  const bool killed = row->seconds < 0.0;
  const double evaluation =
      refused ? 0.0 : fmin(foretold(row, c, m->limits.time) * growth, m->limits.time);
  const double seconds = refused ? START : process_seconds(m, evaluation);
  const bool ends = evaluation >= m->limits.time || (!killed && runner_ends_cell(row->r));
  t->sum.refused = t->sum.refused && refused;
  t->sum.first += seconds;
  t->sum.later += ends ? 0.0 : seconds;
  t->n++;
}

/* Rows i of the range that agree with the cell in so much. */
typedef struct agreeing {
  const outlook *o;
  const cell *c;
  int from, to, best;
} agreeing;

static const outlook_row *row_of(const agreeing *a, int i) {
  const outlook_row *row = &a->o->row[i];
  return (agreement(a->c, row->r) == a->best) ? row : NULL;
}

/* Of other rungs of the family the nearest ones tell, and all of them how the time grows. */
static telling ask_family(const agreeing *a, const campaign *m) {
  telling t = {{0.0, 0.0, true}, 0};
  double nearest = HUGE_VAL;
  ladder l;
  ladder_begin(&l, a->c->problem);
  for (int i = a->from; i < a->to; i++) {
    const outlook_row *row = row_of(a, i);
    if (row != NULL && row->seconds != 0.0) {
      ladder_add(&l, row->r->problem, fmax(foretold(row, a->c, m->limits.time), 1e-9));
    }
    nearest = (row != NULL) ? fmin(nearest, ladder_distance(&l, row->r->problem)) : nearest;
  }
  for (int i = a->from; i < a->to; i++) {
    const outlook_row *row = row_of(a, i);
    if (row != NULL && ladder_distance(&l, row->r->problem) <= nearest) {
      add_row(&t, row, ladder_growth(&l, row->r->problem), m, a->c);
    }
  }
  return t;
}

static telling ask_all(const agreeing *a, const campaign *m) {
  telling t = {{0.0, 0.0, true}, 0};
  for (int i = a->from; i < a->to; i++) {
    const outlook_row *row = row_of(a, i);
    if (row != NULL) {
      add_row(&t, row, 1.0, m, a->c);
    }
  }
  return t;
}

outlook_cell outlook_ask(const outlook *o, const plan *p, const cell *c) {
  agreeing a = {.o = o, .c = c, .from = first_of(o, c->problem), .best = 0};
  const bool known = a.from < o->n && strcmp(o->row[a.from].r->problem, c->problem) == 0;
  a.from = known ? a.from : 0;
  const int first = a.from;
  for (int i = first; i < o->n; i++) {
    const int agrees = agreement(c, o->row[i].r);
    if (known && agrees < SAME_PROBLEM) {
      break;
    }
    if (agrees > a.best) {
      a.best = agrees;
      a.from = i;
    }
    a.to = (agrees == a.best) ? i + 1 : a.to;
  }
  if (a.best == 0) {
    return (outlook_cell){HUGE_VAL, HUGE_VAL, false};
  }
  const bool family = !known && (a.best & SAME_FAMILY) != 0;
  const telling t = family ? ask_family(&a, p->campaign) : ask_all(&a, p->campaign);
  return (outlook_cell){t.sum.first / t.n, t.sum.later / t.n, t.sum.refused};
}
