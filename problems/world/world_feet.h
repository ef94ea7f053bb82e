/* problems/world/world_feet.h - the contacts that may carry, as feet, and how they can share what they carry. Private to
 * world_feet.c and world_standing.c.
 *
 * Where bodies cannot turn, the contacts between the same two sides with the same normal (a patch) move alike, and only the sum
 * of their forces acts. The step is one with rotation too where the forces can be shared so that no moment about a centre
 * remains and the force on every body stays; friction goes with the normal forces. Sought are normal impulses p >= 0 with
 *
 *   min |A p + b|^2,   rows: force, and moment over the reach, of every body;   columns: n + friction over press of the patch
 *
 * by active sets on A'A (non-negative least squares, Lawson & Hanson 1974, chapter 23). Where A p + b is 0 then, nothing turns.
 * b stands in `other` of each body's residual, A p + b in `rest`. */
#pragma once

#include "problems/world/world_residual.h"

enum { FEET_MOST = 48 }; /* what costs more to judge is not left out */

#define WORLD_FEET_LITTLE                                                                          \
  1e-10 /* of the sum of all impulses: what is left of a force or moment is rounding */

/* A contact that may carry. */
typedef struct foot {
  int contact, patch, side[2]; /* side: a body that moves, or -1 */
  double column[2][AXES];      /* what 1 N s does to its sides: force [1], moment over reach [1] */
  double p, target;            /* [N s]; of the feet in use, were none to end at 0 */
  double least;                /* [N s], which it carries in any case */
  bool stands[2];              /* of each side: it stands on the foot (world_standing.c) */
  bool used;
} foot;

typedef struct patch {
  const double *normal;
  double force[3], press; /* [N s] */
} patch;

typedef struct feet {
  int n, n_patch, n_used;
  int used[FEET_MOST]; /* feet, in the order that they came into use */
  foot foot[FEET_MOST];
  patch patch[FEET_MOST];
  double factor[FEET_MOST * FEET_MOST]; /* lower triangle, of the Gram matrix of those in use */
} feet;

/* The axes that count. */
typedef unsigned world_axes_of(const world *w, int body, unsigned effects);

/* The feet, b, and the sum of the impulses [N s]; false: it is not judged (too many, joints, torsion or rolling that acts). Asks for
 * the wrenches and loads of all bodies. */
bool world_feet_set_up(const world *w, unsigned effects, const double *impulse, world_axes_of *axes,
                       feet *s, double *scale);

/* p times the column of f onto b (`other`) or onto the rest. */
void world_feet_add(const world *w, const foot *f, double p, bool other);

/* The rest is b and what the feet in use carry. */
void world_feet_set_rest(const world *w, const feet *s);

/* Can they carry it? Leaves the p that come nearest. */
bool world_feet_balanced(const world *w, feet *s, double scale);
