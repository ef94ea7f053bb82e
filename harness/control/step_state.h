/* harness/control/step_state.h - what the parts of the step control share: the run, and the step just tried. Private to four files: step_control.c
 * drives the run; step_error.c says what a step is off by, step_sight.c what happens in it unseen, and step_length.c how long the next one is.
 * step_control.h has the rules. */
#pragma once

#include "harness/control/break_away.h"
#include "harness/control/extrapolation.h"
#include "harness/control/patience.h"
#include "harness/control/step_control.h"

typedef struct controlled {
  sim run;
  const step_rule *rule;
  series *record;
  step_list *kept;
  run_places *places;
  step_account *account;
  bool failed;           /* a step of the shortest length has no solution: the run ends there */
  sim_carrying carrying; /* of the last step kept */
  double fastest;        /* largest speed of a body so far [m/s] */
  double last;           /* error over its share, of the last step kept [1] */
  /* velocities that friction gave so far beyond a round cone's, n_dof; owned, NULL: none */
  double *law;

  /* the step just tried */
  step_pair pair, ahead; /* its ways, and those of the step behind it */
  bool smooth;           /* both of its ways together are better than the fine one */
  double off, plain;     /* what it is off by, and would be if it were not extrapolated [m] */
  double located;        /* what of that is by impacts, slips, contacts that change [m] */
  double passed;         /* that an impact which none of its solves saw would change [m/s] */
  double slipped;        /* what a slip that begins or turns in it is off by at its end [m/s] */
  double late_speed;     /* what slips at once in it is late by, see unseen_for [m/s] */
  double bend;           /* of its way, beyond what a constant acceleration explains [m] */

  /* of the last steps kept, for the next */
  double sure_until; /* friction that was foreseen to give way by now does so until then [s] */
  double unseen_for; /* so long the last step may have held what had given way [s] */
  double hit_until;  /* for so long the last impact may yet be to come [s] */
  double hit_jump;   /* and so much it changes velocities by [m/s] */
  double stride;     /* of the last step that met something, which is yet to come; 0: none [s] */
  bool strides;      /* the next step is tried with it */
  openings opening;
  patience longer, onward; /* with longer steps; behind an impact with one as long as before it */
} controlled;

/* What the length that is tried was aimed at. */
typedef enum aim { AIM_NOTHING, AIM_REST, AIM_BEFORE_SLIP, AIM_SLIP, AIM_OPENING } aim;

/* ---- step_error.c ---------------------------------------------------------------------------- */

/* What the whole run may be off by, as far as is known [m]. */
double step_tolerance(const controlled *c);

/* The share of it that a step of h may take in which contacts change [1]. */
double step_share(const controlled *c, double h);

/* How far bodies get, as far as is known: points less than they may, so that their size counts, too [m]. */
double step_way(const controlled *c);

/* How long a difference of velocities lasts: what is left of the run, or the time in which the fastest body has come as far as the bodies
 * get [s]. */
double step_reach(const controlled *c);

/* Do other contacts carry in the step just tried than before it? */
bool step_changes(const controlled *c);

/* Do contacts hold in one of the ways just tried that slip in another? */
bool step_modes_differ(const controlled *c);

/* Half of what a step may sink; no side of a body is missed by it [m]. */
double step_shallow(const controlled *c);

/* Error over the share that the step of h just tried may take [1]; notes what of it is of what. HUGE_VAL: a way failed. */
double step_error(controlled *c, double h);

/* ---- step_length.c --------------------------------------------------------------------------- */

/* The longest step beside what grows off a steady turning, which no step sees: a share of it is off by as much as the steps of the run are
 * of what they see [s]. */
double step_longest(const controlled *c);

/* The length of a step in the place of one of h in which a gap closes: to just behind that, so deep as step_shallow, and so that the gap is
 * open yet at half of it, where the fine way would meet it. h: none does. */
double step_to_impact(const controlled *c, double h);

/* Does the coarse way over h tell that the step is too long: what closes in it sinks by more than its share? */
bool step_is_foreseen(const controlled *c, double h);

/* When a contact opens in the step of h just tried because loads change; HUGE_VAL: none does. Where loads do not change it opens as bodies
 * move, and how these do keeps the steps short. In a step with an impact, what contacts press with tells nothing. */
double step_opens(const controlled *c, double h);

/* The length to try in the place of h: `at` where nothing but what happens there is against it (e 0), otherwise what its error e asks for.
 * *aimed: at what. */
double step_retried(const controlled *c, double h, double e, double at, aim *aimed);

/* The length of the step after one of h that was kept with error e over its share. */
double step_next(controlled *c, double h, double e);

/* A longer step that met something, where a shorter one did not, is tried again after 2, 4, 8... steps: until what it met is passed, or
 * for good where it is the length that meets it. */
bool step_may_grow(controlled *c, bool met);

/* ---- step_sight.c ---------------------------------------------------------------------------- */

/* Looks for what happens in the step of h just tried and neither of its ends tells of, where *e, its error over its share, is at most 1; may
 * raise *e. *at: when it does, h or more: nothing does. Errors: BASE_ENOMEM. */
base_status step_look(controlled *c, double h, aim aimed, double *e, double *at, base_error *err);
