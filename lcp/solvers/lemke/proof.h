/* solvers/lemke/proof.h - proofs that a problem has no feasible point. */
#pragma once

#include "lcp/solvers/lemke/phase_one.h"

/* y >= 0, M'y <= 0, q'y < 0 from the ray of the path on the built system s, into y (by row of the problem). True only
 * when the three hold exactly for the binary numbers of the problem. Else y is the ray. */
bool lemke_ray_proves(const lemke_path *t, const lemke_system *s, const lcp_problem *p, double *y);

/* Searches for such a y by phase one of the simplex method. False, with y lost, where none is found that holds exactly, or
 * s has free rows or does not fit the table. */
bool lemke_search_proof(lemke_path *t, lemke_table *table, const lemke_system *s,
                        const lcp_problem *p, double *y);
