#include "lcp/solvers/contact_sweep_kernel.h"

#include "lcp/base/clones.h"

BASE_CLONES void lcp_contact_kernel_sweep(lcp_contact_batch *batch, int count, double *body,
                                          double omega) {
  const lcp_v4 zero = {0, 0, 0, 0};
  for (int k = 0; k < count; k++) {
    lcp_contact_batch *c = &batch[k];
    lcp_lane_motion m;
    lcp_v4 u[3], dx[3];
    lcp_lanes_open(&c->at, body, &m, u);
    for (int r = 0; r < 3; r++) {
      lcp_v4 w = c->q[r] + u[r];
      if (r == 1) {
        w += c->A[0] * dx[0];
      } else if (r == 2) {
        w += c->A[1] * dx[0] + c->A[2] * dx[1];
      }
      lcp_v4 x = c->x[r] - omega * w;
      if (r == 0) {
        x = LCP_CHOOSE(x > zero, x, zero);
      } else {
        const lcp_v4 hi = c->bound[r - 1], lo = -hi;
        x = LCP_CHOOSE(x > lo, x, lo);
        x = LCP_CHOOSE(x < hi, x, hi);
      }
      dx[r] = x - c->x[r];
      c->x[r] = x;
    }
    lcp_lanes_push(&c->at, body, &m, dx);
  }
}

BASE_CLONES void lcp_contact_kernel_push(const lcp_contact_batch *batch, int count, double *body) {
  for (int k = 0; k < count; k++) {
    lcp_lane_motion m;
    lcp_v4 u[3];
    lcp_lanes_open(&batch[k].at, body, &m, u);
    lcp_lanes_push(&batch[k].at, body, &m, batch[k].x);
  }
}
