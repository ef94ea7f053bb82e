/* harness/campaign/compare.h - paired comparison of two sets of measurements.
 *
 * Per pair of cells: ratio of medians B/A with a 95 % bootstrap interval that resamples processes and,
 * inside them, samples (Kalibera & Jones 2013: most of the variance is between processes). A
 * difference is named only where the interval excludes 1 and the ratio leaves the noise floor, and
 * where nothing else was at work: a pair with a disturbed row is inconclusive, whatever its ratio. */
#pragma once

#include "harness/campaign/doctor.h"
#include "harness/plan/record.h"

typedef enum compare_word {
  COMPARE_SAME,
  COMPARE_FASTER,
  COMPARE_SLOWER,
  COMPARE_DISTURBED,
  COMPARE_WORDS
} compare_word;

typedef struct compare_pair {
  const record *a, *b; /* first rows of the two cells */
  int n_a, n_b;        /* samples */
  double median_a, median_b, ratio, lo, hi;
  double floor;      /* noise floor for cells of this size plus `drift`, |log ratio| [1] */
  double drift;      /* of the canaries of the two cells, |log ratio| [1] */
  compare_word word; /* of B against A */
} compare_pair;

typedef struct compare_side {
  const record_table *rows;
  const char *solver; /* only its rows; NULL: all, paired by solver too */
} compare_side;

/* Cells with a partner of which one side has no time: they failed, and are in no ratio. */
typedef struct compare_failures {
  int a, b, both; /* of A alone, of B alone, of both */
  int few;        /* solved on both sides, but one has a single sample: no interval */
} compare_failures;

/* CPUs of other work from which a row counts as disturbed: a background task is less, a job beside
 * is one. Rows without column load_other: from this many above the row's own one in `load1`. */
#define COMPARE_OTHERS 0.25

/* All pairs (owned array, free()), in the order of A. Only rows with status ok and a time count. The
 * noise floor of a pair is that of the larger workspace of the two. */
base_status compare_sides(const compare_side *a, const compare_side *b, const char *column,
                          const doctor_floor *noise, compare_pair **out, int *n,
                          compare_failures *failed, base_error *err);

/* What disturbed the measuring of a row: "canary_drift", "throttled", "other work"; NULL: nothing
 * that is known. CPU time (column t_cpu_s) does not count what other processes had. */
const char *compare_disturbed(const record *r, const char *column);
