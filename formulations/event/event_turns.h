/* formulations/event/event_turns.h - friction of the circle from problems with facets.
 *
 * Contacts at rest carry a faceted cone (slip_problem.h). Where one starts to slide, friction must lie
 * on the circle itself and against the acceleration, as it will on the arc. So facets are turned,
 * each contact by its angle theta, until at every one
 *
 *   f_t = P(aim),  aim = f_t - a_t/C_tt,  P the projection onto |f_t| <= mu f_n   (natural map)
 *
 * with theta <- arg(aim) as the iteration, accelerated (anderson.h): contacts of one body turn each other,
 * and the plain iteration then settles slowly, at a linear rate. */
#pragma once

#include "formulations/anderson.h"
#include "formulations/regularized/slip_problem.h"

typedef struct facet_turns {
  anderson
      mixing;   /* of the angles, one a contact; its `taken` counts the turns since turns_begin */
  double *step; /* cap: arg(aim) - theta of this turn */
  int cap;
  void *mem; /* owned */
} facet_turns;

/* Forgets all earlier turns; room for n_contact contacts. */
base_status turns_begin(facet_turns *t, int n_contact, base_error *err);
void turns_close(facet_turns *t);

/* Distance of the forces lambda (n_row) from the circle's law, largest over the contacts at rest, over
 * the largest friction mu f_n [1]. */
double turns_residual(const slip_problem *p, const form_assembly *a, const double *u0,
                      const double *lambda);
/* Turns the facets in p, whose problem lambda solves, by one step of the iteration. BASE_EEXTERNAL if
 * the mixing cannot be solved. */
base_status turns_next(facet_turns *t, slip_problem *p, const form_assembly *a, const double *u0,
                       const double *lambda, base_error *err);
