/* lcpbench status: what a campaign folder holds. */
#include "harness/args.h"
#include "harness/cli.h"
#include "harness/runner.h"
#include "harness/stats.h"
#include "harness/verdict.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int by_cell(const void *a, const void *b) {
  return strcmp(((const record *)a)->cell_id, ((const record *)b)->cell_id);
}

static void print_status(record_table *t, const char *dir) {
  int by_status[RUN_STATUS_COUNT] = {0};
  int cells = 0;
  int missed = 0;
  double slow = 0.0;
  double fast = 0.0;
  qsort(t->row, (size_t)t->n, sizeof *t->row, by_cell);
  for (int i = 0; i < t->n; i++) {
    const record *r = &t->row[i];
    const bool first = i == 0 || strcmp(r->cell_id, t->row[i - 1].cell_id) != 0;
    run_status s;
    if (run_status_find(r->status, &s)) {
      by_status[s] += first ? 1 : 0;
    }
    cells += first ? 1 : 0;
    missed += (first && r->n_predictions_missed > 0) ? 1 : 0;
    if (r->canary_s > 0.0) {
      slow = (r->canary_s > slow) ? r->canary_s : slow;
      fast = (fast == 0.0 || r->canary_s < fast) ? r->canary_s : fast;
    }
  }
  (void)printf("%s: %d rows of %d cells%s\n", dir, t->n, cells,
               t->torn ? ", the last row is torn (the next run drops it)" : "");
  for (int s = 0; s < RUN_STATUS_COUNT; s++) {
    if (by_status[s] > 0) {
      (void)printf("  %-11s %d\n", run_status_name((run_status)s), by_status[s]);
    }
  }
  (void)printf("  %d cells miss a prediction\n", missed);
  if (fast > 0.0 && slow > 1.03 * fast) {
    (void)printf("  the canary drifted by %.1f %%: times are not comparable throughout\n",
                 100.0 * (slow / fast - 1.0));
  }
}

static int run(int argc, char **argv) {
  const arg_table table = {NULL, 0, 1, 1, "DIR"};
  const char *dir;
  int n;
  base_error err = {0};
  char path[1100];
  record_table t;
  base_status done = args_parse(&table, argc, argv, &dir, &n, &err);
  if (done == BASE_OK) {
    runner_path(dir, "results.csv", path, sizeof path);
    done = record_table_read(path, &t, &err);
  }
  if (done != BASE_OK) {
    return cli_report(&err);
  }
  print_status(&t, dir);
  record_table_free(&t);
  return CLI_OK;
}

extern const cli_verb verb_status;
const cli_verb verb_status = {
    .name = "status",
    .usage = "status DIR",
    .help = "counts the rows and verdicts of a campaign folder",
    .run = run,
};
