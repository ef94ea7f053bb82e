/* harness/campaign/noise.h - the noise floor of a machine: how far two measurements of the same thing are
 * apart. The same fixed work is timed under two labels, interleaved at random (A/A), for three sizes;
 * the floor is the 95th percentile of |log ratio of medians| (results/METHOD.md, rule 9). */
#pragma once

#include "lcp/base/status.h"

#include <stdint.h>

enum { NOISE_CLASSES = 3 };

typedef struct noise_class {
  const char *name;
  double up_to;   /* workspace of cells that this class speaks for, at most [B]; Inf: any */
  double seconds; /* one sample takes about [s] */
  double floor;   /* 95th percentile of |log ratio| [1] */
  double spread;  /* (q75 - q25)/median of single samples [1] */
} noise_class;

typedef struct noise_report {
  double clock_cost, clock_step; /* of CLOCK_MONOTONIC: one reading, smallest step seen [s] */
  double bandwidth;              /* streaming reads [B/s] */
  noise_class size[NOISE_CLASSES];
  double floor; /* the largest of them */
} noise_report;

/* About `seconds` of measuring in all. */
void noise_measure(double seconds, uint64_t seed, noise_report *out);

/* CLOCK_MONOTONIC: what one reading costs, and the smallest step seen [s]. Less than a millisecond. */
void noise_clock(double *cost, double *step);
