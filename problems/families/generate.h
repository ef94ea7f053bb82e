/* problems/families/generate.h - the generators of the case format (MATHEMATICS 4). Indices
 * in formulas are 1-based. Each fills an empty known_lcp, answer included; the caller frees it on
 * success and failure. All data are integers or dyadic rationals, hence exact. */
#pragma once

#include "problems/families/known_lcp.h"

#include <stdbool.h>
#include <stdint.h>

/* M_ii = 1, M_ij = 2 below (upper: above) the diagonal; q = -1, or hat: q_i = -sum_{k<i} 2^(n-k).
 * Murty (1978); n <= 50 with hat. */
base_status generate_murty(known_lcp *k, int n, bool upper, bool hat, base_error *err);
/* M_ii = 4i-3, M_ij = 4 min(i,j) - 2; q = -1. Fathi (1979). */
base_status generate_fathi(known_lcp *k, int n, base_error *err);
/* M_ii = 1, M_ij = -1 for j < i; z = (1,0,1,..), w = (0,1,0,..). Csizmadia, in de Klerk
 * & E.-Nagy (2011). */
base_status generate_csizmadia(known_lcp *k, int n, base_error *err);
/* M_ii = 1, M_{i,i-1} = a, M_{i,i-2} = b cyclic; q = -1, z_i = 1/(1+a+b). Ben Gharbia & Gilbert
 * (2012). */
base_status generate_circulant(known_lcp *k, int n, double a, double b, base_error *err);
/* M = tridiag(off, diag, off); z_i = 1 + (i mod 5) if i mod period else 0. */
base_status generate_tridiagonal(known_lcp *k, int n, double diag, double off, int period,
                                 base_error *err);
/* Column of masses under gravity: contact i carries masses i..n; z_i = gh sum_{k>=i} m_k. */
base_status generate_stack(known_lcp *k, int n, const double *mass, double gh, base_error *err);
/* A row by row r mod 7 - 3, M = A'A + I, q_i = (r mod 21) - 13 with the case format's generator. */
base_status generate_lcg_spd(known_lcp *k, int n, uint32_t seed, base_error *err);
/* A row by row r mod 3 - 1, K_ij = (r mod 11) - 5 skew, M = A'A + I + K. */
base_status generate_lcg_p(known_lcp *k, int n, uint32_t seed, base_error *err);
/* w_i = 1 - z_i, w_{n+1} = a.z - b, w_{n+2} = b - a.z: solvable iff a subset of a sums to b. */
base_status generate_subset_sum(known_lcp *k, int n, const int *a, int b, base_error *err);
