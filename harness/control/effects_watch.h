/* harness/control/effects_watch.h - `--effects auto:E`: simulates only the effects that the run calls for.
 *
 * The run begins without friction, rolling, torsion, rotation and the third dimension, as far as the scene declares them and no
 * velocity, driven body or belt needs them; in the plane with rotation, which has no row there, while two feet of a body that cannot turn
 * are one too many; and with restitution, which adds no row to a step. Before contacts touch, leaving out saves nothing: a scene
 * without joints in which none does begins with everything, and leaves out once the same contacts carried in two steps. What is
 * sure to act in the step to come (world_foreseen) is in at once. Every step without an effect tells how much that effect could
 * have changed in it (world_omitted: an upper bound, 0 where the step is one of the whole scene too; Oden & Prudhomme 2002). From
 * these follows how far each body may be off (deviation.h), and how far it would be at the end if deviations went on to grow as in
 * the last step, by no more than what falls over does: a body of the smallest size, at sqrt(a / size), a by gravity and what
 * all loads give the lightest body. Changes count that are more than what a verified answer may be off by, and more than would add up to a tenth
 * of E over the run. They count against the largest speed so far (at least sqrt(g size), and size over the time of the run) and the size of the
 * smallest body. Where
 *
 *   - what was left out would have the end off by more than E, as it is or if it went on to act as in the last two steps; but where
 *     deviations grow, only once that has been said in n steps in a row and they are above E / (16 n^2): what turns or meets comes to
 *     rest, or
 *   - an impact is the first step in which anything acts, and would have the end off by a third of E: what comes in for it alone goes
 *     again behind it, or
 *   - contacts begin or cease to carry, or may, while something left out has acted, unless no friction is simulated and each contact rests,
 *     passes or closes, in this step and not before, whatever the deviation is (world_contacts_alike): what other impacts make of a
 *     deviation is unknown, or
 *   - a body falls asleep that is off by what was left out, for nothing tells of that from there on,
 *
 * an effect comes in. What acts for the first time comes in before the step just taken. Else the run goes back to the last step up to
 * which nothing left out had acted, and goes on from there with the effects that had most, or at a change of contacts with those that
 * had acted before it. So what is kept of the run is that of the whole scene up to rounding, or off by less than E. What is guessed
 * is only when to try, never that it holds; and nothing is watched once everything is in.
 *
 * What came in is left out again,
 *
 *   - at rest: all that could meet anything lies still, on the same contacts in two steps, and something of it has moved before; or
 *   - behind an impact that it came in for, while nothing else that is left out has acted: contacts stay, and what it did in the last
 *     step, going on to the end of the run while deviations grow as in that step, is less than E; less than a third of it where they do
 *     grow. This is asked for after 1, 2, 4, ... steps, and behind a change of contacts 16 steps after the last such, and done 8 times a
 *     run at most.
 *
 * Of some things none of these bounds tells, and they stay in: all, where friction is another once a contact has slid; the third dimension where the
 * facets of a cone do not lie in the plane, or turning in it turns a body out of it (products of inertia); rotation and the third dimension
 * beside friction by bristles, whose stiffness goes with what may turn; all of it where `position` finds bodies in each other at the start. A law of
 * friction that reaches beyond mu times the normal force counts with what it reaches. Contacts also count as beginning where bodies come so
 * near that what they are off may have them meet.
 *
 * Gravity, contact, joints, loads, damping, motion are the scene itself; gyroscopic goes with rotation. Formulations that
 * step by themselves, and generalised coordinates, have everything in. */
#pragma once

#include "harness/measure/effects_plan.h"
#include "harness/measure/simulate.h"

typedef struct watch_result {
  double level;       /* E [1] */
  unsigned watched;   /* EFFECT_ bits that the run may do without */
  effects_plan plan;  /* what was simulated when */
  double bound;       /* of what was left out to the end, over its scale [1] */
  double size, speed; /* the scales [m], [m/s] */
  long repeated;      /* steps that were taken again */
} watch_result;

/* "auto:E": true, and the level. BASE_EINVAL: auto without a number E above 0. */
base_status watch_parse(const char *text, bool *is, double *level, base_error *err);

/* Is the text one that --effects takes: auto:E, or a plan? */
base_status watch_check(const char *text, base_error *err);

/* As simulate() with q->effects, less what proves to be unneeded. The request must not ask for files: what was taken back
 * would be in them. q->plan is not read. At q->until it ends, wherever it is. */
base_status watch_run(const sim_request *q, double level, series *record, sim_result *out,
                      watch_result *result, base_error *err);

/* "-friction at 12 (0.12 s), rotation left out": one line of what was done. */
void watch_print(const watch_result *r, unsigned declared, char text[EFFECTS_TEXT]);
