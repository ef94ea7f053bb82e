/* The rows of a folder: read and settled before a run, appended during it, completed after it. */
#include "harness/campaign/runner_state.h"
#include "harness/measure/registry.h"
#include "harness/measure/verdict.h"
#include "harness/util/folder.h"
#include "harness/util/versions.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- appending --------------------------------------------------------------------------------*/

static base_status not_written(const runner *r, base_error *err) {
  return BASE_FAIL(err, BASE_EIO, "%s/results.csv: %s", r->o->out, strerror(errno));
}

static base_status write_whole(const runner *r, const char *data, size_t n, base_error *err) {
  while (n > 0) {
    const ssize_t wrote = write(r->fd, data, n);
    if (wrote < 0 && errno == EINTR) {
      continue;
    }
    if (wrote <= 0) {
      return not_written(r, err);
    }
    data += wrote;
    n -= (size_t)wrote;
  }
  return (fsync(r->fd) == 0) ? BASE_OK : not_written(r, err);
}

base_status runner_append_rows(runner *r, base_error *err) {
  const size_t cap = (size_t)r->unit_rows.n * RECORD_ROW + 1;
  char *text = malloc(cap);
  if (text == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to write %d rows", r->unit_rows.n);
  }
  size_t used = 0;
  for (int i = 0; i < r->unit_rows.n; i++) {
    used += record_row(&r->unit_rows.row[i], text + used, cap - used);
  }
  const base_status done = write_whole(r, text, used, err);
  free(text);
  r->sum->rows += (done == BASE_OK) ? r->unit_rows.n : 0;
  return done;
}

/* ---- the rows of earlier runs -----------------------------------------------------------------*/

bool runner_wanted_again(const record *r, const runner_options *o) {
  run_status s = RUN_ERROR;
  (void)run_status_find(r->status, &s);
  switch (o->rerun) {
  case RERUN_NONE:
    return false;
  case RERUN_FAILED:
    return s != RUN_OK;
  case RERUN_TIMEOUTS:
    return s == RUN_TIMEOUT || s == RUN_TIME_LIMIT;
  case RERUN_ALL:
    return true;
  case RERUN_SOLVER:
    break;
  }
  return strcmp(r->solver, o->rerun_solver) == 0;
}

static const cell *find_cell(const plan *p, const char *id) {
  for (int i = 0; i < p->n_cell; i++) {
    if (strcmp(p->cell[i].id, id) == 0) {
      return &p->cell[i];
    }
  }
  return NULL;
}

/* What stands beside a row goes with it. */
static base_status forget(runner *r, const char *id, base_error *err) {
  char path[1100];
  const int n = r->forgotten.n;
  if (n > 0 && strcmp(r->forgotten.item[n - 1], id) == 0) {
    return BASE_OK;
  }
  runner_solution_path(r, id, path, sizeof path);
  (void)unlink(path);
  runner_trace_path(r, id, path, sizeof path);
  (void)unlink(path);
  return text_list_add(&r->forgotten, id, err);
}

typedef enum fate { ROW_KEPT, ROW_STALE, ROW_AGAIN } fate;

/* Stale: no cell of this campaign any more (a changed problem, component or option), or measured by
 * other shared code. Under a filter or in a shard other cells are none of our business. */
static fate fate_of(const runner *r, const record *row) {
  const bool known = find_cell(r->plan, row->cell_id) != NULL;
  if (known ? strcmp(row->base_hash, build_base()) != 0 : r->plan->whole) {
    return ROW_STALE;
  }
  return (known && runner_wanted_again(row, r->o)) ? ROW_AGAIN : ROW_KEPT;
}

/* Adds rows to stale.csv; what an earlier run set aside stays. */
static base_status set_aside(const runner *r, const record_table *stale, base_error *err) {
  char path[1100];
  record_table all = {0};
  base_status done = BASE_OK;
  folder_file(r->o->out, "stale.csv", path, sizeof path);
  if (access(path, F_OK) == 0) {
    done = record_table_read(path, &all, err);
  }
  for (int i = 0; done == BASE_OK && i < stale->n; i++) {
    done = record_table_append(&all, &stale->row[i], err);
  }
  if (done == BASE_OK) {
    done = record_table_write(path, &all, err);
  }
  record_table_free(&all);
  return done;
}

/* Another campaign, or the other form of this one, would set all of its rows aside. */
static base_status check_campaign(const runner *r, const record_table *rows, base_error *err) {
  const campaign *c = r->plan->campaign;
  for (int i = 0; i < rows->n; i++) {
    const record *row = &rows->row[i];
    const bool other_form = row->quick >= 0 && (row->quick == 1) != c->quick;
    if (strcmp(row->campaign, c->name) != 0 || other_form) {
      return BASE_FAIL(err, BASE_EINVAL,
                       "%s/results.csv holds rows of campaign %s%s, not %s%s: choose another --out",
                       r->o->out, row->campaign, row->quick == 1 ? " --quick" : "", c->name,
                       c->quick ? " --quick" : "");
    }
  }
  return BASE_OK;
}

static base_status sort_rows(runner *r, const record_table *rows, record_table *kept,
                             record_table *aside, base_error *err) {
  base_status done = BASE_OK;
  for (int i = 0; done == BASE_OK && i < rows->n; i++) {
    const record *row = &rows->row[i];
    const fate f = fate_of(r, row);
    r->sum->stale += (f == ROW_STALE) ? 1 : 0;
    done = record_table_append(f == ROW_KEPT ? kept : aside, row, err);
    if (done == BASE_OK && f != ROW_KEPT) {
      done = forget(r, row->cell_id, err);
    }
  }
  return done;
}

/* Sets aside rows that are stale or to be measured again: nothing is thrown away. */
static base_status settle_rows(runner *r, record_table *rows, base_error *err) {
  record_table kept = {0};
  record_table aside = {0};
  BASE_TRY(check_campaign(r, rows, err));
  base_status done = sort_rows(r, rows, &kept, &aside, err);
  const bool changed = rows->torn || rows->foreign || kept.n != rows->n;
  if (done == BASE_OK && aside.n > 0) {
    done = set_aside(r, &aside, err);
  }
  if (done == BASE_OK && changed) {
    done = runner_write_rows(r->o->out, &kept, err);
  }
  record_table_free(&aside);
  record_table_free(rows);
  *rows = kept;
  return done;
}

base_status runner_open_rows(runner *r, record_table *rows, base_error *err) {
  char path[1100];
  char header[RECORD_ROW];
  folder_file(r->o->out, "results.csv.xz", path, sizeof path);
  if (access(path, F_OK) == 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: packed rows are not gone on with; unpack them (xz -d)",
                     path);
  }
  folder_file(r->o->out, "results.csv", path, sizeof path);
  if (access(path, F_OK) == 0) {
    BASE_TRY(record_table_read(path, rows, err));
    BASE_TRY(settle_rows(r, rows, err));
  }
  r->earlier = rows->n;
  r->fd = open(path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
  if (r->fd < 0) {
    return BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
  }
  struct stat st;
  if (fstat(r->fd, &st) == 0 && st.st_size == 0) {
    const size_t n = record_header(header, sizeof header);
    return write_whole(r, header, n, err);
  }
  return BASE_OK;
}

/* ---- closing ----------------------------------------------------------------------------------*/

static bool flag_new(record *r, const char *word) {
  const bool has = record_has_flag(r, word);
  record_flag(r, word);
  return !has;
}

/* Rows of this session between two canaries that differ by more than 3 %. Rows stand in the order of
 * measuring and hold the canary before them; `last` is the canary after the last of them. */
static bool flag_drift(const runner *r, record_table *t, double last) {
  bool changed = false;
  double after = last;
  double before = (double)NAN;
  for (int i = t->n; i-- > r->earlier;) {
    record *row = &t->row[i];
    if (row->canary_s != before) {
      after = isnan(before) ? last : before;
      before = row->canary_s;
    }
    if (fabs(log(after / before)) > log(1.03)) {
      changed = flag_new(row, "canary_drift") || changed;
    }
  }
  return changed;
}

/* Rows written before the first reading of what others do have that reading. */
static bool fill_others(const runner *r, record_table *t) {
  double load = r->other.load;
  bool changed = false;
  for (int i = t->n; i-- > r->earlier;) {
    record *row = &t->row[i];
    changed = changed || (isnan(row->load_other) && !isnan(load));
    row->load_other = isnan(row->load_other) ? load : row->load_other;
    load = row->load_other;
  }
  return changed;
}

static bool iterative(const record *row) {
  const lcp_solver *s = registry_solver_find(row->solver);
  return s != NULL && !s->exact;
}

/* A row by what equal rows of two methods would share. */
typedef struct bits {
  const char *hash;
  int row;
} bits;

static int by_hash(const void *a, const void *b) {
  return strcmp(((const bits *)a)->hash, ((const bits *)b)->hash);
}

static bool suspicious(const record *a, const record *b) {
  return strcmp(a->solver, b->solver) != 0 && strcmp(a->problem_sha256, b->problem_sha256) == 0 &&
         strcmp(a->problem, b->problem) == 0 &&
         strcmp(a->formulation_config, b->formulation_config) == 0;
}

/* Two iterative methods that agree in every bit after some work are one method under two names, or
 * both fell back to a third. */
static base_status flag_same_bits(record_table *t, bool *changed, base_error *err) {
  bits *b = calloc((size_t)t->n + 1, sizeof *b);
  int n = 0;
  if (b == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to compare %d rows", t->n);
  }
  for (int i = 0; i < t->n; i++) {
    const record *r = &t->row[i];
    if (r->solution_hash[0] != '\0' && r->n_iter > 1 && r->rho > 0.0 && iterative(r)) {
      b[n++] = (bits){r->solution_hash, i};
    }
  }
  qsort(b, (size_t)n, sizeof *b, by_hash);
  for (int i = 0; i < n; i++) {
    for (int k = i + 1; k < n && by_hash(&b[i], &b[k]) == 0; k++) {
      record *x = &t->row[b[i].row];
      record *y = &t->row[b[k].row];
      if (suspicious(x, y)) {
        *changed = flag_new(x, "same_bits") || *changed;
        *changed = flag_new(y, "same_bits") || *changed;
      }
    }
  }
  free(b);
  return BASE_OK;
}

static bool name_traces(const runner *r, record_table *t) {
  bool changed = false;
  char path[1100];
  for (int i = 0; i < t->n; i++) {
    record *row = &t->row[i];
    runner_trace_path(r, row->cell_id, path, sizeof path);
    if (row->trace[0] == '\0' && access(path, F_OK) == 0) {
      (void)snprintf(row->trace, sizeof row->trace, "traces/%.24s.csv", row->cell_id);
      changed = true;
    }
  }
  return changed;
}

base_status runner_close_rows(runner *r, base_error *err) {
  record_table t;
  if (r->sum->measured == 0 && !r->o->trace) {
    return BASE_OK;
  }
  BASE_TRY(runner_read_rows(r->o->out, &t, err));
  bool changed = flag_drift(r, &t, r->canary);
  changed = fill_others(r, &t) || changed;
  if (r->o->trace) {
    changed = name_traces(r, &t) || changed;
  }
  base_status done = flag_same_bits(&t, &changed, err);
  if (done == BASE_OK && changed) {
    done = runner_write_rows(r->o->out, &t, err); /* to a temporary file, then renamed */
  }
  record_table_free(&t);
  return done;
}
