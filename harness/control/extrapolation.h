/* harness/control/extrapolation.h - one step of h and two of h/2 from the same state, and where both together say that the
 * motion goes: 2 fine - coarse in places, turns and velocities (Richardson 1911), of second order where the
 * motion is smooth, exact for a constant acceleration. Contact memory is that of the two. */
#pragma once

#include "harness/control/checkpoint.h"

/* One way over a step. */
typedef struct step_end {
  double *state;         /* where it ends: world_save */
  sim_carrying carrying; /* last */
  bool event;            /* others than before the step carried on the way */
  bool more;             /* and more of them: not only was one let go */
  double sunk;  /* how much deeper than at its start bodies are in each other at its end [m] */
  double start; /* how deep bodies are in each other at its start [m] */
  double held;  /* of that, where gaps were closed at the start of its last step */
  double even;  /* where they were open then, if velocities had changed evenly in it [m] */
  sim_closing
      closing;  /* in its first step; behind the impact where others carry in that than before */
  double stops; /* when a slip of its first step would be at rest [s] */
  double pushed, broke; /* the most of both in its steps (sim_slip) [m/s] */
  double broke_at_once; /* in its first step [m/s] */
  double doubt;         /* the most in its steps (sim) [m/s] */
  double *law;          /* what the friction of its steps gave beyond a round cone's (sim) */
  contact_law friction; /* of its steps: any, the most */
  bool mixed;           /* contacts that hold in one of its steps slip in another */
  bool good;            /* nothing failed */
} step_end;

typedef struct step_pair {
  checkpoint start;
  step_end coarse, fine;
  double *past;          /* start, coarse and fine state of the last step that was smooth */
  double past_h;         /* its length; 0: the step before the try was none [s] */
  sim_carrying carrying; /* of the step before the try */
  sim_loads load[2];     /* of the two steps of the fine way */
  long solved;           /* steps taken in all tries */
  sim_request quiet;     /* the run's without the files of its steps */
} step_pair;

/* BASE_ENOMEM. Whatever is returned, step_pair_close gives back what was opened. */
base_status step_pair_open(step_pair *p, const sim *s, base_error *err);
void step_pair_close(step_pair *p);

/* Both ways over h [s]; the run stands at the end of the fine one, `start` is where it stood. `carrying`: of the step
 * before. Dumps are of the fine way, rows of the trajectory of the contacts in its second half. */
base_status step_pair_try(step_pair *p, sim *s, series *record, sim_carrying carrying, double h,
                          base_error *err);
/* The same in two: the coarse way, at whose end the run stands, and the fine one. */
base_status step_pair_begin(step_pair *p, sim *s, series *record, sim_carrying carrying, double h,
                            base_error *err);
base_status step_pair_finish(step_pair *p, sim *s, series *record, double h, base_error *err);
/* Back to where the run stood before the last try. */
base_status step_pair_undo(const step_pair *p, sim *s, series *record, base_error *err);
/* What the step of h just tried is off by if extrapolated, as far as the smooth step before tells (world_saved_unsteady); HUGE_VAL if
 * there is none [m]. */
double step_pair_unsteady(const step_pair *p, const sim *s, double h);
/* The step of h just tried is kept: a smooth one tells of the next. */
void step_pair_keep(step_pair *p, const sim *s, double h, bool smooth);
/* From the end of the fine way to the extrapolated state: the two rows become one, the two steps count as one. */
base_status step_pair_extrapolate(const step_pair *p, sim *s, series *record, base_error *err);
