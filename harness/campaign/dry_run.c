#include "harness/campaign/dry_run.h"

#include "harness/campaign/doctor.h"
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

/* Seconds of a process of this cell in earlier rows; HUGE_VAL if none. */
static double seen_seconds(const record_table *rows, const char *id) {
  double sum = 0.0;
  int processes = 0;
  for (int i = 0; i < rows->n; i++) {
    const record *r = &rows->row[i];
    if (strcmp(r->cell_id, id) == 0 && r->t_total_s >= 0) {
      sum += r->t_total_s * (double)r->n_inner;
      processes += (r->rep == 0) ? 1 : 0;
    }
  }
  return (processes > 0) ? sum / processes : HUGE_VAL;
}

typedef struct outlook {
  int done, todo, unknown; /* processes; of unknown duration */
  double known, doctor;    /* [s] of the others, and of the noise floor */
} outlook;

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

static void add_unit(const plan *p, int u, bool done, const record_table *rows, outlook *sum) {
  const cell *c = &p->cell[p->unit[u].cell];
  if (done) {
    sum->done++;
    return;
  }
  const double seconds = seen_seconds(rows, c->id);
  sum->todo++;
  sum->known += (seconds < HUGE_VAL) ? seconds : 0.0;
  sum->unknown += (seconds < HUGE_VAL) ? 0 : 1;
}

static void print_outlook(const plan *p, const outlook *s) {
  const campaign *c = p->campaign;
  const double usual = fmin(c->limits.time, c->sampling.budget);
  const double longest = c->limits.time + c->limits.grace;
  (void)printf("%d cells, %d processes: %d done, %d to do; about %.0f s (%.3g s by earlier rows, %d"
               " processes of %.3g s each, %.3g s for the noise floor), by the limits at most"
               " %.0f s\n",
               p->n_cell, p->n_unit, s->done, s->todo, s->known + s->unknown * usual + s->doctor,
               s->known, s->unknown, usual, s->doctor, s->todo * longest + s->doctor);
}

base_status dry_run(const plan *p, const runner_options *o, base_error *err) {
  record_table rows = {0};
  outlook sum = {0};
  bool due = true;
  BASE_TRY(doctor_due(o->out, &due, err));
  sum.doctor = due ? p->campaign->sampling.doctor : 0.0;
  BASE_TRY(read_rows(o, &rows, err));
  bool *done = calloc((size_t)p->n_unit + 1, sizeof *done);
  base_status s = (done != NULL) ? runner_done(p, &rows, done, err)
                                 : BASE_FAIL(err, BASE_ENOMEM, "no memory for the plan");
  if (s == BASE_OK) {
    s = print_cells(p, done, err);
  }
  for (int u = 0; s == BASE_OK && u < p->n_unit; u++) {
    add_unit(p, u, done[u], &rows, &sum);
  }
  if (s == BASE_OK) {
    print_outlook(p, &sum);
  }
  free(done);
  record_table_free(&rows);
  return s;
}
