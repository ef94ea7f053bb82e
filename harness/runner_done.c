/* What of a plan has its rows already. */
#include "harness/machine.h"
#include "harness/runner.h"
#include "harness/verdict.h"

#include <stdlib.h>
#include <string.h>

bool runner_ends_cell(const record *r) {
  run_status s;
  return !run_status_find(r->status, &s) || s != RUN_OK;
}

/* What a row says of its unit. */
typedef struct row_key {
  char id[CELL_ID];
  int64_t process;
  bool ends; /* the whole cell */
} row_key;

static int by_id(const void *a, const void *b) {
  return strcmp(((const row_key *)a)->id, ((const row_key *)b)->id);
}

static int first_key(const row_key *key, int n, const char *id) {
  int lo = 0;
  int hi = n;
  while (lo < hi) {
    const int mid = lo + (hi - lo) / 2;
    if (strcmp(key[mid].id, id) < 0) {
      lo = mid + 1;
    } else {
      hi = mid;
    }
  }
  return lo;
}

base_status runner_done(const plan *p, const record_table *rows, bool *done, base_error *err) {
  memset(done, 0, (size_t)p->n_unit * sizeof *done);
  row_key *key = calloc((size_t)rows->n + 1, sizeof *key);
  if (key == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to look up %d rows", rows->n);
  }
  machine m;
  machine_read(&m);
  int n = 0;
  for (int i = 0; i < rows->n; i++) {
    const record *r = &rows->row[i];
    if (strcmp(r->host_class, m.cpu_model) == 0) { /* times of another machine are not these */
      (void)snprintf(key[n].id, sizeof key[n].id, "%.16s", r->cell_id);
      key[n].process = r->process;
      key[n++].ends = runner_ends_cell(r);
    }
  }
  qsort(key, (size_t)n, sizeof *key, by_id);
  for (int u = 0; u < p->n_unit; u++) {
    const char *id = p->cell[p->unit[u].cell].id;
    for (int k = first_key(key, n, id); k < n && strcmp(key[k].id, id) == 0; k++) {
      done[u] = done[u] || key[k].ends || key[k].process == p->unit[u].process;
    }
  }
  free(key);
  return BASE_OK;
}
