/* lcp/lcp_outcome.h - what a method found out, in the words of every result file. */
#pragma once

#define LCP_OUTCOME_LIST(X)                                                                        \
  X(LCP_SOLVED, "ok")             /* own stopping test met */                                      \
  X(LCP_MAX_ITER, "max_iter")     /* stop.max_iter reached */                                      \
  X(LCP_TIME_LIMIT, "time_limit") /* stop.max_seconds reached */                                   \
  X(LCP_STALLED, "stalled")       /* no progress, tolerance not met */                             \
  X(LCP_RAY, "ray")               /* ended on a ray that proves nothing */                         \
  X(LCP_INFEASIBLE, "infeasible") /* proved: a certificate y >= 0, M'y <= 0, q'y < 0 exists */     \
  X(LCP_NUMERICAL, "numerical")   /* pivot or factorisation broke down, NaN */

#define LCP_OUTCOME_ENUM_(id, text) id,
typedef enum lcp_outcome { LCP_OUTCOME_LIST(LCP_OUTCOME_ENUM_) LCP_OUTCOME_COUNT } lcp_outcome;

const char *lcp_outcome_name(lcp_outcome o);
