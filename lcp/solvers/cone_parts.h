/* cone_parts.h - exact Coulomb friction with torsion or rolling at one contact, by Newton's method. */
#pragma once

#include "lcp/solvers/cone_block.h"

/* The block of cone_block.h with b[0] < 0: zeros of Alart & Curnier's functions
 *
 *   w_n / A_nn = 0,   r_k - P_k(r_k - w_k / a_k) = 0
 *
 * with P_k the projection onto |r_k| <= mu_k r_n and a_k the largest diagonal of part k, by damped semismooth Newton steps from the
 * frictionless impulse (Alart & Curnier 1991). Writes r[k->size]. False, and r as it was, where the steps
 * do not come to rounding, or come to numbers so large that rounding is not small against b, as along a null vector of A: nothing is known of the
 * block then. */
bool lcp_cone_parts_newton(const lcp_block *k, const double *A, const double *b, double *r);
