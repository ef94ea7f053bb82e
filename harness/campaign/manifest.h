/* harness/campaign/manifest.h - manifest.json: everything needed to repeat a run and to judge it. */
#pragma once

#include "harness/plan/plan.h"

/* Writes DIR/manifest.json: the campaign's text and effective settings, build, machine, libraries,
 * hashes of the inputs. */
base_status manifest_write(const char *dir, const plan *p, const plan_filter *f, base_error *err);
