/* lcp/lcp_instance.h - one solver bound to one workspace, reusable step after step. */
#pragma once

#include "lcp/lcp_solver.h"

typedef struct lcp_instance lcp_instance; /* opaque: owns the workspace */

/* Seconds of the last prepare / factor / solve [s]. */
typedef struct lcp_times {
  double setup, factor, solve;
} lcp_times;

/* `opt` is borrowed and must outlive the instance. *out is NULL on failure. */
base_status lcp_instance_open(lcp_instance **out, const lcp_solver *s, const lcp_capacity *cap,
                              const void *opt, base_error *err);

/* Binds p: grows the workspace if p does not fit, converts the storage if the solver cannot read
 * it (dense <-> CSC, factored -> CSC or dense; factors beside a sparse matrix where the solver is by_factors), prepares and
 * factors. All of it is charged to set-up and factor time. p must stay alive and unchanged until
 * the next prepare. */
base_status lcp_instance_prepare(lcp_instance *k, const lcp_problem *p, base_error *err);

/* Solves the problem last prepared; where q is zero, and every box holds zero, from z = 0, which is an answer. Never allocates
 * unless the solver declares `allocates`. */
base_status lcp_instance_solve(lcp_instance *k, lcp_trace *trace, double *z, lcp_result *res,
                               base_error *err);

lcp_times lcp_instance_times(const lcp_instance *k);

/* Reads the clock no more, and all times are zero: for a caller with a clock of its own, where a problem of a few unknowns
 * takes no longer than the readings. */
void lcp_instance_untimed(lcp_instance *k);

lcp_storage lcp_instance_storage(const lcp_instance *k); /* what the solver read */
/* Gives the workspace back until the next prepare: for who needs room between the solves of a large problem. What the last result
 * points to (a certificate) is gone. */
void lcp_instance_rest(lcp_instance *k);

size_t lcp_instance_bytes(const lcp_instance *k); /* workspace size [bytes] */
void lcp_instance_close(lcp_instance *k);         /* accepts NULL */
