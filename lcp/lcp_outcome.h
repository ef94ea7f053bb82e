/* lcp/lcp_outcome.h - what a method found out, in the words of every result file, and what it hands over as
 * proof. Words and data only: solvers write them, the judge and the verifier read them. */
#pragma once

#define LCP_OUTCOME_LIST(X)                                                                        \
  X(LCP_SOLVED, "ok")             /* own stopping test met */                                      \
  X(LCP_MAX_ITER, "max_iter")     /* stop.max_iter reached */                                      \
  X(LCP_TIME_LIMIT, "time_limit") /* stop.max_seconds reached */                                   \
  X(LCP_STALLED, "stalled")       /* no progress, tolerance not met */                             \
  X(LCP_RAY, "ray")               /* ended on a ray that proves nothing */                         \
  X(LCP_INFEASIBLE, "infeasible") /* proved: a certificate y >= 0, M'y <= 0, q'y < 0 exists */     \
  X(LCP_NUMERICAL, "numerical")   /* pivot or factorisation broke down, NaN */                     \
  X(LCP_BUDGET, "budget")         /* the sweeps asked for are done, nothing was tested */

#define LCP_OUTCOME_ENUM_(id, text) id,
typedef enum lcp_outcome { LCP_OUTCOME_LIST(LCP_OUTCOME_ENUM_) LCP_OUTCOME_COUNT } lcp_outcome;

const char *lcp_outcome_name(lcp_outcome o);

/* What a method can hand over as proof. Views into the solver's state, valid until its next
 * prepare or solve. */
typedef enum lcp_certificate_kind {
  LCP_CERT_NONE,
  LCP_CERT_BASIS,  /* basis[i] = true: z_i basic (w_i = 0), false: w_i basic (z_i = 0) */
  LCP_CERT_FARKAS, /* y >= 0, M'y <= 0, q'y < 0: no feasible point */
  LCP_CERT_RAY,    /* z + t v solves the augmented system for all t >= 0: proves nothing alone */
} lcp_certificate_kind;

typedef struct lcp_certificate {
  lcp_certificate_kind kind;
  const unsigned char *basis; /* n */
  const double *vector;       /* n: y or v */
} lcp_certificate;
