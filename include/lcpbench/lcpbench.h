/* lcpbench.h - the C library: complementarity problems of contact, solved and judged.
 *
 *   find z, w in R^n:   w = M z + q,   z in K,   w in K*,   z _|_ w
 *
 * K is a product of intervals (an LCP where all of them are [0, inf)) and of Coulomb friction cones. Every answer is
 * judged from the data alone, by code that shares no arithmetic with the solvers: `verified` never rests on what a
 * solver says of itself.
 *
 *   lcp_problem *p = lcp_problem_dense(2, M, 0, q);
 *   lcp_report report;
 *   if (lcp_solve(p, "lemke", z, &report) != LCP_OK) fprintf(stderr, "%s\n", lcp_last_error());
 *   lcp_problem_free(p);
 *
 * Arrays are read during a call and copied where they are needed later. Nothing is printed, nothing exits, no signal is
 * touched. Two threads may work at the same time on handles of their own. A function that returns int returns an lcp_code;
 * one that returns a handle returns NULL on failure; in both cases lcp_last_error() has one line.
 */
#ifndef LCPBENCH_H
#define LCPBENCH_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ## Version */

/* Release of the header. */
#define LCP_VERSION "0.1.0"

/* Grows when a struct of this header or the meaning of a function changes; the number in the library's soname. Functions may be
 * added without it. */
#define LCP_API_VERSION 1

/* Release of the library that is loaded, such as "0.1.0". */
const char *lcp_version(void);

/* LCP_API_VERSION of the library that is loaded. A program that finds another number than it was compiled with must not go on. */
int lcp_api_version(void);

/* ## Errors */

/* What a call returns. */
typedef enum lcp_code {
  LCP_OK = 0,          /* done; of a solve or a check: the answer holds */
  LCP_INVALID = 1,     /* an argument outside its documented range */
  LCP_NO_MEMORY = 2,   /* heap or workspace exhausted */
  LCP_IO = 3,          /* a file could not be read */
  LCP_UNSUPPORTED = 4, /* the solver does not take this kind of problem */
  LCP_EXTERNAL = 5,    /* another library reported a failure, or is missing */
  LCP_UNSOLVED = 6     /* an honest failure: not solved or not verified; the report says which */
} lcp_code;

/* One line about the last call of this thread that returned no LCP_OK or no handle; "" where there was none. Valid until the
 * next such call of the thread. */
const char *lcp_last_error(void);

/* ## Problems */

/* A problem with its own copy of the data. */
typedef struct lcp_problem lcp_problem;

/* A problem over z >= 0 with a dense matrix. M: n*n numbers [1/kg], in rows where row_major is not 0, else in columns.
 * q: n numbers [m/s]. Units are those of contact problems; nothing depends on them. All numbers must be finite, n >= 1. NULL:
 * LCP_INVALID or LCP_NO_MEMORY. */
lcp_problem *lcp_problem_dense(int n, const double *M, int row_major, const double *q);

/* The same with compressed columns: column j has the entries colptr[j] .. colptr[j+1]-1 of rowind and val; colptr[0] = 0, row
 * indices increase inside a column (scipy: csc_matrix.sort_indices()). */
lcp_problem *lcp_problem_csc(int n, const int *colptr, const int *rowind, const double *val,
                             const double *q);

/* Intervals lo_i <= z_i <= hi_i in the place of z >= 0, for the rows that are in no cone: w_i > 0 only at lo_i, w_i < 0 only at
 * hi_i. Infinite ends are HUGE_VAL; -inf and inf make a free row (w_i = 0). NULL: 0, or inf. LCP_INVALID where lo_i > hi_i; the
 * problem then is as it was. */
int lcp_problem_set_bounds(lcp_problem *p, const double *lo, const double *hi);

/* Makes the rows start[k] .. start[k]+size[k]-1 a friction cone |r_t| <= mu[k] r_n with z = (r_n, r_t), size 1, 2 or 3, under the
 * exact Coulomb law w + mu |w_t| e_n in K* (De Saxce & Feng 1998). start increases and cones do not overlap. count 0: no cones. */
int lcp_problem_set_cones(lcp_problem *p, int count, const int *start, const int *size,
                          const double *mu);

/* New numbers q[n], finite. */
int lcp_problem_set_q(lcp_problem *p, const double *q);

/* New numbers of M, as many and in the same order as they were given: n*n of a dense matrix, colptr[n] of a sparse one. */
int lcp_problem_set_values(lcp_problem *p, const double *val);

/* Declares what the caller knows of M: "symmetric", "psd", "pd", "copositive", "copositive_plus" or "p_matrix". Some solvers ask for it
 * (lcp_solver_describe); symmetry is found without. A false declaration is not detected, and no answer is believed for it. */
int lcp_problem_declare(lcp_problem *p, const char *trait);

/* Number of unknowns. */
int lcp_problem_size(const lcp_problem *p);

/* Accepts NULL. */
void lcp_problem_free(lcp_problem *p);

/* w = M z + q, n numbers [m/s]. */
int lcp_residual(const lcp_problem *p, const double *z, double *w);

/* ## Solving and judging */

/* What came of a solve, and what the judge found. Residuals are HUGE_VAL where there is no finite answer. */
typedef struct lcp_report {
  const char *solver; /* its name; "" after lcp_verify */
  const char *
      status; /* verdict: "ok", "near", "stalled", "budget", "max_iter", "time_limit", "ray", "infeasible" (proved),
                              "unverified" (claimed, and wrong), "numerical", "unsupported", "error" */
  const char *claim; /* what the solver said: "ok", "max_iter", ..., "" where it was not asked */
  int verified;     /* 1: rho <= tolerance, and small against q (RESIDUALS 4), by the judge alone */
  double tolerance; /* the rho that counts as verified here [1] */
  double rho;       /* the residual that decides; unchanged by scaling of rows, columns and q [1] */
  double natural;   /* max_i |min(M_ii z_i, w_i)| and its like for other sets [m/s] */
  double natural_relative; /* natural / (1 + max |q|) [1] */
  double min_map;          /* max_i |min(z_i, w_i)|, the literature's number */
  double infeasible_z;     /* largest violation of z in K [N s] */
  double infeasible_w;     /* largest violation of w in K* [m/s] */
  double complementarity;  /* sum |z_i w_i| [J] */
  long iterations;         /* the method's own: pivots, sweeps, Newton steps */
  long matvecs;            /* products with M */
  long factorizations;
  double setup_seconds; /* conversion, preparation and factorisation [s] */
  double solve_seconds; /* [s] */
} lcp_report;

/* Solves p with a solver "NAME" or "NAME:option=value,option=value" at its default options; NULL: lcp_default_solver(p). z[n]: the
 * start point on entry (zeros where there is none), the last iterate on return, whatever came of it. report may be NULL. LCP_OK
 * only where the solver claims an answer and the judge agrees; LCP_UNSOLVED where not, also where infeasibility was proved. */
int lcp_solve(const lcp_problem *p, const char *solver, double *z, lcp_report *report);

/* Judges any z[n], wherever it is from: LCP_OK where rho <= tolerance and the violation is small against q
 * (RESIDUALS 4), else LCP_UNSOLVED. tolerance > 0, such as 1e-9. report may
 * be NULL. */
int lcp_verify(const lcp_problem *p, const double *z, double tolerance, lcp_report *report);

/* The name of a solver that takes p: the first of lemke, cone_newton, pgs that does; NULL: none does. */
const char *lcp_default_solver(const lcp_problem *p);

/* A solver with its options and its memory, kept from one solve to the next: the long form of lcp_solve, for loops. */
typedef struct lcp_workspace lcp_workspace;

/* solver as in lcp_solve, but not NULL. NULL: unknown solver or option, or a value out of range. */
lcp_workspace *lcp_workspace_new(const char *solver);

/* lcp_solve in this memory, which grows where p needs more. A warm start is a z that is not zero; which solvers use it says
 * lcp_solver_describe. */
int lcp_workspace_solve(lcp_workspace *work, const lcp_problem *p, double *z, lcp_report *report);

/* Accepts NULL. */
void lcp_workspace_free(lcp_workspace *work);

/* ## Which solvers there are */

/* One solver. All texts live as long as the library. */
typedef struct lcp_solver_info {
  const char *name;  /* as lcp_solve takes it */
  const char *title; /* what the field calls the method */
  const char *words; /* one sentence: what it is */
  const char *when;  /* one sentence: when to take it */
  int bounds;        /* 1: takes intervals besides z >= 0 */
  int free_rows;     /* 1: takes rows with z unbounded */
  int cones;         /* 1: takes friction cones */
  int exact;         /* 1: a direct method, verified at 1e-9; else at 1e-6 */
  int warm;          /* 1: uses the start point */
  int n_option;
} lcp_solver_info;

/* One option of a solver. */
typedef struct lcp_option_info {
  const char *name;
  const char *unit;
  const char *kind; /* "int", "real" or "choice" */
  double standard, least,
      most;          /* default and range; of a choice: index of the default word, and 0, 0 */
  const char *words; /* of a choice: "first|second|third"; else "" */
  const char *help;  /* one sentence */
} lcp_option_info;

/* How many there are. */
int lcp_solver_count(void);

/* The i-th, 0 <= i < lcp_solver_count(). */
int lcp_solver_describe(int i, lcp_solver_info *info);

/* The k-th option of the i-th solver. */
int lcp_option_describe(int i, int k, lcp_option_info *info);

/* Writes all options of "NAME" or "NAME:option=value,..." with the values that a solve would use, as "name=value,...", into
 * text[capacity]. LCP_INVALID where it does not fit. */
int lcp_options(const char *solver, char *text, size_t capacity);

/* Adds the solver of a plug-in (lcp_plugin.h) to the list, by its own name. file: its path. The plug-in runs in this process: one that
 * crashes takes the program with it. Called before any other thread uses the library. LCP_IO: it cannot be loaded; LCP_INVALID:
 * no plug-in, of another interface, or a name that is taken. */
int lcp_plugin_load(const char *file);

/* ## A step of contact dynamics */

/* Rigid bodies and the points where they touch, in world axes. */
typedef struct lcp_contacts {
  int n_body;
  const double *inverse_mass;    /* n_body [1/kg], 0: cannot move */
  const double *inverse_inertia; /* 9 n_body, symmetric 3x3, world axes [1/(kg m^2)] */
  const double *position;        /* 3 n_body, centres of mass [m] */
  int n_contact;
  const int *
      body; /* 2 n_contact: the body that the normal points to, and the other; -1: the fixed world */
  const double *point;  /* 3 n_contact [m] */
  const double *normal; /* 3 n_contact, of length one */
  const double *mu;     /* n_contact, coefficients of friction, >= 0 [1] */
  const double *
      bias; /* n_contact or NULL for zeros: what is added to the normal velocity, such as gap / h, or e times the
                           normal velocity before an impact [m/s] */
} lcp_contacts;

/* One time step with exact Coulomb friction: impulses r such that the velocities after them satisfy, at each contact,
 * 0 <= u_n + bias _|_ r_n >= 0, |r_t| <= mu r_n, r_t against u_t. velocity[6 n_body]: v [m/s] and omega [rad/s] of each body, on
 * entry with all other forces of the step applied, on return after the contacts. impulse[3 n_contact]: on the first body of each
 * contact, world axes [N s]; on entry the start point (zeros, or those of the last step). solver: one that takes cones; NULL:
 * cone_newton. The velocities change only where LCP_OK or LCP_UNSOLVED is returned. */
int lcp_contact_step(const lcp_contacts *contacts, const char *solver, double *velocity,
                     double *impulse, lcp_report *report);

#ifdef __cplusplus
}
#endif
#endif
