/* harness/campaign/compare.h - paired comparison of two sets of measurements.
 *
 * Per pair of cells: ratio of medians B/A with a 95 % bootstrap interval that resamples processes and,
 * inside them, samples (Kalibera & Jones 2013: most of the variance is between processes). A
 * difference is named only where the interval excludes 1 and the ratio leaves the noise floor. */
#pragma once

#include "harness/campaign/doctor.h"
#include "harness/plan/record.h"

typedef enum compare_word { COMPARE_SAME, COMPARE_FASTER, COMPARE_SLOWER } compare_word;

typedef struct compare_pair {
  const record *a, *b; /* first rows of the two cells */
  int n_a, n_b;        /* samples */
  double median_a, median_b, ratio, lo, hi;
  double floor;      /* noise floor for cells of this size, |log ratio| [1] */
  compare_word word; /* of B against A */
} compare_pair;

typedef struct compare_side {
  const record_table *rows;
  const char *solver; /* only its rows; NULL: all, paired by solver too */
} compare_side;

/* All pairs (owned array, free()), in the order of A. Only rows with status ok and a time count. The
 * noise floor of a pair is that of the larger workspace of the two. */
base_status compare_sides(const compare_side *a, const compare_side *b, const char *column,
                          const doctor_floor *noise, compare_pair **out, int *n, base_error *err);
