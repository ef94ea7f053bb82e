/* harness/control/deviation.h - how far a run may be off by the effects that it left out.
 *
 * A step tells by how much what it left out could have changed the velocity of a body, ds, and what it makes of deviations that there
 * were, p and q (world_omitted):
 *
 *   s <- (s + ds + p x) (1 + q)     velocity [m/s]
 *   x <- x + h s                    place [m]
 *
 * s is that of any point of a body until bodies push each other or turn. A step without friction is a projection in the norm of kinetic
 * energy, in which no deviation grows; that norm says of a point of one body what all have together. So s and x are multiplied once by
 * sqrt(sum m / least m) where bodies push each other, and once by what the velocity of a point may be over it where one turns (world_swing:
 * 2 for a box in the plane). */
#pragma once

#include "problems/world/world.h"

/* Of a scene. */
typedef struct deviation_scale {
  double size, speed; /* that deviations count against [m], [m/s] */
  double fall;        /* rate at which a body of that size falls over [1/s] */
  double masses;      /* sqrt(sum / least) [1] */
  double swing;       /* world_swing [1] */
} deviation_scale;

typedef struct deviation {
  double speed, place;      /* [m/s], [m] */
  double sum[EFFECT_COUNT]; /* of the changes of velocity by each effect [m/s] */
  double rate;              /* at which the last two steps both changed it at least [m/s^2] */
  double change;            /* by the last one, over its length [m/s^2] */
  bool shared, turned;      /* bodies have pushed each other since it began, or turned */
} deviation;

/* By sums of masses of what is not prescribed [kg]. */
deviation_scale deviation_scale_of(const scene_spec *spec, const world *w, double duration);

/* Enters a step of h [s] that could have changed velocities by `omitted`, of which less than `least` is none [m/s]. False: nothing is off. */
bool deviation_add(deviation *d, const deviation_scale *scale, const double omitted[EFFECT_COUNT],
                   double least, const world_growth *g, double h);

/* Rate at which it is to be expected to grow where steps of h go on like that one [1/s]: no body falls faster than the smallest. */
double deviation_growth(const deviation_scale *scale, const world_growth *g, double h);

/* The larger of speed and place over the scales, `time` [s] later, if what was left out goes on to act at `rate` [m/s^2], and s' = r^2 x + rate,
 * x' = s, with r the rate of growth [1/s]. */
double deviation_after(const deviation *d, const deviation_scale *scale, double growth, double rate,
                       double time);

/* Effects whose part is more than `share` of the largest (EFFECT_ bits). */
unsigned deviation_by(const deviation *d, double share);
