/* harness/plan/plan_check.h - one value of one axis of a campaign, before anything runs. */
#pragma once

#include "harness/plan/campaign.h"

/* May a part give this axis? Parts without formulations have no scenes. */
base_status plan_check_axis(int axis, bool is_scene, base_error *err);

/* text: after expansion; is_scene: its part has formulations. BASE_EINVAL naming the axis, the value
 * and the rule. Values of axes whose components say so themselves pass. */
base_status plan_check_value(int axis, bool is_scene, const char *text, base_error *err);
