/* problems/read/case_file.h - a whole file in the case format: complementarity problems with what is
 * known of them, scenes, equivalences between scenes, Painleve regimes. Everything is owned by the
 * case_file. The words and numbers are the file's own; judging is the harness' business. */
#pragma once

#include "problems/families/known_lcp.h"
#include "problems/read/scene_file.h"

/* The status vocabulary of the case format, as bits. */
#define CASE_STATUS_LIST(X)                                                                        \
  X(CASE_SOLVED, "solved")                                                                         \
  X(CASE_INFEASIBLE, "infeasible")                                                                 \
  X(CASE_NO_SOLUTION, "no_solution")                                                               \
  X(CASE_UNSOLVED_RAY, "unsolved_ray")                                                             \
  X(CASE_NOT_CONVERGED, "not_converged")                                                           \
  X(CASE_NOT_APPLICABLE, "not_applicable")                                                         \
  X(CASE_NUMERICAL_FAILURE, "numerical_failure")                                                   \
  X(CASE_INVALID_INPUT, "invalid_input")
#define CASE_ENUM_(id, text) id##_BIT,
enum { CASE_STATUS_LIST(CASE_ENUM_) CASE_STATUS_COUNT };
#define CASE_MASK_(id, text) id = 1u << id##_BIT,
typedef enum case_status { CASE_STATUS_LIST(CASE_MASK_) CASE_NO_STATUS = 0 } case_status;
const char *case_status_name(int bit);

/* How Gauss-Seidel sweeps fare on the case. */
typedef enum case_sweeps {
  CASE_SWEEPS_UNSTATED,
  CASE_SWEEPS_CYCLE,
  CASE_SWEEPS_DIVERGE,
  CASE_SWEEPS_NOT_DEFINED, /* zero diagonal */
} case_sweeps;

/* A set of linear equations C z = c that every member of a solution set satisfies. */
typedef struct case_invariants {
  char name[64];
  int n_row;
  double *C; /* n_row x n, row by row */
  double *c; /* n_row */
} case_invariants;

typedef struct lcp_case {
  char id[32], group[32], title[160], kind[32];
  char note[160], source[192], certificate[160], formula[160];
  unsigned correct, honest_failure, false_claim; /* CASE_ bits */
  int n;                                         /* unknowns stated */

  /* The data. `shape_error` (non-empty) says why M and q as given are no problem at all (M not
   * n x n, wrong length of q); then k holds none. Otherwise k.p is set, perhaps with NaN or
   * infinite entries that lcp_problem_check must refuse. */
  char shape_error[120];
  known_lcp k;

  int n_solution; /* listed solutions, n each; complete: there are no others */
  double *solution;
  bool solutions_complete;
  double *example;            /* one solution of many, or NULL */
  double *w;                  /* or NULL */
  case_invariants invariants; /* n_row = 0: none; every solution satisfies them */
  int n_set;                  /* alternatively: z satisfies one of these sets */
  case_invariants *set;

  double forward_tol;      /* 0: not judged. max|z - z*| / max|z*| */
  double residual_floor;   /* least attainable violation of an infeasible case; 0: unstated */
  long lemke_pivots;       /* exact counts; 0: unstated */
  long least_index_pivots; /* of the lexicographic Lemke with d = 1, and of least index */
  double *ray_d;           /* covering vector with which Lemke ends on a ray, or NULL */
  int binary_first;        /* the first so many z are 0 or 1 */
  case_sweeps sweeps;
  double sweep_rate; /* 0: unstated */
  char cycles[96];   /* tie rules of Lemke's method that cycle, "min maxvar" */
} lcp_case;

/* The same scene twice, or two scenes, that must agree to tol at time t. */
typedef struct case_equivalence {
  char id[64], a[64], b[64], why[160];
  double t, tol;
  int n_var;
  char var_a[SPEC_OBSERVE][2 * SPEC_NAME], var_b[SPEC_OBSERVE][2 * SPEC_NAME];
  unsigned off_b;     /* effects switched off in b */
  int facets_b;       /* 0: as in the scene */
  int multiplicity_b; /* 0: as in the scene */
} case_equivalence;

typedef struct case_painleve {
  double tan_theta, theta, mu, omega, v_tip, p, b, mu_crit;
  char regime[SPEC_NAME], solutions[96];
  bool has_n_slip, has_impulse, impulse_in_cone;
  double n_slip, impulse_n, impulse_t;
  bool has_after;
  double after[3]; /* v_x, v_y of the centre and omega after the impulse */
} case_painleve;

typedef struct case_file {
  scene_file scenes;
  int n_lcp;
  lcp_case *lcp;
  int n_equivalence;
  case_equivalence *equivalence;
  int n_painleve;
  case_painleve *painleve;
} case_file;

/* Fails on a file that is not of the format; a scene that cannot be read is listed in
 * scenes.failed, everything else must be readable. */
base_status case_file_read(const char *path, case_file *out, base_error *err);
void case_file_free(case_file *f);
