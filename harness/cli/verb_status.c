/* lcpbench status: what a campaign folder holds. */
#include "harness/campaign/runner.h"
#include "harness/cell/stats.h"
#include "harness/cli/cli.h"
#include "harness/measure/verdict.h"
#include "harness/util/args.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

static const arg_table args = {NULL, 0, 1, 1, "DIR", "campaign folder, or a file of rows"};

static int run(int argc, char **argv) {
  const char *dir;
  int n;
  base_error err = {0};
  record_table t;
  base_status done = args_parse(&args, NULL, argc, argv, &dir, &n, &err);
  if (done == BASE_OK) {
    done = runner_read_rows(dir, &t, &err);
  }
  if (done != BASE_OK) {
    return cli_report(&err);
  }
  status_counts c = {0};
  done = count_rows(&t, &c, &err);
  if (done == BASE_OK) {
    print_status(&t, &c, dir);
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
