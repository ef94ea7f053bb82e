/* problems/world/contact_set.h - the contacts of one instant, before any friction model.
 *
 * Generalised velocities v (n_dof) of the free dofs obey, over one step of length h,
 *   v+ = v_free + W J' lambda,     lambda: impulses [N s], row by row of the groups below
 *   u  = J v+ + u_drift            relative velocity in the contact frames [m/s]
 * with W = M^-1 block-diagonal. Rows of a contact, in this order:
 *   normal | n_tangent friction rows | n_torsion row | n_rolling rows
 * where the last three counts are those of declared effects with a coefficient > 0 at this contact.
 * Contacts come sorted by id; groups n_contact .. n_group-1 are joints (bilateral rows).
 * The set holds every contact whose gap is below the margin; each formulation decides which of
 * them it makes active.
 */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>
#include <stdint.h>

/* The low bits of an id tell copies of one contact apart (spec: contact_multiplicity), those above them the features, corners and
 * edges, of two shapes that meet; what is left tells pairs of shapes apart. */
enum { CONTACT_COPY_BITS = 8, CONTACT_FEATURE_BITS = 12 };
static inline uint64_t contact_shapes_of(uint64_t id) {
  return id >> (CONTACT_COPY_BITS + CONTACT_FEATURE_BITS);
}

/* Row counts of one contact. */
typedef struct contact_rows {
  unsigned char tangent, torsion, rolling; /* 0..2, 0..1, 0..2 */
} contact_rows;

typedef struct contact_set {
  int dim;      /* 2 or 3 */
  double h, t;  /* step length and time at its start [s] */
  double tol;   /* gap at or below which a contact counts as closed [m] */
  double noise; /* rounding of a gap as far out as the contacts are: below it there is none [m] */

  /* Bodies with free dofs (fixed and kinematic ones have none and do not appear). */
  int n_body, n_dof;
  const int *dof_start;   /* n_body+1 */
  const int *mass_start;  /* n_body+1, offsets into mass and inv_mass */
  const double *mass;     /* dense column-major blocks, SPD, world frame */
  const double *inv_mass; /* the inverses */
  const double *v;        /* n_dof, at the start of the step */
  const double *v_free;   /* n_dof, v + h W f: velocity at the end without contacts and joints */

  /* Row groups: contacts first, then joints. */
  int n_contact, n_group, n_row;
  const int *row_start; /* n_group+1 */
  const int *body;      /* 2*n_group; index into the bodies above, -1: no free dof on this side */
  const int *jac_start; /* n_group+1, offsets into jac */
  const double *jac; /* per group: rows x dofs of side 0 (row-major), then rows x dofs of side 1 */
  const double *u_drift;  /* n_row: velocity contributed by kinematic sides, belts, prescribed
                             dofs, at the end of the step */
  const double *u_before; /* n_row: J v plus drift at the start of the step */
  const double
      *u_curve; /* n_row: h (dJ/dt) v, what the turning of contact frames and joints adds to u over
                             the step; NULL unless it came from world_contacts_curved */

  /* Per contact (n_contact). */
  const uint64_t *id; /* feature pair; persistent over steps */
  const contact_rows *rows;
  const double *gap;                     /* signed distance [m], positive when open */
  const double *mu_static, *mu_kinetic;  /* [1]; 0 where no friction */
  const double *mu_torsion, *mu_rolling; /* [m]; NULL when undeclared */
  const double *restitution;             /* Newton's or Poisson's e; NULL when undeclared */
  const double *compliance; /* > 0, mean of the two surfaces' [m/N]; NULL: 1 everywhere */
  const double *frame;      /* 9 per contact: n, t1, t2 in world axes, from side 1 towards side 0;
                                planar: z components 0 */
  const double *spin;       /* 3 per contact: mean angular velocity of the two sides [rad/s];
                                NULL without rotation */

  /* Per joint row (rows row_start[n_contact] .. n_row-1). */
  const double *joint_error; /* constraint violation C(q) [m] or [rad]; NULL without joints */
} contact_set;

/* Dofs of body b of the set; none on a side without a body (-1). */
static inline int contact_dofs(const contact_set *c, int b) {
  return (b < 0) ? 0 : c->dof_start[b + 1] - c->dof_start[b];
}

/* Contacts, or groups, that one thread takes at a time (base/crew.h). */
enum { CONTACT_SHARE = 256 };

/* Shapes, index ranges, finiteness, gap ordering by id. For readers, tests and the harness. */
base_status contact_set_check(const contact_set *c, base_error *err);

/* Invariant for assert, which looks at no number with a unit: ids increase, so each is there once; the groups and their
 * Jacobians follow each other without a gap; a contact's rows are its normal and then what `rows` counts. */
bool contact_set_is_ordered(const contact_set *c);

/* How deep a gap that closes inside the step can get [m]: h times the fastest approach, with the free velocity, of the
 * contacts that are open and would close in the step. 0 without one. */
double contact_approach(const contact_set *c);

/* The normal speed of contact i with the free velocity [m/s], positive when it opens. */
double contact_free_speed(const contact_set *c, int i);

/* u = J v + u_drift (u_drift NULL: J v alone), n_row. */
void contact_relative_velocity(const contact_set *c, const double *v, const double *u_drift,
                               double *u);

/* The first contact behind those that follow `first` between the same two bodies. */
int contact_pair_end(const contact_set *c, int first);
/* What the friction of contacts [first, end) amounts to together, and could at rest, of n_row impulses [N s]. */
typedef struct contact_friction {
  double together, could;
} contact_friction;
contact_friction contact_friction_of(const contact_set *c, int first, int end,
                                     const double *impulse);
/* J W J^T of row k of contact i: the velocity that a unit impulse along it gives it [1/kg]. */
double contact_mobility(const contact_set *c, int i, int k);
/* Adds W J^T of an impulse along row k of contact i to the n_dof velocities v. */
void contact_push(const contact_set *c, int i, int k, double impulse, double *v);
/* The velocity along row k of contact i that a unit impulse along row m of contact j gives, and the other way round [1/kg]. */
double contact_coupling(const contact_set *c, int i, int k, int j, int m);
