/* harness/measure/verdict.h - the status words of every result, and how they are earned.
 *
 * The solver claims, the harness judges: a word is derived from the claim and from residuals that
 * were recomputed from the data (lcp_judge.h), never from the claim alone. */
#pragma once

#include "lcp/lcp_judge.h"
#include "lcp/lcp_solver.h"

/* In order of severity; a run of many solves carries its worst word. */
#define RUN_STATUS_LIST(X)                                                                         \
  X(RUN_OK, "ok")                   /* claimed and verified */                                     \
  X(RUN_NEAR, "near")               /* missed the verification tolerance by less than ten times */ \
  X(RUN_STALLED, "stalled")         /* gave up without progress */                                 \
  X(RUN_BUDGET, "budget")           /* not solved: the sweeps asked for are done */                \
  X(RUN_MAX_ITER, "max_iter")       /* iteration limit */                                          \
  X(RUN_TIME_LIMIT, "time_limit")   /* the solver's own time limit */                              \
  X(RUN_RAY, "ray")                 /* ended on a ray that proves nothing */                       \
  X(RUN_INFEASIBLE, "infeasible")   /* proved, and the proof holds */                              \
  X(RUN_UNVERIFIED, "unverified")   /* the solver said yes (or infeasible), the check said no */   \
  X(RUN_NUMERICAL, "numerical")     /* NaN, Inf, breakdown, joints not kept */                     \
  X(RUN_UNSUPPORTED, "unsupported") /* the combination is not defined */                           \
  X(RUN_SKIPPED, "skipped")         /* by policy, with a note */                                   \
  X(RUN_TIMEOUT, "timeout")         /* killed at the wall-time limit */                            \
  X(RUN_OOM, "oom")                 /* memory limit reached */                                     \
  X(RUN_CRASH, "crash")             /* died by a signal */                                         \
  X(RUN_NO_OUTPUT, "no_output")     /* exited without a result */                                  \
  X(RUN_FLOOD, "flood")             /* killed for flooding its output */                           \
  X(RUN_ERROR, "error")             /* a library refused the call; see note */

#define RUN_STATUS_ENUM_(id, text) id,
typedef enum run_status { RUN_STATUS_LIST(RUN_STATUS_ENUM_) RUN_STATUS_COUNT } run_status;

const char *run_status_name(run_status s);
bool run_status_find(const char *name, run_status *out);
run_status run_status_worse(run_status a, run_status b);

/* Residual rho that counts as verified for this solver. */
double verdict_tolerance(const lcp_solver *s);

/* Tolerance that the options ask for: member stop.tol, which every options struct begins with. */
double verdict_asked(const lcp_solver *s, const void *opt);

/* The word for one solve. `ok` means claimed, and rho within the larger of the asked tolerance and
 * verdict_tolerance and small against the data there (lcp_judged_small); `verified` is the same at verdict_tolerance, whatever was
 * claimed or asked;
 * `infeasible` means claimed with a Farkas vector that lcp_certificate_verify finds right. */
run_status verdict_of(const lcp_solver *s, const void *opt, const lcp_problem *p,
                      const lcp_result *claim, const lcp_verdict *v, bool *verified);
