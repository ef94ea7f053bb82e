/* cone_polish.h - the last digits of a cone problem from the modes of a point that is nearly an answer.
 *
 * The modes (cone_map.h) of a point, or of x - y / balance, are held; what is left is a smooth system, solved by Newton's
 * method until its residual no longer falls to half. Each step is a proximal one around the last point, of a weight that goes with the
 * residual: it keeps the system of redundant contacts regular and leaves no trace where it ends. An answer that contradicts its modes gives
 * others, fifteen times at most, and while they differ in 64 rows and a sixteenth of them at most: where more change from one time to the next,
 * on piles of spheres, none of 16 rounds came to rest. It is the answer only where it passes the method's own test, moved into K; otherwise nothing
 * has happened. */
#pragma once

#include "lcp/solvers/cone_step.h"
#include "lcp/solvers/loop.h"

typedef struct lcp_cone_polish {
  lcp_cone_scaled eq;
  lcp_cone_step step;
  unsigned char *mode, *failed; /* n */
  double *x, *y, *dx, *z, *w;   /* n */
  double *d;                    /* n, diagonal */
  long next;                    /* iteration of the next attempt */
} lcp_cone_polish;

void lcp_cone_polish_layout(lcp_cone_polish *s, const lcp_capacity *cap, base_arena *a);

/* BASE_EUNSUPPORTED: what lcp_cone_scaled_begin and lcp_cone_step_prepare refuse. */
base_status lcp_cone_polish_prepare(lcp_cone_polish *s, const lcp_problem *p, base_error *err);

/* Before the first iteration. */
void lcp_cone_polish_begin(lcp_cone_polish *s);

/* After a residual test at z that did not end the loop. True: z is the answer and *res says so. Attempts are made at iterations
 * that grow by a quarter, at least twice as many as the last one took factorisations, and never twice running from the same modes.
 * Factorisations are counted; every set of modes that was not the answer counts in `refinements`.
 * point[n]: what the first modes are read off, scaled as x; NULL: x - y / balance. BASE_ENOMEM through *status. */
bool lcp_cone_polish_try(lcp_cone_polish *s, lcp_loop *loop, const lcp_stop *stop,
                         const lcp_problem *p, double balance, const double *point, double *z,
                         lcp_result *res, base_status *status);

void lcp_cone_polish_release(lcp_cone_polish *s);
