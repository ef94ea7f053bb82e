/* facet_batches_kernel.h - the record of four contacts with facets and the loops over it. */
#pragma once

#include "lcp/solvers/contact_lanes.h"

enum { LCP_FACETS_MAX = 16 };

typedef struct lcp_facet_batch {
  lcp_lane_frame at;
  lcp_v4 q[3], A[6]; /* in the frame; A_nn, A_n1, A_n2, A_11, A_12, A_22 */
  lcp_m4 basis;      /* bit i: unknown i is basic */
} lcp_facet_batch;

typedef struct lcp_facet_lanes lcp_facet_lanes;

/* Unknowns x[i][lane] of a lane whose basis does not hold for b, and its new basis. */
typedef void (*lcp_facet_resolve)(void *context, int batch, int lane, const lcp_v4 *b, lcp_v4 *x);

struct lcp_facet_lanes {
  lcp_facet_batch *batch; /* n_batch */
  lcp_v4 *z;              /* facets + 2 a batch */
  lcp_v4 *
      linear; /* as many rows of four: the value or slack of each unknown over b, and of a slack what rounding may take from it, over |b|_1 */
  double *body; /* lcp_contact_bodies */
  int n_batch, facets;
  double facet[LCP_FACETS_MAX][2];
};

void lcp_facet_kernel_sweep(const lcp_facet_lanes *s, lcp_facet_resolve resolve, void *context);

/* Adds the velocities that the impulses cause. */
void lcp_facet_kernel_push(const lcp_facet_lanes *s);
