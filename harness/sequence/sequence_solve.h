/* harness/sequence/sequence_solve.h - a solver on a sequence, each problem from a start point that is made of its own earlier
 * answers by the names of the rows (sequence.h). The problems are given: no answer changes the next one.
 *
 *   cold       zero
 *   previous   the last answer; zero where a row has no past
 *   basis      the last basis that the solver handed over, without its numbers: a row that was basic starts in the middle of
 *              its box, or at the largest number of the last answer; any other where it was
 *   predicted  2 z_k - z_(k-1) of the last two answers, put back into the set; z_k where a row has one past only
 *
 * All but cold are clipped into the bounds and cones of the problem at hand. An answer counts whatever the judge says of it,
 * as it would for a caller who has no judge, but one that is not finite is forgotten. */
#pragma once

#include "harness/choice/solver_choice.h"
#include "harness/measure/answers.h"
#include "harness/measure/trace.h"
#include "harness/sequence/sequence.h"
#include "lcp/lcp_instance.h"

#define SEQUENCE_STARTS(X)                                                                         \
  X(COLD, "cold") X(PREVIOUS, "previous") X(BASIS, "basis") X(PREDICTED, "predicted")
#define SEQUENCE_START_ENUM_(id, word) SEQUENCE_##id,
typedef enum sequence_start {
  SEQUENCE_STARTS(SEQUENCE_START_ENUM_) SEQUENCE_START_COUNT
} sequence_start;

/* NULL or "": cold. BASE_EINVAL names the words. */
base_status sequence_start_find(const char *text, sequence_start *out, base_error *err);
const char *sequence_start_name(sequence_start s);

/* What a pass leaves of each problem. */
typedef struct sequence_cost {
  double seconds; /* set-up, factorisation and solve [s] */
  long work;      /* iterations and pivots */
} sequence_cost;

typedef struct sequence_request {
  const sequence *sequence;
  const solver_choice *solver;
  sequence_start start;
  answers *store, *replay; /* NULL: none; as in simulate.h */
  trace_file *trace;       /* NULL: none */
} sequence_request;

typedef struct sequence_result {
  run_status status,
      claimed; /* worst of all; RUN_UNSUPPORTED: the solver cannot start so, or not solve this */
  bool verified;
  char note[240];     /* first trouble */
  long n, n_unsolved; /* solved, and of these not ok */
  lcp_verdict worst;  /* of each number the largest */
  lcp_work work;
  lcp_times time; /* [s], summed */
  const char *variant;
  lcp_storage storage;
  size_t bytes;
  uint64_t hash; /* of every answer */
} sequence_result;

/* One pass. cost[n of the sequence] may be NULL. An unsupported combination is a status, an error misuse or machine trouble. */
base_status sequence_solve(const sequence_request *q, sequence_result *out, sequence_cost *cost,
                           base_error *err);

/* Where the costs of nothing differ, a problem counts as slower by chance once in 252. */
enum { SEQUENCE_PASSES = 5, SEQUENCE_UNCOUNTED = -1 };

/* How many problems a start makes dearer than a cold one. */
typedef struct sequence_regressions {
  long work; /* more iterations and pivots; SEQUENCE_UNCOUNTED: one of the starts is not defined */
  long
      time; /* in each of SEQUENCE_PASSES passes slower than in the slowest cold one of as many, in turns */
} sequence_regressions;

/* Times are uncounted, too, where the passes would take more than `limit` [s]; then the first ones tell the work. */
base_status sequence_compare(const sequence_request *q, double limit, sequence_regressions *out,
                             base_error *err);
