/* harness/plan/plan_check.h - one value of one axis of a campaign, before anything runs. */
#pragma once

#include "harness/plan/campaign.h"

/* What the problems of a part are: scenes with formulations, complementarity problems, or sequences of these. */
typedef enum part_kind { PART_SCENES, PART_PROBLEMS, PART_SEQUENCES } part_kind;

/* problem: one of the part's, after expansion. */
part_kind plan_kind(bool has_formulations, const char *problem);

/* May a part of this kind give this axis? */
base_status plan_check_axis(int axis, part_kind kind, base_error *err);

/* text: after expansion. BASE_EINVAL naming the axis, the value
 * and the rule. Values of axes whose components say so themselves pass. */
base_status plan_check_value(int axis, part_kind kind, const char *text, base_error *err);
