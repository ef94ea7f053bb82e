/* formulations/event/event_turns.h - friction of the circle from problems with facets.
 *
 * Contacts at rest carry a faceted cone (slip_problem.h). Where one starts to slide, friction must lie
 * on the circle itself and against the acceleration, as it will on the arc. So facets are turned,
 * each contact by its angle theta, until at every one
 *
 *   f_t = P(aim),  aim = f_t - a_t/C_tt,  P the projection onto |f_t| <= mu f_n   (natural map)
 *
 * with theta <- arg(aim) as the iteration, accelerated by Anderson's mixing of the angles of the last
 * few turns (Walker & Ni 2011, SIAM J. Numer. Anal. 49, algorithm AA): contacts of one body turn each other,
 * and the plain iteration then settles slowly, at a linear rate. */
#pragma once

#include "formulations/regularized/slip_problem.h"

enum { TURNS_DEPTH = 6 };

typedef struct facet_turns {
  int n;                 /* contacts */
  int turns, kept;       /* since turns_begin; pairs of differences in memory */
  double *at, *step;     /* n: angles and steps arg(aim) - theta of the last turn */
  double *d_at, *d_step; /* TURNS_DEPTH columns of n: their differences, a ring */
  double *mix, *rest;    /* columns again, n: scratch of the least squares */
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
