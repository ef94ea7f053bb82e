/* batch_waves.h - several sweeps over contacts in batches at a time, one behind the other.
 *
 * A sweep enters a stretch of batches as soon as the sweep before it has left the last stretch that touches a body of this one. Then
 * every body meets its contacts sweep after sweep, in their order, and the iterates are those of one thread to the last bit. The
 * order of contacts is near that in which they are given (contact_batches.h): a sweep follows at some layers of bodies, and so many
 * go at once as those fit into the whole. */
#pragma once

#include "lcp/solvers/contact_batches.h"

/* Sweeps batches first .. first+count-1. */
typedef void (*lcp_wave)(void *context, int first, int count);

/* So many sweeps over all batches, by the crew of this thread; by itself where it was alone when they were ordered. */
void lcp_batch_waves(const lcp_batches *s, long sweeps, lcp_wave sweep, void *context);

/* Batches first .. first+count-1 in stretches, in any order: what depends on these batches alone. */
void lcp_batch_shares(const lcp_batches *s, lcp_wave work, void *context);
