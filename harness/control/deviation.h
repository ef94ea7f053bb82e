/* harness/control/deviation.h - how far a run may be off by the effects that it left out.
 *
 * A step tells of each body by how much what it left out could have changed its velocity and its turning, and what the step makes of
 * deviations that there were (world_omitted). Kept of each body are bounds of
 *
 *   v, x    velocity and place of its centre [m/s], [m]
 *   w, a    turning and angle, as those of a point at the radius that contains the body
 *   e, z    velocity and place in the norm of kinetic energy over its mass: e^2 <= v^2 + (k w)^2, k the radius of gyration over that radius
 *
 * and of all bodies together the norm of kinetic energy. A step without friction is a projection in that norm: it makes no deviation grow
 * but by what goes with places (e <- e + p z) or with turning in space. Where a contact may turn a body, v and w are those that e may be as
 * a whole; where bodies push each other, the energies of all of them may be in each. Else each goes on by itself. */
#pragma once

#include "problems/world/world.h"

/* Of a scene. */
typedef struct deviation_scale {
  double size, speed; /* that deviations count against [m], [m/s] */
  double fall;        /* rate at which a body of that size falls over [1/s] */
} deviation_scale;

/* Of bodies that push each other in a step, at the first of them. */
typedef struct deviation_group {
  double place;  /* sum of m z^2 [kg m^2] */
  double energy; /* twice that of all [kg m^2/s^2] */
  int n;
} deviation_group;

/* v and w change at `last` by what the last step left out, and at `rate` in both of the last two at least. If steps go on like the last one it
 * is to be expected to grow at the rate `grows`: no body falls faster than the smallest. */
typedef struct deviation_body {
  double v, w, e;          /* [m/s] */
  double x, a, z;          /* [m] */
  double rate[2], last[2]; /* [m/s^2] */
  double grows;            /* [1/s] */
  deviation_group group;
} deviation_body;

typedef struct deviation {
  int n;
  const world_inertia *inertia; /* [n] */
  deviation_body *body;         /* [n] */
  double energy, place;     /* of all: roots of the sums of m e^2 [kg^1/2 m/s], m z^2 [kg^1/2 m] */
  double sum[EFFECT_COUNT]; /* of the changes of velocity by each effect [m/s] */
  bool any;                 /* something is off */
} deviation;

deviation_scale deviation_scale_of(const scene_spec *spec, const world *w, double duration);

/* Of no body. BASE_ENOMEM. */
base_status deviation_open(deviation *d, int n, const world_inertia *inertia, base_error *err);
void deviation_close(deviation *d);
/* Nothing is off. */
void deviation_clear(deviation *d);
/* to <- from, of as many bodies. */
void deviation_copy(deviation *to, const deviation *from);

/* Enters a step of h [s] that could have changed velocities by `omitted` [m/s], and bodies as in `grown`. */
void deviation_add(deviation *d, const deviation_scale *scale, const double omitted[EFFECT_COUNT],
                   const world_growth *grown, double h);

/* Of one body, the largest of velocity, turning, place and angle over the scales: now, and later if v' = r^2 x + rate, x' = v, with r the
 * rate of growth, and the rate at which what was left out goes on to act: none, that of both of the last two steps, that of the last one. */
typedef struct deviation_forecast {
  double now, free, both, last;
} deviation_forecast;

/* `time` [s] later. */
deviation_forecast deviation_after(const deviation *d, int i, const deviation_scale *scale,
                                   double time);

/* The velocity and place of any point of each body. */
void deviation_points(const deviation *d, world_deviation *point);

/* Effects whose part is more than `share` of the largest (EFFECT_ bits). */
unsigned deviation_by(const deviation *d, double share);
