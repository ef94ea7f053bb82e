#include "harness/campaign/noise.h"

#include "harness/cell/stats.h"
#include "lcp/base/clock.h"
#include "lcp/base/rng.h"

#include <math.h>
#include <stdlib.h>

/* ---- clock and memory -------------------------------------------------------------------------*/

void noise_clock(double *cost, double *step) {
  enum { N = 20000 };
  const double from = base_seconds();
  double last = from;
  *step = HUGE_VAL;
  for (int i = 0; i < N; i++) {
    const double now = base_seconds();
    if (now > last) {
      *step = fmin(*step, now - last);
    }
    last = now;
  }
  *cost = (last - from) / N;
}

static void measure_bandwidth(noise_report *out) {
  const size_t n = (size_t)8 << 20; /* 64 MB: beyond every cache */
  double *x = calloc(n, sizeof *x);
  out->bandwidth = (double)NAN;
  if (x == NULL) {
    return;
  }
  for (size_t i = 0; i < n; i++) {
    x[i] = 1.0;
  }
  double best = HUGE_VAL;
  volatile double kept = 0.0;
  for (int k = 0; k < 3; k++) {
    const double from = base_seconds();
    double sum[4] = {0, 0, 0, 0};
    for (size_t i = 0; i < n; i += 4) {
      sum[0] += x[i];
      sum[1] += x[i + 1];
      sum[2] += x[i + 2];
      sum[3] += x[i + 3];
    }
    kept = kept + sum[0] + sum[1] + sum[2] + sum[3];
    best = fmin(best, base_seconds() - from);
  }
  out->bandwidth = (double)(n * sizeof *x) / best;
  free(x);
}

/* ---- A/A --------------------------------------------------------------------------------------*/

/* Fixed work over a working set of n doubles. */
static double sweep(double *x, size_t n, int rounds) {
  double sum = 0.0;
  for (int k = 0; k < rounds; k++) {
    for (size_t i = 1; i < n; i++) {
      sum += x[i] * x[i - 1] * 1e-9;
    }
    x[(size_t)k % n] += 1e-12 * sum;
  }
  return sum;
}

enum { PAIRS = 64, SAMPLES = 7 };

static double timed(double *x, size_t n, int rounds) {
  const double from = base_seconds();
  volatile double kept = sweep(x, n, rounds);
  (void)kept;
  return base_seconds() - from;
}

/* Medians of SAMPLES timings under each of two labels, in random order. */
static double log_ratio(double *x, size_t n, int rounds, base_rng *rng, double *one) {
  double t[2][SAMPLES] = {{0}};
  int filled[2] = {0, 0};
  while (filled[0] + filled[1] < 2 * SAMPLES) {
    int label = (int)(base_rng_bits(rng) & 1u);
    label = (filled[label] == SAMPLES) ? 1 - label : label;
    t[label][filled[label]++] = timed(x, n, rounds);
  }
  *one = t[0][0];
  stats_sort(t[0], SAMPLES);
  stats_sort(t[1], SAMPLES);
  return fabs(log(stats_median(t[0], SAMPLES) / stats_median(t[1], SAMPLES)));
}

static void measure_class(noise_class *c, size_t n, int rounds, double budget, base_rng *rng) {
  double *x = calloc(n, sizeof *x);
  double ratio[PAIRS];
  double sample[PAIRS] = {0};
  int m = 0;
  const double from = base_seconds();
  while (x != NULL && m < PAIRS && (m < 5 || base_seconds() - from < budget)) {
    ratio[m] = log_ratio(x, n, rounds, rng, &sample[m]);
    m++;
  }
  free(x);
  stats_sort(ratio, m);
  stats_sort(sample, m);
  c->seconds = stats_median(sample, m);
  c->floor = stats_quantile(ratio, m, 0.95);
  c->spread = (stats_quantile(sample, m, 0.75) - stats_quantile(sample, m, 0.25)) / c->seconds;
}

void noise_measure(double seconds, uint64_t seed, noise_report *out) {
  *out = (noise_report){.size = {{.name = "cache", .up_to = 131072.0},
                                 {.name = "large_cache", .up_to = 4194304.0},
                                 {.name = "memory", .up_to = HUGE_VAL}}};
  base_rng rng = base_rng_seeded(seed);
  noise_clock(&out->clock_cost, &out->clock_step);
  measure_bandwidth(out);
  const double each = seconds / NOISE_CLASSES;
  measure_class(&out->size[0], 2048, 200, each, &rng);
  measure_class(&out->size[1], (size_t)128 << 10, 4, each, &rng);
  measure_class(&out->size[2], (size_t)4 << 20, 1, each, &rng);
  for (int i = 0; i < NOISE_CLASSES; i++) {
    out->floor = fmax(out->floor, out->size[i].floor);
  }
}
