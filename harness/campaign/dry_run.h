/* harness/campaign/dry_run.h - the plan of a campaign on stdout: every cell with its command, what is done, and
 * how long the rest takes, by the rows of DIR and of the folder `like` (NULL: none). */
#pragma once

#include "harness/campaign/runner.h"

base_status dry_run(const plan *p, const runner_options *o, const char *like, base_error *err);
