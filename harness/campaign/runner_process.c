/* One process of one cell: started with its own offsets of stack and heap, watched, its rows completed. */
#include "harness/campaign/runner_state.h"
#include "harness/cell/death.h"
#include "harness/cell/isolate.h"
#include "harness/measure/verdict.h"
#include "harness/util/versions.h"
#include "lcp/base/clock.h"
#include "lcp/base/rng.h"

#include <alloca.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define SET_TEXT(field, text) ((void)snprintf((field), sizeof(field), "%s", (text)))

/* ---- the child --------------------------------------------------------------------------------*/

/* Children share the parent's address space layout, which may favour one solver over another
 * (Mytkowicz et al. 2009): every process gets its own offsets of stack and heap, by the seed. */
static void child_body(void *ctx, isolate_channel *c) {
  runner *r = ctx;
  r->job.mem_node = r->o->pin ? machine_bind_memory() : -1;
  uint64_t seed = r->plan->campaign->seed + (uint64_t)r->job.process;
  for (const char *at = r->job.cell->id; *at != '\0'; at++) {
    seed = (seed ^ (unsigned char)*at) * 0x100000001b3u;
  }
  base_rng rng = base_rng_seeded(seed);
  const size_t stack = 16 + 16 * (size_t)(base_rng_bits(&rng) % 256);
  const size_t heap = 16 + 16 * (size_t)(base_rng_bits(&rng) % 4096);
  volatile char *pad = alloca(stack);
  void *kept = malloc(heap);
  pad[0] = 0;
  cell_run(&r->job, c);
  free(kept);
}

static void parent_item(void *ctx, const void *item) {
  runner *r = ctx;
  r->lost = r->lost || record_table_append(&r->unit_rows, item, NULL) != BASE_OK;
}

/* ---- rows -------------------------------------------------------------------------------------*/

/* A death as the one row it deserves. */
static void death_row(runner *r, const isolate_end *end, base_error *err) {
  record row;
  cell_identity(&r->job, &row);
  row.rep = 0;
  row.ctx_invol = end->ctx_invol;
  row.major_faults = end->major_faults;
  const run_status word =
      death_word(end, r->plan->campaign->limits.time, row.note, sizeof row.note);
  if (end->signal != 0) {
    row.exit_signal = end->signal;
  }
  SET_TEXT(row.status, run_status_name(word));
  r->lost = r->lost || record_table_append(&r->unit_rows, &row, err) != BASE_OK;
}

typedef struct surroundings {
  int order, cpu;
  double load;
  long throttles; /* before */
} surroundings;

static void add_context(runner *r, const isolate_end *end, const surroundings *s) {
  const int cpu = (s->cpu >= 0) ? s->cpu : 0;
  const long throttles = machine_throttles(cpu);
  for (int i = 0; i < r->unit_rows.n; i++) {
    record *row = &r->unit_rows.row[i];
    row->order = s->order;
    row->rss_peak_B = end->rss_peak;
    row->load1 = s->load;
    row->load_other = r->other.load;
    row->throttled = (int8_t)((throttles < 0) ? -1 : throttles > s->throttles);
    row->suite_dirty = (int8_t)build_dirty();
    if (s->cpu >= 0) {
      (void)snprintf(row->cpu_set, sizeof row->cpu_set, "%d", s->cpu);
    }
    SET_TEXT(row->host, r->machine.host);
    SET_TEXT(row->host_class, r->machine.host_class);
    SET_TEXT(row->suite_commit, build_commit());
    SET_TEXT(row->build_hash, build_hash());
    SET_TEXT(row->base_hash, build_base());
    machine_utc(row->started_utc, sizeof row->started_utc);
  }
}

busy_watch runner_busy_now(void) {
  return (busy_watch){base_seconds(), machine_busy(), machine_own(), (double)NAN};
}

/* CPUs that other processes kept busy since the last reading. Ticks are 10 ms long, so readings
 * closer than half a second tell nothing: rows of short processes have that of the last half second. */
void runner_watch_others(busy_watch *w, double least) {
  const busy_watch now = runner_busy_now();
  const double seconds = now.at - w->at;
  if (seconds >= least) {
    const double others = (now.busy - w->busy) - (now.own - w->own);
    *w = now;
    w->load = (others < 0.0) ? 0.0 : others / seconds;
  }
}

/* ---- one process ------------------------------------------------------------------------------*/

base_status runner_measure(runner *r, int order, isolate_end *end, bool *whole, base_error *err) {
  const campaign_limits *l = &r->plan->campaign->limits;
  surroundings s = {.order = order, .cpu = r->o->pin ? machine_last_cpu() : -1};
  const isolate_limits limits = {l->time, l->grace, l->memory, 1048576.0, s.cpu};
  const isolate_work work = {sizeof(record), child_body, parent_item, r};
  s.load = machine_load();
  s.throttles = machine_throttles(s.cpu >= 0 ? s.cpu : 0);
  r->unit_rows.n = 0;
  r->lost = false;
  BASE_TRY(isolate_run(&work, &limits, end, err));
  runner_watch_others(&r->other, 0.5);
  *whole = end->how != ISOLATE_INTERRUPTED;
  if (!*whole) {
    return BASE_OK;
  }
  if (end->how != ISOLATE_DONE || r->unit_rows.n == 0) {
    r->unit_rows.n = 0;
    death_row(r, end, err);
  }
  if (r->unit_rows.n > 0 && r->unit_rows.row[0].status[0] == '\0') {
    return BASE_FAIL(err, BASE_EIO, "%s", r->unit_rows.row[0].note);
  }
  if (r->lost) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for the rows of a cell");
  }
  add_context(r, end, &s);
  return BASE_OK;
}
