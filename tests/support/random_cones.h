/* tests/support/random_cones.h - random frictional contact sets of the nasty kind, in the factored form.
 *
 * 1 to 10 bodies in space, 1 to 48 contacts between them and with the ground; masses 1 to 10^U(0, 6) apart; friction
 * 0, below 1 or up to 10; a third of the sets with torsion and rolling at some contacts; a quarter of the contacts
 * copies of an earlier one, exact or turned and moved by 1e-3 to 1e-9. q = J v_free + b, b >= 0 [m/s] in normal rows
 * only, as a step without restitution poses it: no contact asks to be pushed open. */
#pragma once

#include "problems/families/known_lcp.h"

#include <stdint.h>

base_status random_cones(known_lcp *k, uint64_t seed, base_error *err);
