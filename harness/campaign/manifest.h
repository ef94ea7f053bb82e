/* harness/campaign/manifest.h - manifest.json: everything needed to repeat a run and to judge it. */
#pragma once

#include "harness/plan/cover.h"

/* Writes DIR/manifest.json: the campaign's text and effective settings, what a filter chose and what is left ("cut",
 * harness/campaign/account.h; done[n_unit]), build, machine, libraries, hashes of the inputs. order: NULL where the
 * plan's own order is measured. */
base_status manifest_write(const char *dir, const plan *p, const plan_filter *f, const cover *order,
                           const bool *done, base_error *err);
