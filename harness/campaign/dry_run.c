#include "harness/campaign/dry_run.h"

#include "harness/campaign/doctor.h"
#include "harness/campaign/outlook.h"
#include "harness/util/folder.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Rows that are there and count: those to be measured again do not. */
static base_status read_rows(const runner_options *o, record_table *rows, base_error *err) {
  char path[1100];
  folder_file(o->out, "results.csv", path, sizeof path);
  if (access(path, F_OK) != 0) {
    return BASE_OK;
  }
  BASE_TRY(runner_read_rows(o->out, rows, err));
  for (int i = 0; i < rows->n; i++) {
    if (runner_wanted_again(&rows->row[i], o)) {
      rows->row[i].base_hash[0] = '\0'; /* as if of another build */
    }
  }
  return BASE_OK;
}

/* Rows of an earlier run, of any build: they tell how long cells take, and nothing of what is done. */
static base_status read_earlier(const char *dir, record_table *rows, base_error *err) {
  return (dir != NULL) ? runner_read_rows(dir, rows, err) : BASE_OK;
}

typedef struct reckoning {
  int done, todo, unknown; /* processes; of unknown duration */
  double known, doctor;    /* [s] of the others, and of the noise floor */
  int reached;             /* units before which the budget is not spent */
} reckoning;

static void print_cell(const plan *p, const cell *c, bool todo) {
  char command[1200];
  (void)cell_command(c, &p->campaign->limits, command, sizeof command);
  (void)printf("%s %s %s %s\n", todo ? "todo" : "done", c->id, c->part, command);
}

/* The cells in their order, and what is left of each. */
static base_status print_cells(const plan *p, const bool *done, base_error *err) {
  bool *todo = calloc((size_t)p->n_cell + 1, sizeof *todo);
  if (todo == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the plan");
  }
  for (int u = 0; u < p->n_unit; u++) {
    todo[p->unit[u].cell] = todo[p->unit[u].cell] || !done[u];
  }
  for (int u = 0; u < p->n_unit; u++) {
    if (p->unit[u].process == 0) {
      print_cell(p, &p->cell[p->unit[u].cell], todo[p->unit[u].cell]);
    }
  }
  free(todo);
  return BASE_OK;
}

/* Each cell's duration is asked for once: of[n_cell], negative where it was not. */
static void add_unit(const plan *p, int u, const outlook *earlier, outlook_cell *of,
                     reckoning *sum) {
  const int k = p->unit[u].cell;
  if (of[k].first < 0.0) {
    of[k] = outlook_ask(earlier, p, &p->cell[k]);
  }
  const double seconds = (p->unit[u].process == 0) ? of[k].first : of[k].later;
  sum->todo++;
  sum->known += (seconds < HUGE_VAL) ? seconds : 0.0;
  sum->unknown += (seconds < HUGE_VAL) ? 0 : 1;
}

static double usual_seconds(const campaign *c) {
  return fmin(c->limits.time, c->sampling.budget);
}

/* [s] */
static double spent(const plan *p, const reckoning *s) {
  return s->known + s->unknown * usual_seconds(p->campaign) + s->doctor;
}

static base_status reckon(const plan *p, const bool *done, const outlook *earlier, double budget,
                          reckoning *sum, base_error *err) {
  outlook_cell *of = malloc(((size_t)p->n_cell + 1) * sizeof *of);
  if (of == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d cells", p->n_cell);
  }
  for (int k = 0; k < p->n_cell; k++) {
    of[k].first = -1.0;
  }
  for (int u = 0; u < p->n_unit; u++) {
    sum->done += done[u] ? 1 : 0;
    if (!done[u]) {
      add_unit(p, u, earlier, of, sum);
    }
    sum->reached = (spent(p, sum) <= budget) ? u + 1 : sum->reached;
  }
  free(of);
  return BASE_OK;
}

/* The cells that a budget reaches, stage by stage: all of each stage before the one in which it ends. */
static void print_budget(const plan *p, const cover *order, double budget, const reckoning *s) {
  const int processes = p->campaign->sampling.processes;
  int cells[COVER_STAGE_COUNT] = {0};
  int reached[COVER_STAGE_COUNT] = {0};
  for (int k = 0; k < order->n; k++) {
    cells[order->stage[k]]++;
    reached[order->stage[k]] += ((k + 1) * processes <= s->reached) ? 1 : 0;
  }
  (void)printf("a budget of %.0f s reaches about %d of %d cells:", budget, s->reached / processes,
               order->n);
  for (int i = 0; i < COVER_STAGE_COUNT; i++) {
    (void)printf("%s %d of %d by %s", i > 0 ? "," : "", reached[i], cells[i],
                 cover_stage_name((cover_stage)i));
  }
  (void)printf("\n");
}

static void print_reckoning(const plan *p, const reckoning *s) {
  const campaign *c = p->campaign;
  const double usual = usual_seconds(c);
  const double longest = c->limits.time + c->limits.grace;
  (void)printf("%d cells, %d processes: %d done, %d to do; about %.0f s (%.3g s by earlier rows, %d"
               " processes of %.3g s each, %.3g s for the noise floor), by the limits at most"
               " %.0f s\n",
               p->n_cell, p->n_unit, s->done, s->todo, spent(p, s), s->known, s->unknown, usual,
               s->doctor, s->todo * longest + s->doctor);
}

static base_status print_plan(const plan *p, const runner_options *o, const record_table rows[2],
                              double doctor, base_error *err) {
  outlook earlier = {0};
  reckoning sum = {.doctor = doctor};
  bool *done = calloc((size_t)p->n_unit + 1, sizeof *done);
  base_status s = (done != NULL) ? runner_done(p, &rows[0], done, err)
                                 : BASE_FAIL(err, BASE_ENOMEM, "no memory for the plan");
  if (s == BASE_OK) {
    s = print_cells(p, done, err);
  }
  if (s == BASE_OK) {
    s = outlook_open(&earlier, rows, 2, err);
  }
  if (s == BASE_OK) {
    s = reckon(p, done, &earlier, o->budget, &sum, err);
  }
  if (s == BASE_OK && o->order != NULL) {
    print_budget(p, o->order, o->budget, &sum);
  }
  if (s == BASE_OK) {
    print_reckoning(p, &sum);
  }
  outlook_close(&earlier);
  free(done);
  return s;
}

base_status dry_run(const plan *p, const runner_options *o, const char *like, base_error *err) {
  record_table rows[2] = {{0}, {0}}; /* of DIR, and of an earlier run */
  bool due = true;
  BASE_TRY(doctor_due(o->out, &due, err));
  base_status s = read_rows(o, &rows[0], err);
  if (s == BASE_OK) {
    s = read_earlier(like, &rows[1], err);
  }
  if (s == BASE_OK) {
    s = print_plan(p, o, rows, due ? p->campaign->sampling.doctor : 0.0, err);
  }
  record_table_free(&rows[0]);
  record_table_free(&rows[1]);
  return s;
}
