/* batch_test.h - a residual test that is bound to fail is not made.
 *
 * No claim is made where one contact alone is above the limit of data_test.h, and after a few sweeps of many one such contact
 * is soon found: first where the last one was. w of a contact comes from the body velocities that the sweep in batches
 * keeps (contact_batches.h), at a few dozen operations; a whole test costs a dozen sweeps. */
#pragma once

#include "lcp/solvers/loop.h"

/* So many sweeps of a method from z to z. */
typedef void (*lcp_batch_sweeps)(void *state, const lcp_problem *p, long sweeps, double *z);

typedef struct lcp_batch_test {
  lcp_loop *loop;
  const lcp_stop *stop;
  lcp_batch_sweeps sweeps;
  void *state;        /* of the method */
  const double *body; /* the velocities that `sweeps` leaves */
  bool every;         /* no test is put off: a history is wanted */
  int group, block;   /* of the last contact found, and its first block; begin with zeroes */
} lcp_batch_test;

/* Sweeps on to the first test that is not bound to fail, or the last. True: the loop has ended without one
 * (lcp_loop_put_off). Counts iterations and sweeps. */
bool lcp_batch_run(lcp_batch_test *t, const lcp_problem *p, double *z, lcp_result *res);

/* True where some contact is above the limit by more than rounding, so that lcp_loop_ended could not claim z. All rows of p
 * belong to groups of bodies with six velocities. Writes to loop->stop.w. */
bool lcp_batch_test_fails(lcp_batch_test *t, const lcp_problem *p, const double *z);
