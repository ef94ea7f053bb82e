/* lcpbench status: what a campaign folder holds. */
#include "harness/campaign/account.h"
#include "harness/campaign/runner.h"
#include "harness/cell/stats.h"
#include "harness/cli/cli.h"
#include "harness/measure/verdict.h"
#include "harness/util/json_file.h"
#include "harness/util/table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char *const flag_words[] = {
    "zero_iterations", "fallback",     "allocates", "same_bits",  "not_repeatable",
    "twin_differs",    "canary_drift", "outlier",   "remeasured", "first_run"};

typedef struct status_counts {
  int cells, missed, by_status[RUN_STATUS_COUNT], by_flag[BASE_COUNT(flag_words)];
  double slow, fast; /* canary [s] */
} status_counts;

static void count_row(const record *r, status_counts *c) {
  for (int i = 0; i < BASE_COUNT(flag_words); i++) {
    c->by_flag[i] += record_has_flag(r, flag_words[i]) ? 1 : 0;
  }
  if (r->canary_s > 0.0) {
    c->slow = (r->canary_s > c->slow) ? r->canary_s : c->slow;
    c->fast = (c->fast == 0.0 || r->canary_s < c->fast) ? r->canary_s : c->fast;
  }
}

static void count_cell(const row_ref *row, int n, status_counts *c) {
  int64_t missed = 0;
  for (int i = 0; i < n; i++) {
    count_row(row[i].r, c);
    missed = (row[i].r->n_predictions_missed > missed) ? row[i].r->n_predictions_missed : missed;
  }
  c->cells++;
  c->missed += (missed > 0) ? 1 : 0;
  c->by_status[runner_cell_status(row, n)]++;
}

static base_status count_rows(const record_table *t, status_counts *c, base_error *err) {
  row_ref *row;
  BASE_TRY(record_table_by_cell(t, &row, err));
  for (int i = 0; i < t->n;) {
    const int same = record_same_cell(row + i, t->n - i);
    count_cell(row + i, same, c);
    i += same;
  }
  free(row);
  return BASE_OK;
}

static void print_status(const record_table *t, const status_counts *c, const char *dir) {
  (void)printf("%s: %d rows of %d cells%s\n", dir, t->n, c->cells,
               t->torn ? ", the last row is torn (the next run drops it)" : "");
  for (int s = 0; s < RUN_STATUS_COUNT; s++) {
    if (c->by_status[s] > 0) {
      (void)printf("  %-11s %d\n", run_status_name((run_status)s), c->by_status[s]);
    }
  }
  (void)printf("  %d cells miss a prediction\n", c->missed);
  for (int i = 0; i < BASE_COUNT(flag_words); i++) {
    if (c->by_flag[i] > 0) {
      (void)printf("  %d rows flagged %s\n", c->by_flag[i], flag_words[i]);
    }
  }
  if (c->fast > 0.0 && c->slow > 1.03 * c->fast) {
    (void)printf("  the canary drifted by %.1f %%: times are not comparable throughout\n",
                 100.0 * (c->slow / c->fast - 1.0));
  }
}

/* What the run in this folder has left out, by its manifest. A file of rows has none. */
static base_status print_left(const char *dir, int n_cell, base_error *err) {
  json_t *manifest = NULL;
  struct stat st;
  if (stat(dir, &st) != 0 || !S_ISDIR(st.st_mode)) {
    return BASE_OK;
  }
  BASE_TRY(json_file_read(dir, "manifest.json", &manifest, err));
  json_t *cut = json_object_get(manifest, "cut");
  if (cut != NULL) {
    account_print(cut, n_cell, stdout);
  }
  json_decref(manifest);
  return BASE_OK;
}

/* ---- by combination -------------------------------------------------------------------------- */

typedef struct combination {
  char formulation[400], solver[400]; /* with their options */
  int cells, verified, missed, by_status[RUN_STATUS_COUNT];
  double *time; /* [s] of the rows that are ok and verified, owned */
  int n_time, cap;
} combination;

typedef struct combinations {
  combination *item;
  int n, cap;
} combinations;

static void name_with(const char *name, const char *options, char buf[400]) {
  (void)snprintf(buf, 400, "%s%s%s", name, options[0] != '\0' ? ":" : "", options);
}

/* Room for one more; BASE_ENOMEM. */
static base_status grow(void **item, int n, int *cap, size_t size, base_error *err) {
  if (n < *cap) {
    return BASE_OK;
  }
  const int more = (*cap > 0) ? 2 * *cap : 16;
  void *grown = realloc(*item, (size_t)more * size);
  if (grown == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a table");
  }
  *item = grown;
  *cap = more;
  return BASE_OK;
}

static base_status find_combination(combinations *all, const record *r, combination **out,
                                    base_error *err) {
  combination c = {0};
  name_with(r->formulation, r->formulation_options, c.formulation);
  name_with(r->solver, r->solver_options, c.solver);
  for (int i = 0; i < all->n; i++) {
    *out = &all->item[i];
    if (strcmp((*out)->formulation, c.formulation) == 0 && strcmp((*out)->solver, c.solver) == 0) {
      return BASE_OK;
    }
  }
  void *item = all->item;
  const base_status done = grow(&item, all->n, &all->cap, sizeof *all->item, err);
  all->item = item;
  BASE_TRY(done);
  all->item[all->n] = c;
  *out = &all->item[all->n++];
  return BASE_OK;
}

/* A cell is verified where all of its rows are. */
static base_status add_cell(combinations *all, const row_ref *row, int n, base_error *err) {
  combination *c;
  BASE_TRY(find_combination(all, row[0].r, &c, err));
  const run_status word = runner_cell_status(row, n);
  bool verified = true;
  bool missed = false;
  for (int i = 0; i < n; i++) {
    const record *r = row[i].r;
    verified = verified && r->verified == 1;
    missed = missed || r->n_predictions_missed > 0;
    if (word == RUN_OK && r->verified == 1 && isfinite(r->t_total_s)) {
      void *time = c->time;
      const base_status done = grow(&time, c->n_time, &c->cap, sizeof *c->time, err);
      c->time = time;
      BASE_TRY(done);
      c->time[c->n_time++] = r->t_total_s;
    }
  }
  c->cells++;
  c->by_status[word]++;
  c->verified += verified ? 1 : 0;
  c->missed += missed ? 1 : 0;
  return BASE_OK;
}

static json_t *row_of(combination *c) {
  char others[400] = "";
  json_t *o = json_object();
  stats_sort(c->time, c->n_time);
  for (int s = 0; s < RUN_STATUS_COUNT; s++) {
    const size_t used = strlen(others);
    if (s != RUN_OK && c->by_status[s] > 0) {
      (void)snprintf(others + used, sizeof others - used, "%s%d %s", used > 0 ? ", " : "",
                     c->by_status[s], run_status_name((run_status)s));
    }
  }
  json_out_text(o, "formulation", c->formulation);
  json_out_text(o, "solver", c->solver);
  json_out_int(o, "cells", c->cells);
  json_out_int(o, "ok", c->by_status[RUN_OK]);
  json_out_int(o, "verified", c->verified);
  json_out_int(o, "missed", c->missed);
  json_out_real(o, "time_s", c->n_time > 0 ? stats_median(c->time, c->n_time) : HUGE_VAL);
  json_out_text(o, "others", others);
  return o;
}

static base_status print_table(const record_table *t, const char *format, base_error *err) {
  static const char *const column[] = {"formulation", "solver", "cells",  "ok", "verified",
                                       "missed",      "time_s", "others", NULL};
  combinations all = {0};
  row_ref *row;
  BASE_TRY(record_table_by_cell(t, &row, err));
  base_status done = BASE_OK;
  for (int i = 0; done == BASE_OK && i < t->n;) {
    const int same = record_same_cell(row + i, t->n - i);
    done = add_cell(&all, row + i, same, err);
    i += same;
  }
  free(row);
  json_t *rows = json_array();
  for (int i = 0; i < all.n; i++) {
    (void)json_array_append_new(rows, row_of(&all.item[i]));
    free(all.item[i].time);
  }
  free(all.item);
  if (done != BASE_OK) {
    json_decref(rows);
  } else if (!table_print(rows, column, format, stdout)) {
    done = BASE_FAIL(err, BASE_EEXTERNAL, "the table could not be written");
  }
  return done;
}

/* ---- verb ------------------------------------------------------------------------------------ */

typedef struct status_options {
  bool table;
  const char *format;
} status_options;

static const arg_option options[] = {
    ARG(status_options, table, "--table", ARG_FLAG, NULL,
        "a table with a line for each formulation and solver: cells, ok, verified, time"),
    ARG(status_options, format, "--format", ARG_TEXT, "table|csv|json",
        "that table in another form; table where none is given"),
};
static const arg_table args = {options, BASE_COUNT(options),
                               1,       1,
                               "DIR",   "campaign folder, or a file of rows (.csv, .csv.xz)"};

static int run(int argc, char **argv) {
  status_options o = {0};
  const char *dir;
  int n;
  base_error err = {0};
  record_table t = {0};
  status_counts c = {0};
  base_status done = args_parse(&args, &o, argc, argv, &dir, &n, &err);
  if (done == BASE_OK && o.format != NULL) {
    done = table_format(o.format, &err);
  }
  if (done == BASE_OK) {
    done = runner_read_rows(dir, &t, &err);
  }
  if (done == BASE_OK && (o.table || o.format != NULL)) {
    done = print_table(&t, o.format != NULL ? o.format : "table", &err);
  } else if (done == BASE_OK) {
    done = count_rows(&t, &c, &err);
    if (done == BASE_OK) {
      print_status(&t, &c, dir);
      done = print_left(dir, c.cells, &err);
    }
  }
  record_table_free(&t);
  return (done == BASE_OK) ? CLI_OK : cli_report(&err);
}

extern const cli_verb verb_status;
const cli_verb verb_status = {
    .name = "status",
    .args = &args,
    .help = "counts the rows and verdicts of a campaign folder",
    .run = run,
};
