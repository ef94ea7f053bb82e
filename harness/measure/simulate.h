/* harness/measure/simulate.h - the step loop: contacts -> formulation -> solver -> state, with every solve
 * judged from its data and every phase timed.
 *
 * Timed (CLOCK_MONOTONIC): contacts (detection and contact set), assemble (begin, assemble,
 * recover), setup, factor, solve (inside lcp_instance), share (lcp_share, on the solver's answer) and advance. Judging, recording and hashing
 * are outside every bracket. */
#pragma once

#include "harness/measure/answers.h"
#include "harness/measure/combination_plan.h"
#include "harness/measure/dump.h"
#include "harness/measure/effects_plan.h"
#include "harness/measure/registry.h"
#include "harness/measure/series.h"
#include "harness/measure/trace.h"
#include "harness/measure/verdict.h"
#include "lcp/lcp_instance.h"

#include <stdint.h>
#include <stdio.h>

/* A problem that was solved, with its judged answer. */
typedef struct sim_solved {
  long step; /* from 1 */
  const lcp_problem *p;
  formulation_rows rows;
  const double *z;
  run_status status;
  bool verified; /* rho within the tolerance of the solver's kind */
  double rho;
} sim_solved;

/* Told of every one of them, outside of every bracket. */
typedef struct sim_listener {
  base_status (*solved)(void *ctx, const sim_solved *k, base_error *err);
  void *ctx;
} sim_listener;

typedef struct sim_request {
  const scene_spec *spec;
  unsigned effects; /* what is simulated, EFFECT_ bits */
  const effects_plan
      *plan;   /* NULL: these all along; otherwise it tells from which step on which are */
  bool judged; /* though effects are left out, the scene's predictions apply (--effects auto) */
  const formulation_choice *form;
  const solver_choice *solver;
  const combination_plan *
      combinations; /* NULL: these all along; otherwise the two are its first, and it tells from which step on which are */
  double h;         /* [s] */
  const double
      *step; /* NULL: all steps take h; otherwise one length for each of n_step steps [s] */
  long n_step;
  double duration; /* [s] */
  formulation_start start;
  uint64_t contact_order; /* seed of the order of contacts; 0: as the scene lists them */
  FILE *trajectory;       /* NULL: none; otherwise CSV, one row per body and step */
  scene_spec
      *end; /* NULL: none; otherwise a copy of spec, which begins at the end of the run then */
  trace_file *trace;            /* NULL: none; a traced run is not to be timed */
  dump *dump;                   /* NULL: none; the problems of chosen steps are written as files */
  const sim_listener *listener; /* NULL: nobody */
  answers *store;               /* NULL: none; every answer is written here */
  bool sleep;   /* bodies that lie still and are not reached sleep (world_fall_asleep) */
  bool islands; /* a problem that falls into parts is solved part by part (lcp_islands.h) */
  int threads;  /* that share the work; 0 counts as 1 */
  bool
      least_memory; /* solver, judge and choice have their workspaces one after another, however few unknowns */
  answers *replay; /* NULL: the solver solves; otherwise its answers are taken from here */
  double
      until; /* base_seconds() that the run ends at, or at a signal, wherever it is [s]; HUGE_VAL: at a signal alone; 0: at none */
} sim_request;

typedef struct sim_times {
  double contacts, assemble, setup, factor, solve, share, advance; /* [s], summed over the steps */
  double watch; /* of effects that are left out, and their coming in [s] */
} sim_times;

double sim_times_sum(const sim_times *t); /* [s] */
void sim_times_add(sim_times *sum, const sim_times *t);

/* The steps of one combination of a run that changes it. */
typedef struct sim_part {
  run_status status;
  bool verified;
  double rho_max;                                    /* [1] */
  long steps_before, solves_before, unsolved_before; /* of the whole run, as it began */
  lcp_work work_before;
  sim_times time_before;
} sim_part;

typedef struct sim_result {
  run_status status;  /* worst over the steps */
  run_status claimed; /* worst of what the solver claimed */
  char note[240];     /* first trouble, with its step */
  long steps, steps_planned;
  long n_unsolved; /* solves whose status is not ok */
  bool verified;   /* every solve rho <= tolerance */
  bool finite;
  int n_body, n_dof;
  int lcp_dim_max, n_contact_max, n_active_max;
  long nnz_max;
  lcp_storage storage;
  long n_solves, n_modes, n_fallbacks;
  int deficit_max; /* most touching normal rows beyond their rank in one solve; LCP_SHARE_UNCOUNTED: not counted in all */
  long n_shared,
      n_share_missed;           /* solves of which such an answer was chosen; could not be chosen */
  int n_asleep_max;             /* bodies */
  long n_asleep;                /* summed over the steps */
  int n_island, largest_island; /* most in one solve; unknowns of the largest. 0: not asked for */
  long n_evaluations;           /* of the right-hand side, by formulations that integrate */
  lcp_work work;
  const char *variant;
  double rho_max;                          /* [1] */
  double natural_max, natural_rel_max;     /* [m/s], [1] */
  double feas_z_max, feas_w_max, comp_max; /* [N s], [m/s], [J] */
  long n_judged; /* steps judged on the exact cone: none where a formulation steps by itself */
  double ncp_max, ncp_rel_max;          /* [m/s], [1] */
  double cone_rel_max, dissipation_max; /* [1], [J] */
  double penetration_max;               /* [m] */
  double approach_max; /* [m], of a gap that closed inside a step; NaN where not known */
  double energy_defect, energy_drift_rel; /* largest increase in one step [J]; [1] */
  double stiffness_ratio;                 /* least G/m_t [1], HUGE_VAL: nothing regularised */
  double v_slip, deflection;              /* regularisation: [m/s], [m] */
  double own_residual_max;                /* the formulation's own [1] */
  unsigned effects_seen;
  size_t workspace; /* [B] */
  sim_times time;
  double step_longest; /* longest single step [s] */
  uint64_t hash;       /* FNV-1a of every answer z and every velocity: same bits, same hash */
  int n_part;          /* 1, and one more with each change of the combination that came */
  sim_part part[COMBINATION_SPANS]; /* last: a checkpoint keeps those that there are */
} sim_result;

double sim_total_seconds(const sim_result *r);

/* Of a step this share may lie beyond the end of the run, for the rounding of decimal numbers. */
#define SIM_LAST_STEP 1e-9 /* [1] */

/* How many steps the run has: as many as are given, or even ones up to the end. */
long sim_steps_planned(const sim_request *q);

/* Step h over `duration` [s]: BASE_EINVAL unless both are finite and above 0 and the steps at most 2e9;
 * BASE_EUNSUPPORTED where the step is longer than the run. */
base_status sim_check_times(double h, double duration, base_error *err);

/* Runs and records. `record` is opened here and owned by the caller (series_close) whatever is
 * returned. Failure of a solver is a status of the result, an error return is misuse, an
 * unsupported combination included as RUN_UNSUPPORTED with a note. */
base_status simulate(const sim_request *q, series *record, sim_result *out, base_error *err);
