/* problems/world/world_residual.h - what acts on bodies in a step without some effects, for world_omitted.c, world_feet.c,
 * world_standing.c and world_steady.c. */
#pragma once

#include "problems/world/world_data.h"

#include <math.h>

/* What may act on one body in the step. */
typedef struct residual {
  double wrench[AXES]; /* impulse and its moment about the centre, of all that acts [N s, N m s] */
  double load[AXES];   /* of these what neither contacts nor joints bring */
  /* what the contacts are to bring in all, turned round: their force, and the moment of all others over the reach [N s] */
  double other[AXES];
  double rest[AXES];  /* what the contacts bring, on top of that */
  double rub, resist; /* friction left out [N s]; rolling and torsion left out [N m s] */
  double
      yaw; /* of that friction about the normals, which feet do not hold; HUGE_VAL: not known [N m s] */
  double bounce; /* velocity that restitution left out may return [m/s] */
  double turn;   /* [rad/s]; 0: it does not, or is a ball */
  double press;  /* of its contacts, as far as it, or its moment, goes with places [N s] */
  double bends;  /* of these, as far as the force does [N s] */
  double slides; /* contacts of it do: 0 none, 1 on one plane, 2 on several */
  double rubs[3], plane[3]; /* of one of them: its friction on the body over its load [1]; normal */
  double unlike; /* by how much the friction of others differs from that over their load [1] */
  double taken;  /* what friction changes by the load that bodies may take off it [N s] */
} residual;
_Static_assert(sizeof(residual) == WORLD_RESIDUAL * sizeof(double), "as the array is laid out");

static inline residual *world_residual(const world *w, int i) {
  return (residual *)(void *)(w->residual + (ptrdiff_t)WORLD_RESIDUAL * i);
}

/* The impulse of contact i in world axes, f, and the moment of its torsion and rolling rows, m. impulse: by rows of the set. */
void world_contact_impulse(const world *w, int i, const double *impulse, double *f, double *m);

/* Axes along which body i moves with `effects`. */
unsigned world_free_axes(const world *w, int i, unsigned effects);

/* Those that `effects` would free and the world has locked. */
unsigned world_locked_now(const world *w, int i, unsigned effects);

/* The least of the moments of inertia that count [kg m^2]. */
static inline double world_least_inertia(const world *w, int i) {
  const double *I = w->body[i].inertia;
  return (w->dim == 2) ? I[2] : fmin(I[0], fmin(I[1], I[2]));
}

/* Is it one sphere or disc about its centre? */
bool world_is_ball(const world *w, int i);

/* Adds to the wrenches and loads of all bodies what acts on them in the step. impulse: by rows of the set. */
void world_add_wrenches(const world *w, const double *impulse);

/* Can the contacts share their forces so that the force on every body stays and none has a moment on an axis that `effects`
 * would free? Asks for the wrenches of all bodies. No where it is not judged: more contacts than that pays for, joints, or
 * contacts with torsion or rolling that act. */
bool world_stands(const world *w, unsigned effects, const double *impulse);

/* The same on all axes that `effects` frees, locked or not, and with a tenth of the load to spare: every foot that a body stands on (on a
 * plane, or on a body that pushes against its load) carries, these feet span a face, and friction that is left out is too small to
 * shift what they carry. Balls, whose contact forces have no moment, stand on one. Notes the bodies that do not (`turned`), besides those
 * noted before: none where some impulses hold all of them, else by those that there are. tied: all. Asks for the wrenches and `rub`. */
void world_note_firm(const world *w, unsigned effects, bool tied, const double *impulse,
                     world_growth *grown);

/* What the step makes of a deviation of the bodies before it. Nothing where none turns, each stands firmly or flies, the normals between
 * them are of faces, and no load or joint depends on places: what a step moves a body by is linear in its velocity then, and contact
 * takes of a difference in it. Else by what contacts do to the bodies that turn, or may, or whose normals turn: an impulse p moves
 * a body of mass m by p / (m size) times the place. Asks for the wrenches and `rub`. */
void world_grown(const world *w, unsigned effects, const double *v_next, const double *impulse,
                 world_growth *grown);
