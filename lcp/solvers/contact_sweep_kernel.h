/* contact_sweep_kernel.h - the record of four contacts and the two loops over it. */
#pragma once

#include "lcp/solvers/contact_sweep.h"

struct lcp_contact_batch {
  lcp_lane_frame at;
  lcp_v4 A[3];     /* scaled M_10, M_20, M_21 [1] */
  lcp_v4 q[3];     /* q / sqrt(M_ii) */
  lcp_v4 x[3];     /* z sqrt(M_ii) */
  lcp_v4 bound[2]; /* friction bound sqrt(M_ii) */
};

/* One sweep, four contacts at once. */
void lcp_contact_kernel_sweep(lcp_contact_batch *batch, int count, double *body, double omega);

/* Adds the velocities that the impulses x cause. */
void lcp_contact_kernel_push(const lcp_contact_batch *batch, int count, double *body);
