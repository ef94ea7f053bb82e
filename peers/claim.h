/* claim.h - what a direct method of another project claims.
 *
 * These codes test no residual; several say "solved" where they are not. By default the answer is
 * tested by the host before it is claimed, which costs a product with M: an answer that fails is
 * "stalled". With claim=library what the library says is what is claimed, and the judge counts its
 * false claims. */
#ifndef LCPBENCH_PEERS_CLAIM_H
#define LCPBENCH_PEERS_CLAIM_H

#include <lcpbench/lcp_plugin.h>

#define PEER_CLAIM_OPTION                                                                          \
  {                                                                                                \
    "claim", "1", "choice", 0, 0, 0, "checked|library",                                            \
        "whether the answer is tested before it is claimed, or the library believed"               \
  }

/* What solve returns, where the library `said` solved or not and option `which` is the one above. */
static inline int peer_claim(const lcp_plugin_call *call, int which, int said, const double *z) {
  if (call->option[which] > 0) {
    return said ? LCP_PLUGIN_SOLVED : LCP_PLUGIN_STALLED;
  }
  return call->stop(call->host, 0, z) ? LCP_PLUGIN_AS_STOPPED : LCP_PLUGIN_STALLED;
}

#endif
