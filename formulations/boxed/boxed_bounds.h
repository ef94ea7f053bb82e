/* formulations/boxed/boxed_bounds.h - the loop over the bounds of `boxed`: lambda_n behind the bounds such that the answer has it
 * again. First the bounds follow the answer; then their moves are mixed (anderson.h); where that does not settle, turns of
 *
 *   a safeguarded iteration: each bound goes a share of its move, halved whenever the move turns round and raised by
 *     SHARE_UP while it does not, which cannot run in circles about the answer of one contact, and
 *   a trial of Newton's method from there, which stands where it settles. Which rows stand at which
 *     bound is known from the last solve; bounds that agree with their own answer are then those of a linear system,
 *       w_F = 0 of the rows F between,   lambda_t = +-mu lambda_n at a bound,   lambda_n = 0 where a contact is open
 *
 * and mixing again from where these ended. */
#pragma once

#include "formulations/anderson.h"

typedef struct row_form row_form;

typedef struct boxed_bounds {
  anderson mixing;
  int taken;  /* solves of this round of the loop */
  bool first; /* round of this step */
  bool trial; /* the last bounds were Newton's */
  bool anew;  /* a solve gave its start back; those of the step begin at zero since */
  double *base, *share, *moved; /* n_contact: the safeguarded point, its shares and last moves */
  int cap_contact;
  bool filled;   /* M is that of this step */
  double *M, *A; /* n_row^2: M, and the system of the rows between */
  double *x;     /* n_row: its right side, then its answer */
  double *side;  /* n_row: +1, -1: at that bound, or normal row of an open contact; 0: between */
  int *between, *pivot;
  int cap_row;
  void *mem, *dense_mem; /* owned */
} boxed_bounds;

base_status boxed_bounds_begin(boxed_bounds *b, int n_contact, base_error *err);
/* s->normal for the next solve, in: those of the last one, after which s->move, s->lo, s->hi and s->w are those of its
 * answer z under them. solved: that it was claimed to be an answer; bounds of a trial that was none are given up. */
base_status boxed_bounds_next(boxed_bounds *b, row_form *s, const double *z, bool solved,
                              base_error *err);
void boxed_bounds_close(boxed_bounds *b);
