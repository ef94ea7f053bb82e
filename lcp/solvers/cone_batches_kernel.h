/* cone_batches_kernel.h - the record of four cones and the loops over it. */
#pragma once

#include "lcp/solvers/contact_lanes.h"

typedef struct lcp_cone_batch {
  lcp_lane_frame at;
  lcp_v4 q[3], r[3];        /* in the frame */
  lcp_v4 inverse;           /* 1 / A_nn */
  lcp_v4 slope[2];          /* A_tn / A_nn */
  lcp_v4 stiff[2], soft[2]; /* S, and its inverse */
  lcp_v4 mu;                /* an idle lane has w_n = 1 and stays open */
  lcp_v4 slip;              /* a of the last slip; 0: none */
} lcp_cone_batch;

void lcp_cone_kernel_sweep(lcp_cone_batch *batch, int count, double *body, double omega);

/* Adds the velocities that the impulses cause. */
void lcp_cone_kernel_push(const lcp_cone_batch *batch, int count, double *body);
