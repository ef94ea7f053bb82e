/* cone_body.h - the factored form of cone_step.h: a Newton step in the body velocities. */
#pragma once

#include "lcp/solvers/cone_step.h"

/* Every cone inside one group, S inside the groups. */
base_status lcp_cone_body_check(const lcp_cone_step *s, const lcp_problem *p,
                                const lcp_cone_scaled *c, base_error *err);

/* Factors the system over the active rows (s->active), s->body. False: singular, or *status says why not. */
bool lcp_cone_body_factor(lcp_cone_step *s, const lcp_factored *f, lcp_cone_scaled *c,
                          double weight, base_status *status);
