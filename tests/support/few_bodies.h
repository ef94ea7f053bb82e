/* tests/support/few_bodies.h - many contacts on few bodies, in the factored form J W J' + S.
 *
 * One body: a box on a floor, contacts spread over its base. More bodies: contacts between random
 * pairs and with the ground, random normals (a grasp). facets = 0 is frictionless, n = contacts;
 * otherwise the velocity LCP of Stewart & Trinkle with n = contacts (facets + 2), mu = 1/2. */
#pragma once

#include "problems/families/known_lcp.h"

#include <stdint.h>

base_status few_bodies(known_lcp *k, int bodies, int contacts, int facets, uint64_t seed,
                       base_error *err);
