/* harness/check/check_report.h - outcomes of `lcpbench check`, one per judged check. */
#pragma once

#include "harness/util/json_out.h"

typedef enum check_verdict { CHECK_PASSED, CHECK_FAILED, CHECK_SKIPPED } check_verdict;

/* Plain data: travels over the pipe of an isolated run. */
typedef struct check_outcome {
  check_verdict verdict;
  char id[64], formulation[64], solver[64], check[160];
  double step;                     /* [s]; 0: no time step */
  double got, expected, tolerance; /* NaN: not a number */
  char reason[200];                /* why skipped or failed; "" */
} check_outcome;

typedef struct check_report {
  int count[3]; /* by verdict */
  bool json, verbose;
  json_t *all; /* owned; NULL unless json */
} check_report;

void check_report_open(check_report *r, bool json, bool verbose);
void check_report_add(check_report *r, const check_outcome *o); /* prints at once unless json */
bool check_report_close(check_report *r); /* the summary; false: not printed */
