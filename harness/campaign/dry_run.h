/* harness/campaign/dry_run.h - the plan of a campaign on stdout: every cell with its command, what is done, and
 * how long the rest takes. */
#pragma once

#include "harness/campaign/runner.h"

base_status dry_run(const plan *p, const runner_options *o, base_error *err);
