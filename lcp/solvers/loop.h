/* loop.h - the end of an iterative method: shared residual test, cycle detection, honest claim.
 *
 * lcp_stop_test measures rho, which is relative to the size of z. On an infeasible monotone problem
 * z runs away and drags rho below any tolerance although w never gets feasible, so "solved" is
 * claimed here only if the violation is small against the data as well (data_test.h).
 * A deterministic iteration whose iterate returns bit for bit can never end: it is `stalled`
 * (Brent 1980, cycle finding with one stored iterate).
 * Where q is zero and nothing couples a row with others, its answer is zero, and what an iteration makes smaller and smaller never is
 * small against the row's own terms. Such entries are tried as zero once they are within rounding of the largest. */
#pragma once

#include "lcp/lcp_rho_factored.h"
#include "lcp/lcp_solver.h"

/* LCP_STOP_FIELDS for methods whose iteration costs less than a residual test: tested every tenth. */
#define LCP_LOOP_SWEEP_FIELDS(T, tol_, max_iter_) LCP_STOP_FIELDS_EVERY(T, tol_, max_iter_, 10)

/* Of methods that can spend a fixed number of sweeps in place of a tolerance (LCP_BUDGET). */
#define LCP_LOOP_BUDGET_FIELD(T)                                                                   \
  BASE_FIELD(T, budget, BASE_INT, "1", 0, 0, 1e6, "sweeps of every solve, untested; 0: until tol")

typedef struct lcp_loop {
  lcp_stop_state stop;
  lcp_rho_factored factored;
  double *scale;    /* n, r */
  double *seen;     /* n, an earlier iterate */
  double *small;    /* n, what is tried as zero */
  bool homogeneous; /* some entry of q is zero */
  int tried, tries; /* entries that were tried last, and how often their number was another */
  long failed, due; /* tests, and at which of them zeros are tried */
  long tests, next;
  double q_size;   /* max r |q| */
  bool memoryless; /* the next iterate depends on z alone */
  int budget;      /* iterations of a solve, after which it ends untested; 0: it ends by a test */
} lcp_loop;

void lcp_loop_layout(lcp_loop *s, const lcp_capacity *cap, base_arena *a);

/* memoryless: the next iterate depends on z only, so a repeated z proves a cycle. Not needed where a budget is spent. */
void lcp_loop_begin(lcp_loop *s, const lcp_problem *p, bool memoryless);

/* Once per iteration, before it. True when the loop must end. Evaluates only when
 * work.iterations is a multiple of check_every or has reached max_iter; after an evaluation
 * s->stop.w holds M z + q and *fresh (may be NULL) is set. With a budget it only counts: true when that is spent, *fresh
 * before the first iteration. z changes only where it is `solved` with zeros for entries within rounding. */
bool lcp_loop_ended(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, double *z,
                    lcp_trace *trace, lcp_result *res, bool *fresh);

/* Iterations from one that was tested to the next that is. */
long lcp_loop_until_test(const lcp_loop *s, const lcp_stop *stop, const lcp_result *res);

/* In the place of a test that is known to fail: ends a loop that is late or whose iterate came back, like a test. The
 * iteration is not the last. */
bool lcp_loop_put_off(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, const double *z,
                      lcp_result *res);

/* For a method that cannot move z any more: tests it out of turn; `stalled` where it does not pass. */
void lcp_loop_stationary(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, double *z,
                         lcp_trace *trace, lcp_result *res);

/* Does z meet tol? Sets res->residual: of factors by the entries of M where the bound of lcp_stop_test does not tell. For a
 * method that has made its own test against the data. */
bool lcp_loop_met(lcp_loop *s, double tol, const lcp_problem *p, const double *z, lcp_result *res);

/* w = M z + q: where the test at z was made just now (`fresh`) as it found it, otherwise by a product, which is counted. */
void lcp_loop_product(lcp_loop *s, const lcp_problem *p, const double *z, bool fresh, double *w,
                      lcp_result *res);
