/* formulations/event/event_space.h - contact space of one instant for `event`: u = r + C lambda over the
 * contacts that take part, joints eliminated (assembly_joint.c), with u a velocity at an impact and
 * an acceleration between events.
 *
 *   impact   r = u-                               lambda an impulse [N s]
 *   forces   r = J W f + (dJ/dt) v + d'           lambda a force [N],    d' the drift's own rate
 *
 * The same space without contacts brings a state back onto the joints, along W J_b' (orthogonal in
 * the metric of the masses): q -= W J_b' S^+ C(q) until rounding is left, then v -= W J_b' S^+ (J_b v + d). */
#pragma once

#include "formulations/assembly.h"

typedef struct event_space {
  form_assembly a;
  double
      *gap; /* n_contact of the set: the caller writes 0 where a contact takes part, 1 where not */

  contact_set view;      /* the set with velocities, drift and gaps replaced */
  contact_memory memory; /* asked for by the assembly; forgotten at once */
  double *drift, *zero;  /* n_row of the set, n_dof */
  int cap_row, cap_contact, cap_dof;
  void *mem; /* owned */
} event_space;

/* Room for the contacts, rows and dofs of c. BASE_ENOMEM. */
base_status space_reserve(event_space *s, const contact_set *c, base_error *err);
void space_close(event_space *s);

/* Poses c, whose velocities are those before an impact [m/s]. The set is borrowed until the next call. */
base_status space_impact(event_space *s, const contact_set *c, base_error *err);
/* Poses c, which has u_curve, at the accelerations acc (n_dof) without contacts and joints [m/s^2]. */
base_status space_forces(event_space *s, const contact_set *c, const double *acc, base_error *err);

/* Moves config and v (as world_get_state has them) at time t onto the joints of w, and leaves w there.
 * *left: the largest error of a joint afterwards [m] or [rad]. rate: scratch as long as config. */
base_status space_onto_joints(event_space *s, world *w, double t, double *config, double *v,
                              double *rate, double *left, base_error *err);

/* acc, the accelerations of c without joints [m/s^2], becomes what the joints leave of them, with Baumgarte's terms
 * 2 rate C' + rate^2 C [rate: 1/s]; s->a.impulse holds their forces [N]. c has u_curve; contacts take no part. */
base_status space_constrain(event_space *s, const contact_set *c, double rate, double *acc,
                            base_error *err);
