/* harness/control/error_quantity.h - what `--error E` asks for, and what it looks at in a run.
 *
 * The quantities: whatever the scene's checks of state look at, as they look at it, and what it observes at the end; where
 * that is nothing, or nothing of the unit asked for, the places of all bodies at the end. E is absolute, with the
 * unit of the quantities it holds for ("1e-3m", "0.01rad"), or relative to the scale of each quantity's unit:
 *
 *   m      the longest way that a body's centre, or one of the quantities, is from where it began; at least the size
 *          of the smallest body, in a scene of points that rest how far these may come by their speed or gravity
 *   m/s    the largest speed of a body; at least that of the length above in the time of the run
 *   rad    1
 *   rad/s  the largest value of the quantities of this unit; at least 1 rad in the time of the run
 *   else   the largest value of the quantities of this unit, in the run */
#pragma once

#include "harness/control/error_extreme.h"
#include "harness/control/step_control.h"

enum { ERROR_QUANTITIES = 512, ERROR_UNIT = 16, ERROR_LIMIT = 500000 };

typedef struct error_asked {
  double E;              /* in `unit`, or [1] */
  char unit[ERROR_UNIT]; /* "": relative */
  long limit;            /* of steps solved by all runs, trials included */
  double seconds;        /* that all runs may take [s]; 0: as long as it takes */
  double until;          /* base_seconds() at their end then [s]; 0: none */
} error_asked;

/* Are less than `left` seconds left for the runs, or was this process asked to stop (harness/util/stop.h)? */
bool error_late(const error_asked *a, double left);

typedef struct error_quantity {
  char name[112];
  const spec_check
      *check; /* that asks for it; NULL: it is observed at the end, or stands for all places */
  const char *unit;
  double value, scale, estimate; /* [unit]; estimate HUGE_VAL: there is only one run */
  double change;                 /* from the run before; HUGE_VAL: there is none [unit] */
  /* Of a speed at a time: what the last impact before that changed it by [unit], 0 where fewer than two did by more than E; and how far off
   * a body may be without being at another bounce than it seems to be [m]. */
  double leap, known;
  extreme extreme; /* where it is one over a time */
} error_quantity;

/* A run and what was read from it. */
typedef struct error_made {
  series record;
  sim_result out;
  step_list kept;
  run_places places;
  unsigned char *met; /* for each row: what the step that ends there met; owned */
  bool
      at_stops; /* all quantities are of states that steps end at, or of places, angles and speeds */
  bool between; /* some are of what these do between states */
  bool turns;   /* some are angles or rates of turning */
  bool more;    /* than ERROR_QUANTITIES are asked for */
  int n_quantity;
  error_quantity *quantity; /* owned; NULL: nothing was read from it yet */
} error_made;

/* "1e-3m", "2 %", "1%", "0.01". BASE_EINVAL: no number above 0, or no unit that the program knows. */
base_status error_parse(const char *text, error_asked *out, base_error *err);

/* What E counts in for a quantity. */
double error_unit(const error_asked *a, const error_quantity *e);
/* Reads the quantities that E holds for from the run that was made. BASE_ENOMEM. */
base_status error_made_read(const sim_request *q, const error_asked *asked, error_made *m,
                            base_error *err);
/* By how much the run misses the predictions of the scene that its energy or angular momentum is kept, over what they allow [1]; 0: it does
 * not. `name` is the one that is missed by most. */
double error_made_misses(const sim_request *q, const error_made *m, char *name, size_t cap);
/* Of quantity i between two runs, in its unit. */
double error_made_difference(const error_made *a, const error_made *b, int i);
void error_made_close(error_made *m);

/* Times that checks look at, ascending, the last is the end [s]: a value between two rows would be a chord's. A check that looks
 * at all states of a time is given `parts` of it, and the time at which its extreme was in the run `before`. Peaks of
 * loads that swing, each alone, are among them. *stop is grown; free it. */
base_status error_stops(const sim_request *q, int parts, const error_made *before, double **stop,
                        int *n_stop, base_error *err);
/* Those of them that states of speed are looked at, ascending [s]. Free *at. BASE_ENOMEM. */
base_status error_speed_times(const sim_request *q, double **at, int *n, base_error *err);
