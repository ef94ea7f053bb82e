/* What of a plan has its rows already. */
#include "harness/campaign/runner.h"
#include "harness/cell/machine.h"
#include "harness/measure/verdict.h"
#include "harness/util/folder.h"
#include "harness/util/versions.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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

/* host_class NULL: rows of any machine count. */
static base_status done_on(const plan *p, const record_table *rows, const char *host_class,
                           bool *done, base_error *err) {
  memset(done, 0, (size_t)p->n_unit * sizeof *done);
  row_key *key = calloc((size_t)rows->n + 1, sizeof *key);
  if (key == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to look up %d rows", rows->n);
  }
  int n = 0;
  for (int i = 0; i < rows->n; i++) {
    const record *r = &rows->row[i];
    const bool same_build = strcmp(r->base_hash, build_base()) == 0;
    if (same_build && (host_class == NULL || strcmp(r->host_class, host_class) == 0)) {
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

run_status runner_cell_status(const row_ref *row, int n) {
  run_status word = RUN_OK;
  for (int i = 0; i < n && word == RUN_OK; i++) {
    (void)run_status_find(row[i].r->status, &word); /* rows with other words are not read */
  }
  return word;
}

static int by_cell_id(const void *a, const void *b) {
  return strcmp(((const cell *)a)->id, ((const cell *)b)->id);
}

/* Rows of the plan's cells that count as measured, by cell. */
static base_status count_known(const cell *known, int n_known, record_table *rows,
                               int by_status[RUN_STATUS_COUNT], base_error *err) {
  machine m;
  row_ref *row;
  machine_read(&m);
  int n = 0;
  for (int i = 0; i < rows->n; i++) {
    cell key;
    (void)snprintf(key.id, sizeof key.id, "%.16s", rows->row[i].cell_id);
    if (strcmp(rows->row[i].base_hash, build_base()) == 0 &&
        strcmp(rows->row[i].host_class, m.host_class) == 0 &&
        bsearch(&key, known, (size_t)n_known, sizeof key, by_cell_id) != NULL) {
      rows->row[n++] = rows->row[i];
    }
  }
  rows->n = n;
  BASE_TRY(record_table_by_cell(rows, &row, err));
  for (int i = 0; i < n;) {
    const int same = record_same_cell(row + i, n - i);
    by_status[runner_cell_status(row + i, same)]++;
    i += same;
  }
  free(row);
  return BASE_OK;
}

base_status runner_count_cells(const plan *p, const char *dir, int by_status[RUN_STATUS_COUNT],
                               base_error *err) {
  record_table rows;
  memset(by_status, 0, RUN_STATUS_COUNT * sizeof *by_status);
  cell *known = malloc(((size_t)p->n_cell + 1) * sizeof *known);
  if (known == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to count %d cells", p->n_cell);
  }
  memcpy(known, p->cell, (size_t)p->n_cell * sizeof *known);
  qsort(known, (size_t)p->n_cell, sizeof *known, by_cell_id);
  base_status done = runner_read_rows(dir, &rows, err);
  if (done == BASE_OK) {
    done = count_known(known, p->n_cell, &rows, by_status, err);
    record_table_free(&rows);
  }
  free(known);
  return done;
}

base_status runner_done(const plan *p, const record_table *rows, bool *done, base_error *err) {
  machine m;
  machine_read(&m);
  return done_on(p, rows, m.host_class, done, err); /* times of another machine are not these */
}

base_status runner_left(const plan *p, const char *dir, int *left, base_error *err) {
  char path[1100];
  record_table rows = {0};
  *left = p->n_unit;
  folder_file(dir, "results.csv", path, sizeof path);
  if (access(path, F_OK) != 0) {
    return BASE_OK; /* not begun */
  }
  BASE_TRY(runner_read_rows(dir, &rows, err));
  bool *done = calloc((size_t)p->n_unit + 1, sizeof *done);
  base_status s = (done != NULL) ? done_on(p, &rows, NULL, done, err)
                                 : BASE_FAIL(err, BASE_ENOMEM, "no memory for the plan");
  for (int u = 0; s == BASE_OK && u < p->n_unit; u++) {
    *left -= done[u] ? 1 : 0;
  }
  free(done);
  record_table_free(&rows);
  return s;
}
