/* tests/support/contact_velocity.h - the velocity that impulses leave behind, straight from its definition. */
#pragma once

#include "problems/world/contact_set.h"

/* v_next = v_free + W J' impulse; scratch n_dof. */
void contact_velocity(const contact_set *c, const double *impulse, double *v_next, double *scratch);
