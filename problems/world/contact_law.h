/* problems/world/contact_law.h - is the friction of a step Coulomb's? Facets and boxes leave its direction to their corners, and bristles need
 * more than an impact to hold: neither is less with shorter steps. What one step makes of it is told, in velocities. */
#pragma once

#include "problems/world/contact_set.h"

typedef struct contact_law {
  bool
      bent; /* sliding friction gave something beyond mu_k l_n against the slip, in space, or what holds more than mu_s l_n */
  /* largest slip that an impact leaves to a contact that holds: all of it where it bounces off, else what its
   * friction could have taken [m/s] */
  double left;
} contact_law;

/* Of contacts with these impulses, modes (1: holds, 2: slides), and row velocities at the end of the step and without contacts, all n_row but
 * the modes (n_contact). Adds to the n_dof velocities v what sliding friction gave beyond, and
 * what the contacts between two bodies of which none slides hold together beyond. Friction that pushes a slip on is one of before
 * the slip turned round in the step, and slip that loads give within it is one of the step: errors of steps count for nothing here. */
contact_law contact_law_at(const contact_set *c, const double *impulse, const unsigned char *mode,
                           const double *u, const double *u_free, double *v);
