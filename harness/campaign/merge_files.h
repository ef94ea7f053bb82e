/* harness/campaign/merge_files.h - what lies beside the rows of the shards goes into the merged folder too:
 * stored answers, convergence histories, canaries, and the noisiest doctor.json. */
#pragma once

#include "lcp/base/status.h"

/* Hard links where the file system can, copies elsewhere; a file that is there already stays. */
base_status merge_files(const char *const *dir, int n, const char *out, base_error *err);
