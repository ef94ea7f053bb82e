/* bench_sweep.c - time of one matrix-free Gauss-Seidel sweep per contact, against plain sweeps.
 *
 * usage: bench_sweep [REPETITIONS] [LARGEST]
 * CSV on stdout, one row per method and size: median, first and third quartile over repetitions of
 * at least 400 000 contact sweeps each, in CPU time of the thread; the methods take turns inside a
 * repetition. The closing comment lines are the fitted exponents of sweep time in contacts (least
 * squares of logs, sizes from 100 on). */
#include "lcp/base/clock.h"
#include "lcp/base/fields.h"
#include "lcp/solvers/contact_sweep.h"
#include "tests/support/plain_sweep.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { METHODS = 3, REPS_MAX = 101 };
static const char *const names[METHODS] = {"batches", "plain_rows", "plain_frames"};

typedef struct bench {
  contact_bed bed;
  lcp_gs gs;
  lcp_contact_sweep fast;
  plain_contact_rows *rows;
  plain_contact_frames *frames;
  plain_body *body;
  double *v, *z;
  void *memory;
} bench;

static void carve(bench *b, base_arena *a) {
  const lcp_capacity cap = lcp_problem_capacity(&b->bed.p);
  lcp_gs_layout(&b->gs, &cap, a);
  lcp_contact_sweep_layout(&b->fast, &cap, a);
  b->rows = BASE_ARRAY(a, plain_contact_rows, b->bed.n_contact);
  b->frames = BASE_ARRAY(a, plain_contact_frames, b->bed.n_contact);
  b->body = BASE_ARRAY(a, plain_body, b->bed.n_body + 1);
  b->v = BASE_ARRAY(a, double, 6 * (b->bed.n_body + 1));
  b->z = BASE_ARRAY(a, double, b->bed.p.M.n);
}

static bool bench_open(bench *b, int n_contact) {
  b->bed = contact_bed_open(n_contact, 7);
  if (b->bed.memory == NULL) {
    return false;
  }
  base_arena a = base_arena_measuring();
  carve(b, &a);
  b->memory = base_alloc(a.used);
  if (b->memory == NULL) {
    return false;
  }
  a = base_arena_over(b->memory, a.used);
  carve(b, &a);
  base_error err = {0};
  if (lcp_gs_prepare(&b->gs, &b->bed.p, &err) != BASE_OK ||
      !lcp_contact_sweep_prepare(&b->fast, &b->gs, &b->bed.p)) {
    (void)fprintf(stderr, "bench_sweep: %s\n", err.text);
    return false;
  }
  plain_rows_fill(&b->bed, NULL, b->rows);
  plain_frames_fill(&b->bed, NULL, b->frames, b->body);
  memset(b->v, 0, 6 * ((size_t)b->bed.n_body + 1) * sizeof *b->v);
  memset(b->z, 0, (size_t)b->bed.p.M.n * sizeof *b->z);
  lcp_contact_sweep_import(&b->fast, &b->bed.p, b->z);
  return true;
}

static void bench_close(bench *b) {
  contact_bed_close(&b->bed);
  free(b->memory);
}

static void sweeps(bench *b, int method, int count) {
  for (int k = 0; k < count; k++) {
    if (method == 0) {
      lcp_contact_sweep_run(&b->fast, 1.0, 1);
    } else if (method == 1) {
      plain_rows_sweep(b->rows, b->bed.n_contact, b->v);
    } else {
      plain_frames_sweep(b->frames, b->bed.n_contact, b->body, b->v);
    }
  }
}

static int compare(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Prints the row; returns the median [ns/contact/sweep]. */
static double measure(bench *b, int method, double *seconds, int reps, int count) {
  const double scale = 1e9 / ((double)count * b->bed.n_contact);
  qsort(seconds, (size_t)reps, sizeof *seconds, compare);
  const double median = seconds[reps / 2] * scale;
  const int bytes[METHODS] = {200, (int)sizeof(plain_contact_rows),
                              (int)sizeof(plain_contact_frames)};
  printf("%s,%d,%d,%d,%d,%.2f,%.2f,%.2f,%.3f\n", names[method], b->bed.n_contact, b->bed.n_body,
         bytes[method], count, median, seconds[reps / 4] * scale, seconds[3 * reps / 4] * scale,
         b->bed.n_contact / (4.0 * b->fast.in.n_batch));
  (void)fflush(stdout);
  return median;
}

/* Sums of the least-squares fit of log seconds over log contacts. */
typedef struct fit {
  double x, y, xx, xy;
  int n;
} fit;

static void add_point(fit *f, double contacts, double seconds) {
  const double x = log(contacts), y = log(seconds);
  f->x += x;
  f->y += y;
  f->xx += x * x;
  f->xy += x * y;
  f->n++;
}

/* All methods at one size; sizes from 100 on enter the fits. */
static bool run_size(int contacts, int reps, fit *fits) {
  static double seconds[METHODS][REPS_MAX];
  bench b = {0};
  const bool ok = bench_open(&b, contacts);
  const int count = 1 + 400000 / contacts;
  for (int r = -1; ok && r < reps; r++) { /* -1: warm-up */
    for (int m = 0; m < METHODS; m++) {
      const double started = base_cpu_seconds();
      sweeps(&b, m, count);
      seconds[m][(r < 0) ? 0 : r] = base_cpu_seconds() - started;
    }
  }
  for (int m = 0; ok && m < METHODS; m++) {
    const double median = measure(&b, m, seconds[m], reps, count);
    if (contacts >= 100) {
      add_point(&fits[m], contacts, median * contacts);
    }
  }
  bench_close(&b);
  return ok;
}

int main(int argc, char **argv) {
  static const int sizes[] = {40, 100, 400, 1600, 6400, 20000, 100000, 400000, 1000000};
  int reps = 9, largest = 1000000;
  fit fits[METHODS] = {{0}};
  if ((argc > 1 && !base_parse_int(argv[1], &reps)) ||
      (argc > 2 && !base_parse_int(argv[2], &largest)) || reps < 1 || reps > REPS_MAX) {
    (void)fprintf(stderr, "bench_sweep: repetitions: need 1 to %d\n", (int)REPS_MAX);
    return 2;
  }
  printf("method,contacts,bodies,bytes_per_contact,sweeps,median_ns,q1_ns,q3_ns,batched\n");
  for (int i = 0; i < BASE_COUNT(sizes) && sizes[i] <= largest; i++) {
    if (!run_size(sizes[i], reps, fits)) {
      return 1;
    }
  }
  for (int m = 0; m < METHODS && fits[m].n > 1; m++) {
    const fit *f = &fits[m];
    printf("# %s: exponent %.3f over %d sizes\n", names[m],
           (f->n * f->xy - f->x * f->y) / (f->n * f->xx - f->x * f->x), f->n);
  }
  return 0;
}
