#include "harness/cell/cell_run.h"

#include "harness/cell/cell_measure.h"
#include "harness/cell/machine.h"
#include "harness/cell/outliers.h"
#include "harness/cell/stats.h"
#include "harness/sequence/sequence_source.h"
#include "lcp/base/clock.h"

#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

static const char *after_colon(const char *text) {
  const char *colon = strchr(text, ':');
  return (colon != NULL) ? colon + 1 : "";
}

void cell_identity(const cell_job *job, record *r) {
  const cell *c = job->cell;
  record_clear(r);
  r->schema = RECORD_SCHEMA;
  r->metric_version = RECORD_METRIC;
  r->process = job->process;
  r->seed = (int64_t)job->campaign->seed;
  r->threads = 1;
  r->quick = job->campaign->quick ? 1 : 0;
  r->t_limit_s = job->campaign->limits.time;
  r->mem_limit_B = (job->campaign->limits.memory > 0) ? job->campaign->limits.memory : (double)NAN;
  r->canary_s = job->canary;
  r->mem_node = (job->mem_node >= 0) ? job->mem_node : INT64_MIN;
  SET_TEXT(r->cache, job->campaign->sampling.cold ? "cold" : "warm");
  SET_TEXT(r->campaign, job->campaign->name);
  SET_TEXT(r->part, c->part);
  SET_TEXT(r->cell_id, c->id);
  SET_TEXT(r->problem, c->problem);
  SET_TEXT(r->problem_sha256, c->problem_sha256);
  SET_TEXT(r->solver_version, c->solver_version);
  const char *slash = strrchr(c->problem, '/');
  const char *name = (slash != NULL) ? slash + 1 : c->problem;
  (void)snprintf(r->problem_family, sizeof r->problem_family, "%.*s", (int)strcspn(name, ":.@"),
                 name);
  (void)snprintf(r->formulation, sizeof r->formulation, "%.*s", (int)strcspn(c->formulation, ":"),
                 c->formulation);
  (void)snprintf(r->solver, sizeof r->solver, "%.*s", (int)strcspn(c->solver, ":"), c->solver);
  SET_TEXT(r->formulation_options, after_colon(c->formulation));
  SET_TEXT(r->solver_options, after_colon(c->solver));
  if (c->formulation[0] != '\0' || sequence_is(c->problem)) {
    SET_TEXT(r->start, c->start);
  }
  if (c->formulation[0] != '\0') {
    SET_TEXT(r->contact_order, c->contact_order);
    SET_TEXT(r->islands, c->islands);
  }
  (void)cell_command(c, &job->campaign->limits, r->command, sizeof r->command);
}

/* ---- repetitions ------------------------------------------------------------------------------*/

/* The rows of this process so far. */
typedef struct sampling {
  int n, cap;
  record *row;     /* owned */
  double *seconds; /* of one evaluation; owned */
  double *sorted;  /* scratch; owned */
  double longest;  /* one sample took at most, everything included [s] */
  double from;     /* [s] */
} sampling;

static base_status sampling_open(sampling *s, int cap, base_error *err) {
  *s = (sampling){.cap = cap, .from = base_seconds()};
  s->row = calloc((size_t)cap, sizeof *s->row);
  s->seconds = calloc((size_t)cap, sizeof *s->seconds);
  s->sorted = calloc((size_t)cap, sizeof *s->sorted);
  return (s->row != NULL && s->seconds != NULL && s->sorted != NULL)
             ? BASE_OK
             : BASE_FAIL(err, BASE_ENOMEM, "no memory for %d samples", cap);
}

static void sampling_close(sampling *s) {
  free(s->row);
  free(s->seconds);
  free(s->sorted);
}

/* Times stand only where the method came to an end worth timing. */
static bool timed_status(run_status s) {
  return s == RUN_OK || s == RUN_NEAR || s == RUN_STALLED || s == RUN_BUDGET || s == RUN_MAX_ITER ||
         s == RUN_TIME_LIMIT;
}

static void clear_times(record *r) {
  r->t_contacts_s = r->t_assemble_s = r->t_setup_s = r->t_factor_s = (double)NAN;
  r->t_solve_s = r->t_share_s = r->t_advance_s = r->t_watch_s = r->t_total_s = r->t_step_s =
      (double)NAN;
  r->t_step_max_s = r->t_step_p50_s = r->t_step_p95_s = r->t_step_p99_s = (double)NAN;
  r->share_1ms = r->share_4ms = r->share_16ms = r->t_cpu_s = (double)NAN;
}

static base_status take_sample(measured *m, const record *base, sampling *s, base_error *err) {
  record *r = &s->row[s->n];
  struct rusage before;
  struct rusage after;
  *r = *base;
  const double from = base_seconds();
  (void)getrusage(RUSAGE_THREAD, &before);
  BASE_TRY(m->sample(m, r, &s->seconds[s->n], err));
  (void)getrusage(RUSAGE_THREAD, &after);
  s->longest = fmax(s->longest, base_seconds() - from);
  r->freq_MHz = machine_frequency(sched_getcpu()); /* while the CPU is still at it */
  r->ctx_invol = after.ru_nivcsw - before.ru_nivcsw;
  r->major_faults = after.ru_majflt - before.ru_majflt;
  r->rep = s->n;
  r->n_inner = m->n_inner;
  if (!timed_status(m->status)) {
    clear_times(r);
  }
  s->n++;
  return BASE_OK;
}

/* First touch and lazy binding; stores the answers, which a timed run must not do. */
static base_status warm_up(measured *m, const record *base, sampling *s, base_error *err) {
  answers a;
  m->n_inner = 1;
  if (m->job->solution == NULL) {
    return take_sample(m, base, s, err);
  }
  BASE_TRY(answers_create(&a, m->job->solution, err));
  m->store = &a;
  const base_status done = take_sample(m, base, s, err);
  m->store = NULL;
  const base_status closed = answers_close(&a, done == BASE_OK, err);
  return (done != BASE_OK) ? done : closed;
}

/* Would one more sample end before the process is killed? */
static bool time_left(const measured *m, const sampling *s) {
  return base_seconds() - s->from + 1.2 * s->longest < m->job->campaign->limits.time;
}

/* As many evaluations in a sample as fill `inner`. The first one, row 0, has in it what happens once in a process. It is trusted only
 * where it fills that ten times, or where verdicts are all that is asked. Samples of growing number follow until one would not need
 * twice as many; the last of them is row 1, and `looked` says that there was one. Returns the seconds of one evaluation in `once`. */
static base_status calibrate(measured *m, const record *base, sampling *s, bool *looked,
                             double *once, base_error *err) {
  const double inner = m->job->campaign->sampling.inner;
  *once = s->seconds[0];
  const double trusted = (m->job->campaign->sampling.max_samples == 1) ? inner : 10.0 * inner;
  *looked = false;
  if (!timed_status(m->status) || m->sweep != NULL || !(*once > 0.0) || *once >= trusted) {
    return BASE_OK;
  }
  for (double wanted = ceil(inner / *once); time_left(m, s);) {
    m->n_inner = (int)fmin(wanted, 1e6);
    BASE_TRY(take_sample(m, base, s, err));
    s->n--;
    *once = s->seconds[s->n];
    wanted = (*once > 0.0) ? fmin(ceil(inner / *once), 1e6) : 1e6;
    *looked = true;
    if (!timed_status(m->status) || wanted < 2.0 * m->n_inner) {
      m->n_inner = (int)fmax(m->n_inner, wanted);
      break;
    }
  }
  return BASE_OK;
}

static bool known_well(const measured *m, sampling *s) {
  memcpy(s->sorted, s->seconds, (size_t)s->n * sizeof *s->sorted);
  return stats_half_width(s->sorted, s->n) <= m->job->campaign->sampling.half_width;
}

/* Between `least` and `most` samples; other answers than the warm-up's are flagged. */
static base_status take_samples(measured *m, const record *base, const char *hash, int least,
                                int most, sampling *s, base_error *err) {
  const double budget = m->job->campaign->sampling.budget;
  const double from = base_seconds();
  while (s->n < most) {
    BASE_TRY(take_sample(m, base, s, err));
    if (strcmp(s->row[s->n - 1].solution_hash, hash) != 0) {
      record_flag(&s->row[s->n - 1], "not_repeatable");
    }
    const bool enough = s->n >= least && (known_well(m, s) || base_seconds() - from > budget);
    if (enough || !time_left(m, s)) {
      break;
    }
  }
  return BASE_OK;
}

/* As many again as lie far from the others, once. Nothing is deleted. */
static base_status measure_again(measured *m, const record *base, sampling *s, base_error *err) {
  const int again = outliers_flag(s->row, s->n);
  for (int k = 0; k < again && s->n < s->cap && time_left(m, s); k++) {
    BASE_TRY(take_sample(m, base, s, err));
    record_flag(&s->row[s->n - 1], "remeasured");
  }
  (void)outliers_flag(s->row, s->n);
  return BASE_OK;
}

static base_status repeat(measured *m, const record *base, sampling *s, base_error *err) {
  const campaign_sampling *c = &m->job->campaign->sampling;
  char hash[sizeof base->solution_hash];
  BASE_TRY(warm_up(m, base, s, err));
  double once;
  bool looked;
  BASE_TRY(calibrate(m, base, s, &looked, &once, err));
  if (looked && !time_left(m, s)) { /* the last one that was looked at is as good a sample as any */
    const bool same = strcmp(s->row[1].solution_hash, s->row[0].solution_hash) == 0;
    s->row[0] = s->row[1];
    s->row[0].rep = 0;
    if (!same) {
      record_flag(&s->row[0], "not_repeatable");
    }
    return BASE_OK;
  }
  if (!time_left(m, s) || (c->max_samples == 1 && m->n_inner == 1)) {
    record_flag(&s->row[0],
                "first_run"); /* no second one fits, or verdicts are all that is asked */
    return BASE_OK;
  }
  memcpy(hash, s->row[0].solution_hash, sizeof hash);
  s->n = 0;
  if (m->status != RUN_OK || once > c->budget) {
    return take_samples(m, base, hash, 1, 1, s, err);
  }
  const int least = (once > 10.0 && c->samples > 3) ? 3 : c->samples;
  BASE_TRY(take_samples(m, base, hash, least, c->max_samples, s, err));
  return measure_again(m, base, s, err);
}

/* ---- the cell ---------------------------------------------------------------------------------*/

static base_status prepare(measured *m, record *r, base_error *err) {
  if (m->job->campaign->sampling.cold) {
    m->n_sweep = machine_sweep_length();
    m->sweep = calloc(m->n_sweep, sizeof *m->sweep);
    if (m->sweep == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "no memory to empty the caches");
    }
  }
  const cell *c = m->job->cell;
  return (c->formulation[0] != '\0') ? cell_scene_prepare(m, r, err)
         : sequence_is(c->problem)   ? cell_sequence_prepare(m, r, err)
                                     : cell_lcp_prepare(m, r, err);
}

static void close_measured(measured *m) {
  free(m->z);
  free(m->sweep);
  sequence_free(&m->sequence);
  problem_source_close(&m->source);
  solver_choice_free(&m->solver);
  if (m->is_scene) {
    simulation_close(&m->sim);
  }
}

/* unstored: answers or history could not be written, which says nothing of the cell (cell_run.h). */
static void emit_error(record *r, const base_error *err, bool unstored, isolate_channel *out) {
  const run_status word = (err->code == BASE_ENOMEM)         ? RUN_OOM
                          : (err->code == BASE_EUNSUPPORTED) ? RUN_UNSUPPORTED
                                                             : RUN_ERROR;
  r->rep = 0;
  SET_TEXT(r->status, unstored ? "" : run_status_name(word));
  (void)snprintf(r->note, sizeof r->note, "%.230s", err->text);
  (void)isolate_emit(out, r);
}

/* The untimed twin: one evaluation with its history written. */
static base_status run_twin(measured *m, const record *base, sampling *s, base_error *err) {
  trace_file t;
  BASE_TRY(trace_open(&t, m->job->trace, err));
  m->n_inner = 1;
  m->trace = &t;
  const base_status done = take_sample(m, base, s, err);
  if (done == BASE_OK) {
    clear_times(&s->row[0]);
    if (t.full) {
      record_flag(&s->row[0], "trace_cut");
    }
  }
  return trace_finish(&t, done, err);
}

void cell_run(const cell_job *job, isolate_channel *out) {
  record base;
  base_error err = {0};
  measured m = {.job = job, .status = RUN_OK};
  sampling s = {0};
  cell_identity(job, &base);
  const int most = job->campaign->sampling.max_samples;
  base_status done = sampling_open(&s, 2 * most + 1, &err);
  if (done == BASE_OK) {
    done = prepare(&m, &base, &err);
  }
  bool unstored = false; /* everything was read before: the only files are our own */
  if (done == BASE_OK) {
    done = (job->trace != NULL ? run_twin : repeat)(&m, &base, &s, &err);
    unstored = done == BASE_EIO;
  }
  for (int i = 0; done == BASE_OK && i < s.n; i++) {
    (void)isolate_emit(out, &s.row[i]);
  }
  if (done != BASE_OK) {
    emit_error(&base, &err, unstored, out);
  }
  sampling_close(&s);
  close_measured(&m);
}

base_status cell_replay(const cell_job *job, const char *path, record *out, base_error *err) {
  measured m = {.job = job, .status = RUN_OK, .n_inner = 1};
  answers a;
  double seconds;
  cell_identity(job, out);
  BASE_TRY(answers_open(&a, path, err));
  m.replay = &a;
  base_status done = prepare(&m, out, err);
  if (done == BASE_OK) {
    done = m.sample(&m, out, &seconds, err);
  }
  if (done == BASE_OK) {
    done = answers_finish(&a, err);
  }
  (void)answers_close(&a, false, NULL);
  close_measured(&m);
  return done;
}
