/* lcp/lcp_islands.h - a problem that falls into parts, solved part by part by one solver.
 *
 * Two blocks belong together where M couples them: of J W J' + S, also where it stands beside a stored matrix, through a body that
 * moves (what is fixed connects nothing) or through S; of other matrices through an entry that is not zero. The parts, the islands, are what is
 * left of that relation; an island is a problem of the same kind, storage and traits, with its rows in their old order, and the answers side by
 * side are an answer of the whole. Islands are numbered by their first rows.
 *
 * The islands are shared out to the crew of the thread that asks (base/crew.h). Each has an instance of the solver of its own,
 * kept from problem to problem by its number, so that what an answer comes from does not depend on how many threads there are:
 * same bits for any number of them. A problem of one island is handed on as it is, and so is the crew. Whoever judges sees
 * the whole problem. */
#pragma once

#include "lcp/lcp_instance.h"

typedef struct lcp_islands lcp_islands; /* opaque: owns workspace and instances */

/* `opt` is borrowed and must outlive it. */
base_status lcp_islands_open(lcp_islands **out, const lcp_solver *s, const void *opt,
                             base_error *err);
void lcp_islands_close(lcp_islands *s); /* accepts NULL */

/* z[n]: start point in, answer out. The outcome is that of the island that fares worst: a proof of infeasibility first (it proves
 * that of the whole; the certificate is of the whole), then the later word of LCP_OUTCOME_LIST. Work is the sum, the residual the
 * largest. Errors are the first island's that has one. */
base_status lcp_islands_solve(lcp_islands *s, const lcp_problem *p, double *z, lcp_result *res,
                              base_error *err);

/* Finds and cuts out the islands alone, where p has its answer from elsewhere. z[n] goes with them. BASE_ENOMEM only. */
base_status lcp_islands_cut_out_of(lcp_islands *s, const lcp_problem *p, double *z,
                                   base_error *err);

/* One of them, valid until the next problem. */
typedef struct lcp_islands_view {
  int number;           /* of the island */
  const lcp_problem *p; /* its problem */
  const int *row;       /* per row: in the whole problem; NULL where the island is all of it */
} lcp_islands_view;

/* k: 0 .. count-1, the largest first. */
lcp_islands_view lcp_islands_at(const lcp_islands *s, int k);

int lcp_islands_count(const lcp_islands *s);   /* of the last problem */
int lcp_islands_largest(const lcp_islands *s); /* unknowns of its largest */
lcp_times
lcp_islands_times(const lcp_islands *s); /* its wall time; finding and cutting out is set-up */
size_t lcp_islands_bytes(const lcp_islands *s); /* workspaces of all instances [bytes] */
