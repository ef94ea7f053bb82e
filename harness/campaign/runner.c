#include "harness/campaign/runner.h"

#include "harness/campaign/doctor.h"
#include "harness/campaign/manifest.h"
#include "harness/campaign/runner_state.h"
#include "harness/measure/verdict.h"
#include "harness/util/folder.h"
#include "harness/util/stop.h"
#include "lcp/base/clock.h"
#include "lcp/base/input.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const char canary_header[] = "utc,host,canary_s,load1,freq_MHz\n";

static void measure_canary(runner *r) {
  cpu_set_t before;
  const int cpu = machine_last_cpu();
  const bool pinned = r->o->pin && machine_pin_for_now(cpu, &before);
  r->canary = machine_canary();
  const double frequency = machine_frequency(pinned ? cpu : sched_getcpu());
  if (pinned) {
    machine_pin_back(&before);
  }
  r->canary_at = base_seconds();
  char path[1100];
  char when[24];
  char megahertz[32] = "";
  folder_file(r->o->out, "canary.csv", path, sizeof path);
  FILE *to = fopen(path, "a");
  if (to != NULL) { /* the canary also stands in every row; a lost line here loses nothing */
    machine_utc(when, sizeof when);
    if (frequency > 0.0) {
      (void)snprintf(megahertz, sizeof megahertz, "%.6g", frequency);
    }
    if (ftell(to) == 0) {
      (void)fputs(canary_header, to);
    }
    (void)fprintf(to, "%s,%s,%.17g,%.3g,%s\n", when, r->machine.host, r->canary, machine_load(),
                  megahertz);
    (void)fclose(to);
  }
}

/* Canaries of another version have other columns: they make room. */
static base_status settle_canaries(const runner *r, base_error *err) {
  char path[1100];
  char old[1100];
  char line[sizeof canary_header] = "";
  folder_file(r->o->out, "canary.csv", path, sizeof path);
  folder_file(r->o->out, "canary.old.csv", old, sizeof old);
  FILE *from;
  const base_status opened = base_in_open(path, &from, err);
  if (opened != BASE_OK) {
    return (errno == ENOENT) ? BASE_OK : opened;
  }
  const bool ours = fgets(line, sizeof line, from) == NULL || strcmp(line, canary_header) == 0;
  (void)fclose(from);
  return (ours || rename(path, old) == 0)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
}

static base_status write_manifest(const runner *r, base_error *err) {
  return manifest_write(r->o->out, r->plan, r->o->filter, r->o->order, r->done, err);
}

/* Not before one process: whoever asks again and again comes to the end. */
static bool spent(const runner *r) {
  return r->o->budget > 0.0 && r->sum->measured > 0 && base_seconds() - r->begun > r->o->budget;
}

/* A cell that has ended leaves no process, also where the budget was spent before its turn. */
static void count_left(runner *r) {
  for (int u = 0; u < r->plan->n_unit; u++) {
    r->done[u] = r->done[u] || r->ended[r->plan->unit[u].cell];
    r->sum->left += r->done[u] ? 0 : 1;
  }
}

/* What unit u still needs: its rows, or only the history of its cell. */
static base_status attend(runner *r, int u, base_error *err) {
  const int c = r->plan->unit[u].cell;
  if (r->done[u]) {
    return r->o->trace ? runner_twin(r, c, err) : BASE_OK;
  }
  if (r->ended[c]) {
    r->done[u] = true;
    r->progress.done++;
    r->progress.skipped++;
    return BASE_OK;
  }
  if (base_seconds() - r->canary_at > r->o->canary_every) {
    measure_canary(r);
    BASE_TRY(write_manifest(r, err)); /* what is left, should the run be killed */
  }
  return runner_unit(r, u, err);
}

static base_status run_units(runner *r, base_error *err) {
  measure_canary(r);
  r->other = runner_busy_now();
  for (int u = 0; u < r->o->units && stop_requested() == 0; u++) {
    if (r->done[u] || !spent(r)) {
      BASE_TRY(attend(r, u, err));
    }
  }
  count_left(r);
  measure_canary(r);
  runner_watch_others(&r->other, isnan(r->other.load) ? 0.05 : 0.5); /* of a short session */
  r->sum->interrupted = stop_requested() != 0;
  BASE_TRY(runner_close_rows(r, err));
  BASE_TRY(write_manifest(r, err));
  return runner_count_cells(r->plan, r->o->out, r->sum->by_status, err);
}

/* ---- preparing --------------------------------------------------------------------------------*/

/* One run at a time writes to a folder; another one waits for it and then goes on with what is
 * left. The lock goes with the process, however it ends. */
static base_status lock_directory(runner *r, base_error *err) {
  char path[1100];
  folder_file(r->o->out, ".lock", path, sizeof path);
  r->lock = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  struct flock whole = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
  if (r->lock < 0) {
    return BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
  }
  if (fcntl(r->lock, F_SETLK, &whole) == 0) {
    return BASE_OK;
  }
  (void)fprintf(stderr, "lcpbench: %s: another run is writing here; waiting for it\n", r->o->out);
  const struct timespec nap = {.tv_nsec = 50000000}; /* a blocking wait would miss a signal that
                                                        comes just before it */
  while (fcntl(r->lock, F_SETLK, &whole) != 0) {
    if (stop_requested() != 0) {
      return BASE_FAIL(err, BASE_EIO, "%s: another run is writing here", r->o->out);
    }
    (void)nanosleep(&nap, NULL);
  }
  return BASE_OK;
}

static base_status make_folders(const runner *r, base_error *err) {
  char path[1100];
  if (r->o->solutions) {
    folder_file(r->o->out, "solutions", path, sizeof path);
    BASE_TRY(folder_make(path, err));
  }
  if (r->o->trace) {
    folder_file(r->o->out, "traces", path, sizeof path);
    BASE_TRY(folder_make(path, err));
  }
  return BASE_OK;
}

static base_status allocate(runner *r, base_error *err) {
  const plan *p = r->plan;
  r->done = calloc((size_t)p->n_unit + 1, sizeof *r->done);
  r->ended = calloc((size_t)p->n_cell + 1, sizeof *r->ended);
  r->twin = calloc((size_t)p->n_cell + 1, sizeof *r->twin);
  return (r->done != NULL && r->ended != NULL && r->twin != NULL)
             ? BASE_OK
             : BASE_FAIL(err, BASE_ENOMEM, "no memory for the run");
}

/* What is in the folder already. Rows first: they tell whether it is this campaign's. */
static base_status settle(runner *r, record_table *rows, base_error *err) {
  const plan *p = r->plan;
  const double seconds = p->campaign->sampling.doctor;
  BASE_TRY(runner_open_rows(r, rows, err));
  BASE_TRY(runner_done(p, rows, r->done, err));
  BASE_TRY(write_manifest(r, err)); /* stays if the run is killed */
  BASE_TRY(make_folders(r, err));
  BASE_TRY(settle_canaries(r, err));
  if (seconds > 0.0) {
    BASE_TRY(doctor_visit(r->o->out, seconds, err));
  }
  BASE_TRY(runner_twins_open(r, err));
  for (int u = 0; u < p->n_unit; u++) {
    r->sum->resumed += r->done[u] ? 1 : 0;
  }
  return BASE_OK;
}

static base_status prepare(runner *r, base_error *err) {
  record_table rows = {0};
  BASE_TRY(folder_make(r->o->out, err));
  BASE_TRY(lock_directory(r, err));
  BASE_TRY(allocate(r, err));
  r->begun = base_seconds();
  const base_status done = settle(r, &rows, err);
  record_table_free(&rows);
  return done;
}

base_status runner_run(const plan *p, const runner_options *o, runner_summary *out,
                       base_error *err) {
  *out = (runner_summary){.units = p->n_unit, .cells = p->n_cell};
  runner r = {.plan = p, .o = o, .sum = out, .fd = -1, .lock = -1};
  machine_read(&r.machine);
  base_status done = prepare(&r, err);
  const double from = base_seconds(); /* waiting for another run and the doctor are no overhead */
  if (done == BASE_OK) {
    progress_begin(&r.progress, p->n_unit, out->resumed, o->quiet);
    done = run_units(&r, err);
    progress_end(&r.progress);
  }
  out->wall = base_seconds() - from;
  if (r.fd >= 0 && close(r.fd) != 0 && done == BASE_OK) {
    done = BASE_FAIL(err, BASE_EIO, "%s/results.csv: %s", o->out, strerror(errno));
  }
  if (r.lock >= 0) {
    (void)close(r.lock);
  }
  record_table_free(&r.unit_rows);
  text_list_free(&r.forgotten);
  free(r.done);
  free(r.ended);
  free(r.twin);
  return done;
}
