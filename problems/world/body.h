/* problems/world/body.h - state and inertia of one body, and its motion over a step.
 *
 * A body has six axes (x y z, then rotations about them, world frame; planar bodies use 0, 1, 5).
 * Free axes become dofs of the contact set; driven axes follow v0 + a t; the others are locked. */
#pragma once

#include "problems/geometry/shapes.h"

typedef struct body {
  pose at;
  double quat[4];
  double angle; /* planar, not wrapped [rad] */
  double v[6];  /* velocity of the centre of mass, angular velocity; all axes */
  double mass;
  double inertia[3]; /* principal moments; planar: the last one about z [kg m^2] */
  double bound;      /* radius about the centre of mass that contains every piece; of a point that
                        turns its radius of gyration [m] */
  int first_piece, n_piece;
  int index; /* among the bodies with dofs, -1 */
  int dof;   /* first dof */
  unsigned char n_dof, axis[6];
  bool driven; /* some axis follows driven_v0 + driven_a t */
  bool spins;  /* the orientation can change: some rotational axis is free or driven */
  bool round;  /* a ball about the centre of mass: no normal force turns it */
  double driven_v0[6], driven_a[6];
  int sleeps; /* number of the group that it sleeps with (world_sleep.c): it has no dofs then; 0: it is awake */
  int still;   /* steps in a row at whose end it lay still, */
  int rising;  /* and at which it was faster than at the end of the one before, */
  double last; /* which was the speed of its fastest point at the last [m/s] */
} body;

/* Axes (SPEC_ bits) that bodies of a scene have with these effects. */
unsigned body_axes(int dim, unsigned effects);

/* Initial state of s. Axes of undeclared effects are locked: without rotation no body turns,
 * without motion nothing is driven, and a three-dimensional scene without the spatial effect moves
 * in the x-z plane only. */
void body_start(body *b, const spec_body *s, int dim, unsigned effects);

/* Does a driven axis move, now or later? */
bool body_is_moved(const body *b);

/* Velocity of the driven axes at time t, zero on the others. */
void body_driven(const body *b, double t, double v[6]);

/* Sets b->v from the dofs v (the whole vector) and the driven axes at time t. */
void body_set_velocity(body *b, const double *v, double t);

/* World-frame inertia about the centre of mass, symmetric. */
void body_inertia(const body *b, int dim, double I[9]);

/* Inertia block of the free axes and its inverse, n_dof x n_dof. */
base_status body_mass_block(const body *b, int dim, double *mass, double *inverse, base_error *err);

/* Free velocity: v[axis] of the free axes after h under the wrench f (force, torque about the
 * centre of mass, world frame; gyroscopic torque not included).
 *
 * With `gyroscopic` and three free rotations the angular velocity in body axes obeys the implicit
 * midpoint rule  I (O+ - O) = h (tau - Om x I Om), Om = (O + O+)/2,  which keeps the energy and the
 * modulus of the angular momentum of a free body exactly (both are quadratic invariants; Cooper
 * 1987) for every h. With fewer free rotations the torque is taken at the start of the step. */
base_status body_free_velocity(const body *b, int dim, bool gyroscopic, double h,
                               const double *inverse, const double f[6], double *v_free,
                               base_error *err);

/* Moves the pose by h with the velocity b->v. */
void body_move(body *b, int dim, double h);
/* Moves by h times `shift` (of all dofs); the velocity stays. */
void body_shift(body *b, int dim, double h, const double *shift);

double body_kinetic(const body *b, int dim);

/* Rotation matrix from quat or angle. */
void body_orient(body *b, int dim);
