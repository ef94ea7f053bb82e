/* problems/world/world_residual.h - what acts on bodies in a step without some effects, for world_omitted.c, world_feet.c,
 * world_standing.c and world_steady.c. */
#pragma once

#include "problems/world/world_data.h"

/* What may act on one body in the step. */
typedef struct residual {
  double wrench[AXES]; /* impulse and its moment about the centre, of all that acts [N s, N m s] */
  double load[AXES];   /* of these what neither contacts nor joints bring */
  /* what the contacts are to bring in all, turned round: their force, and the moment of all others over the reach [N s] */
  double other[AXES];
  double rest[AXES];  /* what the contacts bring, on top of that */
  double rub, resist; /* friction left out [N s]; rolling and torsion left out [N m s] */
  double bounce;      /* velocity that restitution left out may return [m/s] */
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

/* Is it one sphere or disc about its centre? */
bool world_is_ball(const world *w, int i);

/* Adds to the wrenches and loads of all bodies what acts on them in the step. impulse: by rows of the set. */
void world_add_wrenches(const world *w, const double *impulse);

/* Can the contacts share their forces so that the force on every body stays and none has a moment on an axis that `effects`
 * would free? Asks for the wrenches of all bodies. No where it is not judged: more contacts than that pays for, joints, or
 * contacts with torsion or rolling that act. */
bool world_stands(const world *w, unsigned effects, const double *impulse);

/* The same of bodies that touch planes alone, on all axes that `effects` frees, locked or not, and with a tenth of the load to spare: every
 * foot that is closed carries, feet span a face, and friction that is left out is too small to shift what they carry. Balls, whose
 * contact forces have no moment, stand on one. Asks for the wrenches and `rub`. */
bool world_stands_firmly(const world *w, unsigned effects, const double *impulse);

/* Does a deviation of the bodies before the step keep its velocity in it? True where none turns, each touches planes alone and stands on
 * them firmly or flies, and no load or joint depends on places: what a step moves a body by is linear in its velocity then, and contact
 * takes of a difference in it. Asks for the wrenches and `rub`. */
bool world_steady(const world *w, unsigned effects, const double *v_next, const double *impulse);
