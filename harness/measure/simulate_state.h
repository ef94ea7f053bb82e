/* harness/measure/simulate_state.h - what the step loop and its solves share. Private to simulate*.c and harness/control. */
#pragma once

#include "harness/measure/contact_order.h"
#include "harness/measure/own_answers.h"
#include "harness/measure/simulate.h"
#include "lcp/lcp_islands.h"
#include "lcp/share/lcp_share_parts.h"
#include "problems/world/contact_law.h"

/* Of the contacts of bodies that sleep: what the formulation remembers, their forces, and the energy in their springs [J]. */
typedef struct sim_asleep {
  contact_past past;
  series_resting resting;
  double energy;
  long change; /* two that are of the same change are the same */
} sim_asleep;

/* BASE_ENOMEM. */
base_status sim_asleep_copy(sim_asleep *to, const sim_asleep *from, base_error *err);
void sim_asleep_close(sim_asleep *a);

/* What a solve came to. */
typedef struct solved {
  run_status word, claimed;
  bool verified;
  lcp_verdict v;
  char text[160];
} solved;

/* How deep bodies are in each other [m]: at the start of a step; at its end where gaps were closed, where they were open, and there if
 * the velocities had changed evenly. */
typedef struct sim_depth {
  double start, held, open, even;
} sim_depth;

/* When the first gap that is open closes if velocities change evenly in a step, from its start on [s], HUGE_VAL: not within it; how fast
 * [m/s]; and how deep the deepest of those that close is at its end [m]. */
typedef struct sim_closing {
  double at, speed, deep;
} sim_closing;

/* Friction of the contacts between two bodies in a step, which follow each other: what each of them takes, added up (a solver may let them push
 * against each other); what they take together, which is nothing of a pure moment; and what they could take at rest [N s]. */
typedef struct sim_load {
  double takes, together, could;
  int body[2];
} sim_load;

/* A contact that carries: its normal impulse in a step [N s]. */
typedef struct sim_press {
  uint64_t id;
  double impulse;
} sim_press;

/* Of all pairs of bodies that have contacts, and all contacts that carry. */
typedef struct sim_loads {
  sim_load *pair;   /* owned */
  sim_press *press; /* behind the pairs */
  int n, n_press, cap;
} sim_loads;

/* BASE_ENOMEM. */
base_status sim_loads_copy(sim_loads *to, const sim_loads *from, base_error *err);

/* When the first contact that slides in a step is at rest if it is slowed on as in it, from its start on [s], HUGE_VAL: none is, or in the
 * step already. The largest speed of a slip at its end that friction pushes on instead of holding it, or twice what one had that slides the
 * other way at its end; and the speed that static friction
 * costs in it where a slip begins and friction falls [m/s]. */
typedef struct sim_slip {
  double stops, pushed, broke;
} sim_slip;

/* Contacts with a normal impulse: how many, a hash of their ids, and one of which of them slip. */
typedef struct sim_carrying {
  int n;
  uint64_t ids, slips;
} sim_carrying;

/* Everything one run owns. */
typedef struct sim {
  const sim_request *q;
  sim_request changed; /* q, once formulation and solver are others than asked for first */
  sim_result *out;
  world *w;
  formulation_run *form;
  lcp_instance *instance;
  lcp_islands *islands; /* in its place, where asked for */
  contact_past past;    /* of the last formulation with a memory, at a change */
  const formulation *past_of;
  lcp_share *share;             /* opened with the first problem */
  lcp_share_parts *share_parts; /* in its place, with the first one that is solved in parts */
  bool sleeps;                  /* bodies may */
  bool slept;                   /* some fell asleep in the last step */
  sim_asleep asleep;
  long n_change;      /* that `asleep` has gone through */
  contact_past awake; /* of the other contacts, while bodies fall asleep or wake */
  contact_order order;
  unsigned effects;             /* simulated now */
  unsigned watched;             /* asked of world_omitted in every step; 0: nothing is */
  double least;                 /* what changes less changes nothing [m/s] */
  const world_deviation *off;   /* of each body before the step; NULL: none is */
  bool would_deviate;           /* `grown` is asked for as if some were */
  double omitted[EFFECT_COUNT]; /* the answer for the last step [m/s] */
  world_growth *grown;          /* and of each body, with what the step makes of deviations */
  bool alike;                   /* contacts act alike with them */
  double h;                     /* of this step [s] */
  int active;                   /* contacts that carried in the last step */
  sim_carrying carrying;        /* in the last step */
  sim_carrying goes_on;         /* the same less those that fell asleep at its end */
  double *z; /* z_cap of the answer, as many for the solver's own, and of zeros to start from */
  int z_cap;
  const double *started; /* where it did: a view */
  own_answers own;       /* where the next solves of a method that pivots start */
  double called;         /* spent in sim_solve_for_formulation: solved, judged, stored [s] */
  bool iterates; /* the formulation poses its problems one by one; else it steps by itself */
  solved
      held; /* a problem without a solution, until the step is over: another may follow; word RUN_OK: none */
  bool controlled; /* depth is asked for */
  bool presses;    /* and what each contact presses with */
  bool turned;     /* contacts are world_contacts_turned */
  bool part;       /* the step is part of another, which leaves the row of the trajectory behind */
  sim_depth depth; /* of the last step */
  sim_closing closing; /* as the velocities at its ends are */
  sim_closing struck;  /* as they are if what contacts gave came at its start: an impact */
  sim_slip slip;
  sim_loads loads;
  double
      near; /* a gap that is no farther from closed may as well be so [m]; 0: every gap is certain */
  double
      doubt; /* velocity that goes with the order of impacts on one body, of which one is so near another [m/s] */
  double *u; /* u_cap: row velocities at its end, and without contacts */
  double
      *law; /* n_dof velocities that sliding friction gave beyond Coulomb's in it: behind these */
  int u_cap;
  contact_law friction; /* of the last step */
  bool cut;             /* the time was up in the last step that the formulation took by itself */
} sim;

/* A run from its start to what it leaves behind: open, steps, finish, close. sim_close takes whatever sim_open left. */
base_status sim_open(sim *s, const sim_request *q, series *record, sim_result *out,
                     base_error *err);
/* One step of h [s] into the record; *taken = false: it could not be taken, and the status says why;
 * or the run's time was up in it, which is nothing against it, and the world is somewhere in the step. */
base_status sim_step(sim *s, series *record, double h, bool *taken, base_error *err);
/* Between two steps: the bodies go on from where they are with these effects. Who sleeps does so on. BASE_EUNSUPPORTED where the formulation has no
 * memory to hand over (formulation.memory). */
base_status sim_change_effects(sim *s, unsigned effects, base_error *err);
/* Between two steps: another formulation and solver, which outlive the run, go on with what the last one remembers of its contacts. A
 * formulation without memory begins as in a first step, and leaves nothing behind. */
base_status sim_change_combination(sim *s, const formulation_choice *form,
                                   const solver_choice *solver, base_error *err);
/* Either of them where the plans of the request ask for it before the next step. */
base_status sim_follow_plans(sim *s, base_error *err);
/* Does the formulation take the world as it is now? Otherwise the run's status says so. */
void sim_ask_admission(sim *s);
/* The formulation of the request begins anew, and is told of its solver. */
base_status sim_open_formulation(sim *s, base_error *err);
void sim_finish(sim *s, series *record);
void sim_close(sim *s);

/* Has the run come to a state after which nothing further is physics? */
bool sim_hopeless(const sim *s);

/* No answer of this step exists. */
void sim_refuse(sim *s, run_status word, const char *text);

/* Notes what the contacts of the step that ends with the answer tell of it: `carrying`, and of a controlled run depths, by what gaps change at
 * the velocity of its end, what closes in it, and what slips. BASE_ENOMEM. */
base_status sim_note_contacts(sim *s, const contact_set *set, const formulation_answer *a,
                              base_error *err);

/* Can bodies sleep in this run? Not where the formulation has no memory to wake with. */
bool sim_may_sleep(const sim *s);
/* Behind a step: those that lay still fall asleep. The set is no longer valid where some did. `a`: the answer of the step. BASE_ENOMEM. */
base_status sim_fall_asleep(sim *s, const contact_set *set, const formulation_answer *a,
                            base_error *err);
/* Those that a contact of the set just found reaches wake, with the memory of their contacts, but not what the solver answered by itself: the
 * set is to be found anew. Or all of them. BASE_ENOMEM. */
base_status sim_wake(sim *s, bool all, base_error *err);

/* Hash and number of the contacts that carry and do not sleep. */
sim_carrying sim_carrying_of(const sim *s, const contact_set *set, const formulation_answer *a);

/* Records the first trouble in words. */
void sim_trouble(sim *s, run_status word, const char *text);

/* Does the solver start from a basis, so that its own answers are worth keeping beside the chosen ones? */
bool sim_keeps_own(const sim *s);

/* z0 (NULL: zeros) as the start point s->z of p. */
base_status sim_start_point(sim *s, const lcp_problem *p, const double *z0, base_error *err);

/* One complementarity problem from the start point s->z to the judged answer s->z: by the solver, or
 * from stored answers. */
base_status sim_solve(sim *s, const lcp_problem *p, lcp_outcome *claimed, base_error *err);

/* The same behind formulation_solver, for formulations that step by themselves. */
base_status sim_solve_for_formulation(void *ctx, const lcp_problem *p, double *z,
                                      lcp_outcome *claimed, base_error *err);
/* Is it the time that the run ends at, or did a signal come (sim_request.until)? */
bool sim_due(const sim *s);

/* Did a problem end with the word that it has no solution, or none to be found? */
bool sim_without_solution(run_status s);

/* No further try in this step: the one that was held back counts. */
void sim_settle_held(sim *s);
