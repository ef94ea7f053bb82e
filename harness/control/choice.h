/* harness/control/choice.h - which formulation and solver for a scene and an error, from measured rows of other scenes, or of
 * the same.
 *
 * A row says what one combination took to reach one error of one scene (scripts/bench_error measures them). The
 * CHOICE_NEAR scenes whose features are nearest count by 1 / (CHOICE_SOFT + distance)^2; the cost of a combination is the weighted
 * mean of log(time / best time of that scene), a row that did not keep the error, or is not there, being
 * CHOICE_FAILED times the best. The rows of all errors count, a decade from E by CHOICE_DECADE of the weight: which combination
 * is the cheaper one in a scene changes little with the error, and one row tells it worse than several. What did not keep an error below E says
 * nothing. The cheapest comes first. `sure` is the weighted share of the scenes in which the combination kept E itself, times how near they are: 1
 * / (1 + mean distance). */
#pragma once

#include "harness/control/features.h"

enum { CHOICE_NEAR = 8, CHOICE_TEXT = 96, CHOICE_MOST = 64 };
#define CHOICE_SOFT   0.25
#define CHOICE_FAILED 100.0
#define CHOICE_DECADE 0.5

typedef struct choice_candidate {
  char formulation[CHOICE_TEXT], solver[CHOICE_TEXT];
  double cost; /* expected time over the best combination's [1] */
  double sure; /* 0 to 1 */
} choice_candidate;

typedef struct choice {
  char rows[512];     /* the file they come from */
  int n_scene, n_row; /* in the file */
  int n_near;
  char near[CHOICE_NEAR][CHOICE_TEXT];
  double distance[CHOICE_NEAR];
  int n; /* candidates, best first */
  choice_candidate candidate[CHOICE_MOST];
} choice;

/* path: a file of rows, or a folder that holds choices.tsv; NULL: the rows that the program comes with. BASE_EINVAL names the
 * line, BASE_EIO the file. The rows of the largest error not above E stand for E, or of the smallest there is. */
base_status choice_make(const features *f, double E, const char *path, choice *out,
                        base_error *err);
