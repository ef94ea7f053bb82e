/* tests/support/tableau_lemke.h - the plain baseline: Lemke's method on a dense n x (2n+2) tableau in
 * double, every column updated at every pivot, lexicographic choice, no scaling, no refactorisation.
 * What textbooks print and what most codes do; the yardstick of bench_lemke. */
#pragma once

#include "lcp/lcp_outcome.h"
#include "lcp/lcp_problem.h"

/* Doubles of `work` for size n. */
size_t tableau_lemke_work(int n);

/* M column-major n*n. z[n] is written when solved (true residual: ask the judge). */
lcp_outcome tableau_lemke(int n, const double *M, const double *q, double *z, double *work,
                          long *pivots);
