/* lcp/share/lcp_share_parts.h - the choice of lcp_share.h, island by island, shared out to the crew of the thread (base/crew.h).
 *
 * What is open in one island is nothing to another: each has its own scale of compliance and its own rounds, and ends by itself. Whether
 * the rank is counted is as for the whole. The islands are those that the solver had; each keeps its workspace from problem to problem by its number,
 * so that the bits do not depend on how many threads there are. */
#pragma once

#include "lcp/lcp_islands.h"
#include "lcp/share/lcp_share.h"

typedef struct lcp_share_parts lcp_share_parts; /* opaque: owns an lcp_share per island */

base_status lcp_share_parts_open(lcp_share_parts **out, base_error *err);
void lcp_share_parts_close(lcp_share_parts *s); /* accepts NULL */
void lcp_share_parts_rest(lcp_share_parts *s);  /* lcp_share_rest of each */

/* As lcp_share_apply of the problem that `islands` last solved, whose answer z is. Missed in one island is missed; counts are sums, the
 * deficit LCP_SHARE_UNCOUNTED where one island's is. */
base_status lcp_share_parts_apply(lcp_share_parts *s, const lcp_islands *islands,
                                  const double *start, double *z, lcp_share_result *out,
                                  base_error *err);
