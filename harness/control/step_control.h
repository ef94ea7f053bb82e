/* harness/control/step_control.h - a run whose steps are chosen so that each adds no more than its share to the error.
 *
 * One step of h is compared with two of h/2 from the same state; the two are kept. Their distance e [m] is that of the places of all
 * points of all bodies, and of their velocities times how long these last: what is left of the run, or the time in which the fastest
 * body has come as far as the bodies get. A step is taken where
 *
 *   e <= tolerance max(h / T, s),    s = 1/32 where the carrying contacts change inside the step, else 1/16384
 *
 * because an impact inside a step costs h |dv| however short the step: it is located by halving until its share covers that, and how
 * deep bodies come into each other in the step. Otherwise, or where a solve of the step fails, h is shortened; PI control (Gustafsson
 * 1991) chooses the next. A step of the shortest length is taken as it is and counted; where a solve of it fails the run ends.
 * Formulations that integrate by themselves (FORM_NO_LCP) meet tolerances of their own: they take even steps of `first`.
 *
 * With `extrapolate` a step ends at 2 fine - coarse (extrapolation.h), and e is what a constant acceleration does not explain
 * (world_saved_bend), and the distance of the velocities over h; or, behind another smooth step, what the two of them do not explain
 * (world_saved_unsteady), which is of third order also where contacts or joints hold. Steps in which the contacts change are as above,
 * unless this e is within its share of them, too; but what came and went inside one of the halves, which e above does not see, counts.
 * Behind them the length is what it was before; where that did not come off, again behind the 2nd, 4th, 8th, 16th of them. A step in
 * which an open gap closes is tried again up to just behind that, where its velocities tell when (behind an impact at its start those
 * that this leaves); it ends no deeper than a step with a change may sink, and the coarse way alone is enough to tell. A step in whose
 * second half a slip stops is tried again up to there (for solvers by sweeps up to just before), which the first half tells, and one in
 * which contacts would break away up to where the friction they take is all they have, if it grows on as between the halves. What counts
 * as a change besides: friction that pushes a slip on which has turned round inside the step, on both of its ways alike, or slows it all
 * the while as it does behind the turn, and static friction that still holds the slip which begins in a step, where kinetic friction is
 * less. A step that one of its ways begins to carry in and the other does not is never extrapolated: they differ by an impact; nor is
 * one in which the fine way begins to carry and carries at its end what it did before. A length that met something where a shorter one
 * did not is tried again after 2, 4, 8, 16 steps.
 *
 * An extrapolated state obeys the contacts as they are there, the end of a step those at its start. Where something turns, the first
 * step from it has other normal forces than the next one, by what holds bodies on curved ways, and friction may hold in it that slips in
 * the next one, in every step however short. Where it does, the step is tried again with contacts that turn within it
 * (world_contacts_turned), and so are those behind it until others carry.
 *
 * A step may meet what neither of its ends tells of: step_sight.c.
 *
 * Impacts on one body that follow each other more closely than gaps are known (by what all steps so far are off by, and a step may sink)
 * are taken as they come, one by one or in one solve, and what goes with that is told (`doubt`): the part of the speed of one that is
 * taken by the other, or its friction where that turns with the slip that the other leaves. Resting contacts, impacts that come at once
 * as far as the solves can tell, and what bounces no higher than the gaps are known count for nothing.
 *
 * An impact is located the more closely the farther bodies go behind it: where round sides meet elsewhere, they push in another
 * direction. It is located by where bodies are, and by as much its time is unknown: where speeds are asked for so shortly before or
 * behind one, what they change by in it is told (`jump`).
 *
 * Where loads change with time a contact may open that nothing pulls at yet. Its normal force is followed from one half to the other,
 * and a step is tried again up to where nothing is left of it; where none opens behind such a step that is asked after 2, 4, 8, 16
 * steps. Friction may hold on both sides of the peak of a load: error_stops has the peaks, and the speed that kinetic friction may have
 * cost since the middle of the step before, where a slip begins at once, is told with impacts (`located`, `jump`), for no shorter step
 * behind it mends that.
 *
 * Bristles have a velocity by what stretches them. A step in which they hold by one of its ways and slip by the other, so that the
 * velocities of both differ by a quarter of what they change by, is not extrapolated: that turned the slip round, in every step however
 * short.
 *
 * What sliding friction gives in space beyond mu_k l_n against the slip, by the edges of a cone, is summed as a velocity of each body,
 * and `law` is how far it goes; `left` is what slip does that an impact left to a contact that holds.
 *
 * Where nothing moves at the start, and no load or drive changes with time, one step over all of the run is tried first: if nothing
 * moves in it, that is the run.
 *
 * The error of the whole run is not the sum of these, for errors grow and decay: error_run.h compares runs. */
#pragma once

#include "harness/control/run_places.h"
#include "harness/control/step_list.h"

typedef struct step_rule {
  double tolerance; /* [m] over the whole run */
  double
      of_travel; /* or this share of the longest way of a centre so far, where that is more [1] */
  double first;  /* step to begin with [s] */
  double least, most; /* [s] */
  bool rests;         /* nothing moves at the start: one step is tried in which nothing will */
  bool extrapolate;   /* smooth steps end where both of their ways together say (extrapolation.h) */
  const double *
      stop; /* n_stop times that a step must end at, ascending [s]; the last is the end of the run */
  int n_stop;
  const double *speed_at; /* n_speed_at of them, that speeds are asked at, ascending [s] */
  int n_speed_at;
  long
      limit; /* of steps solved, trials included; a run that is far from its end at a fiftieth of it ends there */
} step_rule;

typedef struct step_account {
  long solved, rejected,
      forced;         /* forced: taken at the shortest length though not within its share */
  double least, most; /* of the steps kept [s] */
  double tolerance;   /* that the last step was taken with [m] */
  long changed; /* steps kept in which other contacts carry than before, the first one aside */
  long came; /* even steps in which more or fewer contacts carry than before, the first one aside */
  double off;       /* sum of what the steps kept are off by [m] */
  double plain;     /* and would be if none of them were extrapolated [m] */
  double located;   /* largest error of a step in which the contacts changed [m] */
  double law;       /* what friction that is not of a round cone moves bodies by [m] */
  double law_speed; /* and the most that it makes them faster by [m/s] */
  double
      left; /* the most that slip does which an impact left to a contact that holds: the next one takes it [m] */
  double doubt; /* the most that goes with the order of impacts too near each other to tell [m] */
  double
      gain; /* the most that a point gets faster in a step kept in which no contact changes [m/s] */
  /* The most that a speed changes by in an impact that no solve saw, or so near a time of `speed_at` that it may as well be on its other side. */
  double jump; /* [m/s] */
  double
      bow; /* farthest that a constant acceleration goes from the chord of a step kept, |dv| h / 8 [m] */
  bool ended; /* the run came to its end within the limit */
} step_account;

/* No step is longer than this beside a steady turning: in a quarter of the time in which what is off that grows by e [s]; HUGE_VAL: nothing
 * grows. */
double step_beside_growth(const world *w);

/* As simulate(), with the steps that were kept; q->h is the first. The request must not ask for files. */
base_status simulate_controlled(const sim_request *q, const step_rule *rule, series *record,
                                sim_result *out, step_list *kept, run_places *places,
                                step_account *account, base_error *err);
