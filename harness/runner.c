#include "harness/runner.h"

#include "harness/cell_run.h"
#include "harness/isolate.h"
#include "harness/machine.h"
#include "harness/progress.h"
#include "harness/stats.h"
#include "harness/verdict.h"
#include "harness/versions.h"
#include "lcp/base/clock.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define SET_TEXT(field, text) ((void)snprintf((field), sizeof(field), "%s", (text)))

void runner_path(const char *dir, const char *name, char *buf, size_t cap) {
  (void)snprintf(buf, cap, "%s/%s", dir, name);
}

/* ---- the run ----------------------------------------------------------------------------------*/

typedef struct runner {
  const plan *plan;
  const runner_options *o;
  runner_summary *sum;
  machine machine;
  int fd;   /* results.csv, append only */
  int lock; /* .lock */
  bool *done;
  bool *ended; /* per cell: failed, no further processes */
  progress progress;
  double canary, canary_at;
  record_table unit_rows; /* of the process being measured */
  cell_job job;
} runner;

static base_status make_directory(const char *path, base_error *err) {
  if (mkdir(path, 0777) != 0 && errno != EEXIST) {
    return BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
  }
  return BASE_OK;
}

static base_status write_whole(int fd, const char *data, size_t n, base_error *err) {
  while (n > 0) {
    const ssize_t wrote = write(fd, data, n);
    if (wrote < 0 && errno == EINTR) {
      continue;
    }
    if (wrote <= 0) {
      return BASE_FAIL(err, BASE_EIO, "results.csv: %s", strerror(errno));
    }
    data += wrote;
    n -= (size_t)wrote;
  }
  return (fsync(fd) == 0) ? BASE_OK : BASE_FAIL(err, BASE_EIO, "results.csv: %s", strerror(errno));
}

static base_status append_rows(runner *r, base_error *err) {
  const size_t cap = (size_t)r->unit_rows.n * RECORD_ROW + 1;
  char *text = malloc(cap);
  if (text == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory to write %d rows", r->unit_rows.n);
  }
  size_t used = 0;
  for (int i = 0; i < r->unit_rows.n; i++) {
    used += record_row(&r->unit_rows.row[i], text + used, cap - used);
  }
  const base_status done = write_whole(r->fd, text, used, err);
  free(text);
  r->sum->rows += (done == BASE_OK) ? r->unit_rows.n : 0;
  return done;
}

static void measure_canary(runner *r) {
  r->canary = machine_canary();
  r->canary_at = base_seconds();
  char path[1100];
  char when[24];
  runner_path(r->o->out, "canary.csv", path, sizeof path);
  FILE *to = fopen(path, "a");
  if (to != NULL) { /* the canary also stands in every row; a lost line here loses nothing */
    machine_utc(when, sizeof when);
    if (ftell(to) == 0) {
      (void)fputs("utc,host,canary_s,load1\n", to);
    }
    (void)fprintf(to, "%s,%s,%.9g,%.3g\n", when, r->machine.host, r->canary, machine_load());
    (void)fclose(to);
  }
}

static void child_body(void *ctx, isolate_channel *c) {
  const runner *r = ctx;
  cell_run(&r->job, c);
}

static void parent_item(void *ctx, const void *item) {
  runner *r = ctx;
  record row;
  memcpy(&row, item, sizeof row); /* items arrive unaligned */
  (void)record_table_append(&r->unit_rows, &row, NULL);
}

/* A death as the one row it deserves. */
static void death_row(runner *r, const isolate_end *end, base_error *err) {
  record row;
  run_status word = RUN_NO_OUTPUT;
  cell_identity(&r->job, &row);
  row.rep = r->unit_rows.n;
  switch (end->how) {
  case ISOLATE_TIMEOUT:
    word = RUN_TIMEOUT;
    (void)snprintf(row.note, sizeof row.note, "killed after %g s", r->plan->campaign->limits.time);
    break;
  case ISOLATE_FLOOD:
    word = RUN_FLOOD;
    SET_TEXT(row.note, "killed for flooding its output");
    break;
  case ISOLATE_OOM:
    word = RUN_OOM;
    SET_TEXT(row.note, "killed by the kernel for memory");
    break;
  case ISOLATE_SIGNAL:
    word = RUN_CRASH;
    (void)snprintf(row.note, sizeof row.note, "signal %d %s: %.180s", end->signal,
                   strsignal(end->signal), end->log);
    break;
  case ISOLATE_EXIT:
  case ISOLATE_DONE:
  case ISOLATE_INTERRUPTED:
    (void)snprintf(row.note, sizeof row.note, "exit(%d) without a result: %.180s", end->exit_code,
                   end->log);
    break;
  }
  if (end->signal != 0) {
    row.exit_signal = end->signal;
  }
  SET_TEXT(row.status, run_status_name(word));
  (void)record_table_append(&r->unit_rows, &row, err);
}

static void add_context(runner *r, const isolate_end *end, double load, int order, int cpu) {
  for (int i = 0; i < r->unit_rows.n; i++) {
    record *row = &r->unit_rows.row[i];
    row->order = order;
    row->rss_peak_B = end->rss_peak;
    row->ctx_invol = end->ctx_invol;
    row->major_faults = end->major_faults;
    row->load1 = load;
    row->freq_MHz = machine_frequency(cpu >= 0 ? cpu : 0);
    row->suite_dirty = (int8_t)build_dirty();
    if (cpu >= 0) {
      (void)snprintf(row->cpu_set, sizeof row->cpu_set, "%d", cpu);
    }
    SET_TEXT(row->host, r->machine.host);
    SET_TEXT(row->host_class, r->machine.cpu_model);
    SET_TEXT(row->suite_commit, build_commit());
    SET_TEXT(row->build_hash, build_hash());
    machine_utc(row->started_utc, sizeof row->started_utc);
  }
}

/* Marks samples far from the others of their process: modified z-score above 3.5 (Iglewicz & Hoaglin
 * 1993: 0.6745 |x - median| / MAD). Nothing is deleted. */
static void flag_outliers(runner *r) {
  enum { SAMPLES = 256 };
  double x[SAMPLES];
  double away[SAMPLES];
  int n = 0;
  for (int i = 0; i < r->unit_rows.n && n < SAMPLES; i++) {
    if (r->unit_rows.row[i].t_total_s > 0.0) {
      x[n++] = r->unit_rows.row[i].t_total_s;
    }
  }
  stats_sort(x, n);
  const double median = stats_median(x, n);
  for (int i = 0; i < n; i++) {
    away[i] = fabs(x[i] - median);
  }
  stats_sort(away, n);
  const double mad = stats_median(away, n);
  for (int i = 0; n >= 5 && mad > 0.0 && i < r->unit_rows.n; i++) {
    record *row = &r->unit_rows.row[i];
    if (0.6745 * fabs(row->t_total_s - median) / mad > 3.5) {
      const size_t used = strlen(row->flags);
      (void)snprintf(row->flags + used, sizeof row->flags - used, "%soutlier", used > 0 ? " " : "");
    }
  }
}

static void count_status(runner *r) {
  const record *last = &r->unit_rows.row[r->unit_rows.n - 1];
  run_status s;
  if (run_status_find(last->status, &s)) {
    r->sum->by_status[s]++;
  }
}

static base_status run_unit(runner *r, int u, base_error *err) {
  const unit *un = &r->plan->unit[u];
  const cell *c = &r->plan->cell[un->cell];
  const campaign_limits *l = &r->plan->campaign->limits;
  const int cpu = r->o->pin ? machine_last_cpu() : -1;
  const isolate_limits limits = {l->time, l->grace, l->memory, 1048576.0, cpu};
  char solution[1100];
  (void)snprintf(solution, sizeof solution, "%s/solutions/%s.mtx", r->o->out, c->id);
  r->job = (cell_job){r->plan->campaign, c, un->process, r->canary,
                      r->o->solutions && un->process == 0 ? solution : NULL};
  r->unit_rows.n = 0;
  const double load = machine_load();
  const isolate_work work = {sizeof(record), child_body, parent_item, r};
  isolate_end end;
  BASE_TRY(isolate_run(&work, &limits, &end, err));
  if (end.how == ISOLATE_INTERRUPTED) {
    return BASE_OK; /* nothing of an unfinished process is kept */
  }
  if (end.how != ISOLATE_DONE || r->unit_rows.n == 0) {
    r->unit_rows.n = 0;
    death_row(r, &end, err);
  }
  add_context(r, &end, load, u, cpu);
  flag_outliers(r);
  BASE_TRY(append_rows(r, err));
  count_status(r);
  const record *last = &r->unit_rows.row[r->unit_rows.n - 1];
  r->ended[un->cell] = r->ended[un->cell] || runner_ends_cell(last);
  r->sum->measured++;
  r->sum->inside += end.wall;
  char what[160];
  (void)snprintf(what, sizeof what, "%.70s/%.40s/%.40s", c->problem,
                 c->formulation[0] != '\0' ? c->formulation : "-", c->solver);
  progress_step(&r->progress, what, last->status,
                last->t_total_s >= 0 ? last->t_total_s : end.wall);
  return BASE_OK;
}

static base_status run_units(runner *r, base_error *err) {
  measure_canary(r);
  for (int u = 0; u < r->plan->n_unit && isolate_stop_requested() == 0; u++) {
    if (r->done[u]) {
      continue;
    }
    if (r->ended[r->plan->unit[u].cell]) {
      r->progress.done++;
      r->progress.skipped++;
      continue;
    }
    if (base_seconds() - r->canary_at > r->o->canary_every) {
      measure_canary(r);
    }
    BASE_TRY(run_unit(r, u, err));
  }
  measure_canary(r);
  r->sum->interrupted = isolate_stop_requested() != 0;
  return BASE_OK;
}

/* ---- the rows of earlier runs -----------------------------------------------------------------*/

static bool wanted_again(const record *r, const runner_options *o) {
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

/* Leaves out rows that are to be measured again, and sets rows of cells of this plan's parts that
 * no longer exist (changed problem, solver or option) aside in stale.csv. */
static base_status settle_rows(runner *r, record_table *rows, bool whole, base_error *err) {
  record_table kept = {0};
  record_table stale = {0};
  base_status done = BASE_OK;
  for (int i = 0; done == BASE_OK && i < rows->n; i++) {
    const record *row = &rows->row[i];
    const bool known = find_cell(r->plan, row->cell_id) != NULL;
    if (whole && !known) {
      done = record_table_append(&stale, row, err);
    } else if (!known || !wanted_again(row, r->o)) {
      done = record_table_append(&kept, row, err);
    }
  }
  const bool changed = rows->torn || kept.n != rows->n;
  char path[1100];
  if (done == BASE_OK && stale.n > 0) {
    runner_path(r->o->out, "stale.csv", path, sizeof path);
    done = record_table_write(path, &stale, err);
  }
  if (done == BASE_OK && changed) {
    runner_path(r->o->out, "results.csv", path, sizeof path);
    done = record_table_write(path, &kept, err);
  }
  r->sum->stale = stale.n;
  record_table_free(&stale);
  record_table_free(rows);
  *rows = kept;
  return done;
}

static base_status load_rows(runner *r, record_table *rows, base_error *err) {
  char path[1100];
  char header[4096];
  runner_path(r->o->out, "results.csv", path, sizeof path);
  if (access(path, F_OK) == 0) {
    BASE_TRY(record_table_read(path, rows, err));
    BASE_TRY(settle_rows(r, rows, r->plan->whole, err));
  }
  r->fd = open(path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
  if (r->fd < 0) {
    return BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
  }
  struct stat st;
  if (fstat(r->fd, &st) == 0 && st.st_size == 0) {
    const size_t n = record_header(header, sizeof header);
    return write_whole(r->fd, header, n, err);
  }
  return BASE_OK;
}

/* One run at a time writes to a folder; another one waits for it and then goes on with what is
 * left. The lock goes with the process, however it ends. */
static base_status lock_directory(runner *r, base_error *err) {
  char path[1100];
  runner_path(r->o->out, ".lock", path, sizeof path);
  r->lock = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  struct flock whole = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
  if (r->lock < 0) {
    return BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
  }
  if (fcntl(r->lock, F_SETLK, &whole) == 0) {
    return BASE_OK;
  }
  (void)fprintf(stderr, "lcpbench: %s: another run is writing here; waiting for it\n", r->o->out);
  while (fcntl(r->lock, F_SETLKW, &whole) != 0) {
    if (errno != EINTR || isolate_stop_requested() != 0) {
      return BASE_FAIL(err, BASE_EIO, "%s: another run is writing here", r->o->out);
    }
  }
  return BASE_OK;
}

static base_status prepare(runner *r, base_error *err) {
  record_table rows = {0};
  const plan *p = r->plan;
  char path[1100];
  BASE_TRY(make_directory(r->o->out, err));
  BASE_TRY(lock_directory(r, err));
  if (r->o->solutions) {
    runner_path(r->o->out, "solutions", path, sizeof path);
    BASE_TRY(make_directory(path, err));
  }
  r->done = calloc((size_t)p->n_unit + 1, sizeof *r->done);
  r->ended = calloc((size_t)p->n_cell + 1, sizeof *r->ended);
  if (r->done == NULL || r->ended == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the run");
  }
  base_status done = load_rows(r, &rows, err);
  if (done == BASE_OK) {
    done = runner_done(p, &rows, r->done, err);
  }
  for (int u = 0; done == BASE_OK && u < p->n_unit; u++) {
    r->sum->resumed += r->done[u] ? 1 : 0;
  }
  record_table_free(&rows);
  return done;
}

base_status runner_run(const plan *p, const runner_options *o, runner_summary *out,
                       base_error *err) {
  *out = (runner_summary){.units = p->n_unit, .cells = p->n_cell};
  runner r = {.plan = p, .o = o, .sum = out, .fd = -1, .lock = -1};
  machine_read(&r.machine);
  const double from = base_seconds();
  base_status done = prepare(&r, err);
  if (done == BASE_OK) {
    progress_begin(&r.progress, p->n_unit, out->resumed, o->quiet);
    done = run_units(&r, err);
    progress_end(&r.progress);
  }
  out->wall = base_seconds() - from;
  if (r.fd >= 0 && close(r.fd) != 0 && done == BASE_OK) {
    done = BASE_FAIL(err, BASE_EIO, "results.csv: %s", strerror(errno));
  }
  if (r.lock >= 0) {
    (void)close(r.lock);
  }
  record_table_free(&r.unit_rows);
  free(r.done);
  free(r.ended);
  return done;
}
