/* equilibrate.h - row and column factors that undo the scaling a problem came with.
 *
 * For dense and CSC: 1-norm Sinkhorn-Knopp iterations r_i = 1 / sum_j |M_ij| c_j, c_j = 1 / sum_i
 * r_i |M_ij|; they find, up to one scalar, the D1^-1 and D2^-1 of a matrix D1 B D2 whose |B| is
 * doubly stochastic after a symmetric scaling, so a badly scaled symmetric B comes back symmetric.
 * For the factored form r = c = 1 / sqrt(M_ii). Zero lines get 1. */
#pragma once

#include "lcp/lcp_problem.h"

/* r[n], c[n]; d[n] is the diagonal. Cost 20 products. */
void lcp_equilibrate(const lcp_matrix *M, const double *d, double *r, double *c);
