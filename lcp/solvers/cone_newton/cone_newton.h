/* cone_newton.h - what the parts of cone_newton share: its state, its rooms (cone_newton_rooms.c) and its outer steps
 * (cone_newton_outer.c). solver_cone_newton.c has the method. */
#pragma once

#include "lcp/lcp_farkas.h"
#include "lcp/solvers/cone_step.h"
#include "lcp/solvers/facet_fold.h"
#include "lcp/solvers/loop.h"

static const double cone_newton_least_weight = 1e-12, cone_newton_most_weight = 10.0;

typedef struct cone_newton_options {
  lcp_stop stop;
  int map;
  double weight, shrink;
} cone_newton_options;

typedef struct cone_newton {
  lcp_loop loop;
  lcp_cone_scaled eq;
  lcp_cone_step step;
  double *x, *y;  /* n, where F is taken */
  double *center; /* n, in x */
  double *dx;     /* n */
  double *trial;  /* n, z */
  double *wt;     /* n, w of the trial */
  double *best;   /* n, z of the smallest residual */
  double *proof;  /* n, Farkas vector */
  lcp_fold fold; /* facets are solved folded: all above but `best` is of the folded problem then, */
  double *inner, *w;     /* n: the iterate there, its w */
  double *shown;         /* n: what a trial is unfolded */
  unsigned char *kind;   /* n, of lcp_farkas.h */
  lcp_farkas_sum *force; /* n_dof */
  /* of the outer step */
  lcp_map map;
  double weight, shrink;
  double bare;   /* |F|^2 without the weight at the centre */
  double lowest; /* |F|^2 */
  int waited;    /* steps since */
  int rounded;   /* outer steps of this solve that ended at rounding */
  bool started;
  bool blind;                 /* |F| is rounding */
  int n_inner;                /* unknowns that the arrays of the inner problem have room for */
  void *wide;                 /* owned: those arrays where facets did not fold that could, */
  struct cone_newton *narrow; /* owned: and the state to come back to; NULL otherwise */
} cone_newton;

/* The problem that is solved: p, or p with its facets folded. */
static inline const lcp_problem *lcp_cone_newton_inner(const cone_newton *s, const lcp_problem *p) {
  return s->fold.done ? &s->fold.p : p;
}

/* Arrays of the problem that is solved, n_folded unknowns where facets fold; the rest of p's own size. */
void lcp_cone_newton_layout(cone_newton *s, const lcp_capacity *cap, base_arena *a);

/* Folds facets where they do, otherwise takes room for all unknowns. BASE_ENOMEM without it, else as lcp_cone_step_prepare. */
base_status lcp_cone_newton_prepare(cone_newton *s, const lcp_problem *p, base_error *err);
void lcp_cone_newton_release(cone_newton *s);

/* w = M z + q. */
void lcp_cone_newton_velocities(const cone_newton *s, const lcp_problem *p, const double *z,
                                double *w, lcp_result *res);

/* |F|^2 at z with w = M z + q and this weight; F stays, with `slope` its derivatives too. */
double lcp_cone_newton_merit(cone_newton *s, int n, double weight, const double *z, const double *w,
                             bool slope);

/* The next outer step begins at z. */
void lcp_cone_newton_recentre(cone_newton *s, int n, const double *z);

/* A larger weight, which shrinks more slowly, and the other map. */
void lcp_cone_newton_stalled(cone_newton *s, const cone_newton_options *o, lcp_result *res);

/* Where the outer step stands, before the next Newton step from z: on, or on to the next. Returns |F|^2.
 * Over facets an outer step that stalls farther off than it began starts again from its centre, with the larger weight: the map
 * has pieces, and iterates that are lost among them tell nothing. res->outcome turns LCP_INFEASIBLE where that is proved. */
double lcp_cone_newton_advance(cone_newton *s, const cone_newton_options *o, const lcp_problem *p,
                               double *z, double *w, lcp_result *res);
