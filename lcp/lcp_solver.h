/* lcp/lcp_solver.h - what a solver is.
 *
 * A solver is one constant of type lcp_solver in one .c file under lcp/solvers. It allocates
 * nothing while it solves, prints nothing, keeps no static state and never writes to the problem
 * or to its options.
 */
#pragma once

#include "lcp/base/fields.h"
#include "lcp/lcp_outcome.h"
#include "lcp/lcp_problem.h"

#include <stdint.h>

/* Stopping rule. First member of every options struct, so all solvers stop on
 * the same terms and none can hide a private iteration limit. */
typedef struct lcp_stop {
  double tol;         /* on the scale-invariant residual rho of lcp_judge.h [1] */
  int max_iter;       /* method's own iterations (pivots, sweeps, Newton steps) */
  int check_every;    /* iterations between residual evaluations, >= 1 */
  double max_seconds; /* [s], tested when the residual is tested */
} lcp_stop;

#define LCP_STOP_FIELDS(T, tol_, max_iter_) LCP_STOP_FIELDS_EVERY(T, tol_, max_iter_, 1)

/* The same with another default of check_every. */
#define LCP_STOP_FIELDS_EVERY(T, tol_, max_iter_, every_)                                          \
  BASE_FIELD_NAMED(T, stop.tol, "tol", BASE_REAL, "1", tol_, 0, 1, "residual rho to reach"),       \
      BASE_FIELD_NAMED(T, stop.max_iter, "max_iter", BASE_INT, "1", max_iter_, 1, 2e9,             \
                       "iteration limit"),                                                         \
      BASE_FIELD_NAMED(T, stop.check_every, "check_every", BASE_INT, "1", every_, 1, 1e6,          \
                       "iterations per residual test"),                                            \
      BASE_FIELD_NAMED(T, stop.max_seconds, "max_seconds", BASE_REAL, "s", 600, 0, 1e6,            \
                       "wall-time limit of one solve")

/* Machine-independent cost; comparable between runs where seconds are not. */
typedef struct lcp_work {
  long iterations, pivots, sweeps, matvecs, factorizations, backsolves, refinements, linesearches,
      fallbacks;
} lcp_work;

void lcp_work_add(lcp_work *sum, const lcp_work *more);

typedef struct lcp_result {
  lcp_outcome outcome; /* the solver's claim; the harness judges separately */
  double residual;     /* last residual the solver saw (its own estimate of rho) */
  lcp_work work;
  lcp_certificate certificate;
  const char *variant; /* which branch of the method ran ("spg", "extragradient"); static or "" */
  long solutions;      /* isolated solutions found by a method that counts them; -1: not counted */
  double aside;        /* of checks that are no part of the method, in its solve [s] */
} lcp_result;

/* Convergence history, preallocated by the harness. NULL in timed runs: a run
 * is either timed or traced, never both. */
typedef struct lcp_trace {
  int cap, len;
  long *iteration;
  double *residual; /* [1] */
} lcp_trace;

typedef struct lcp_solver {
  const char *name;  /* stable key: command line, CSV, file name */
  const char *title; /* what the field calls the method */
  const char *words; /* one sentence for a reader who meets the name for the first time */
  const char *when;  /* one sentence: when to take it */
  const char *cite;  /* keys of docs/references.bib: "lemke1965; cottle1992, 4.4 and 4.9" */
  unsigned sets;     /* 1u << lcp_set it solves */
  unsigned storages; /* 1u << lcp_storage it reads natively */
  bool by_factors;   /* reads the factors of a matrix that has them beside a sparse storage */
  bool
      newton; /* takes Newton's steps on the whole problem: more unknowns cost more a step, hardly more steps */
  unsigned needs; /* lcp_trait bits a problem must have */
  bool exact;     /* a direct method: judged at LCP_VERIFY_EXACT */
  bool warm;      /* uses the start point z on entry */
  bool allocates; /* true only for wrappers whose library calls malloc */
  bool peer;      /* another project's code */

  const base_field *fields; /* of the options struct */
  int n_fields;
  size_t options_size;
  size_t state_size;
  const void *
      context; /* NULL, or what the first member of the state, a pointer, is set to before layout: functions that
                          serve several descriptors (plug-ins) find their own there */

  /* Carves the arrays of *state out of `a`. Stores pointers, touches no memory:
   * called on a measuring arena first. */
  void (*layout)(void *state, const lcp_capacity *cap, const void *opt, base_arena *a);

  /* Problem-dependent set-up that is not a factorisation (transpose, scaling, symbolic analysis);
   * timed as set-up. May be NULL. BASE_EUNSUPPORTED: this problem is outside what it can do. */
  base_status (*prepare)(void *state, const lcp_problem *p, const void *opt, base_error *err);

  /* Numerical factorisation done once before the iteration; timed as factor. May be NULL. */
  base_status (*factor)(void *state, const lcp_problem *p, const void *opt, base_error *err);

  /* z[n]: start point on entry (zero when cold), final iterate on return, whatever the outcome.
   * An error return means misuse or machine trouble, never "did not converge". */
  base_status (*solve)(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                       double *z, lcp_result *res);

  /* Gives back third-party handles. NULL unless `allocates`. */
  void (*release)(void *state);
} lcp_solver;

/* The members of a descriptor that every file of a solver calls the same: its options are the struct `options`, its
 * state is state_. `prepare`, `factor` and `release` are named by those that have them. */
#define LCP_SOLVER_PARTS(state_)                                                                   \
  .fields = fields, .n_fields = BASE_COUNT(fields), .options_size = sizeof(options),               \
  .state_size = sizeof(state_), .layout = layout, .solve = solve

/* Of an lcp_set, as errors and lists tell it; NULL beyond the last. */
const char *lcp_set_name(int set);

/* Of the trait 1u << trait; NULL beyond the last. */
const char *lcp_trait_name(int trait);

/* The bit of a trait by its word ("psd"); 0: there is none, or it is one that is never declared (zero_diagonal). */
unsigned lcp_trait_find(const char *name);

/* All solvers of this build, in the order of lcp/solvers/meson.build. */
const lcp_solver *const *lcp_solvers(int *count);
const lcp_solver *lcp_solver_find(const char *name); /* NULL if absent */

/* BASE_OK if the solver may be asked to solve p, else BASE_EUNSUPPORTED with the missing set or
 * trait named in err. Storage is not asked here: lcp_instance converts (and charges it). */
base_status lcp_solver_admits(const lcp_solver *s, const lcp_problem *p, base_error *err);

/* ---- shared stopping test for iterative methods -------------------------------------------- */

/* Scratch for the test, carved by the solver's layout. */
typedef struct lcp_stop_state {
  double started;  /* [s] */
  double *w;       /* n */
  double *d;       /* n, diagonal */
  double *tau;     /* n, |q| + |M| zref, refreshed with each test */
  double *zref;    /* n */
  double *scratch; /* lcp_matrix_scratch */
} lcp_stop_state;

void lcp_stop_layout(lcp_stop_state *s, const lcp_capacity *cap, base_arena *a);
void lcp_stop_begin(lcp_stop_state *s, const lcp_problem *p);

/* One residual test at z: true when the loop must end, with res->outcome and res->residual set.
 * Counts its product in res->work.matvecs and appends to the trace (NULL: none). */
bool lcp_stop_test(lcp_stop_state *s, const lcp_stop *stop, const lcp_problem *p, const double *z,
                   lcp_trace *trace, lcp_result *res);

/* The same residual for a method that ends by itself: true when z meets tol. Sets res->residual and
 * counts the product; the outcome is the method's to say. */
bool lcp_stop_met(lcp_stop_state *s, double tol, const lcp_problem *p, const double *z,
                  lcp_result *res);
