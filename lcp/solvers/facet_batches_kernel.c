#include "lcp/solvers/facet_batches_kernel.h"

#include "lcp/base/clones.h"

/* p = (z_n, sum f_k z_k) */
LCP_LANES_INLINE void impulse(const lcp_facet_lanes *s, const lcp_v4 *z, lcp_v4 *p) {
  p[0] = z[0];
  p[1] = s->facet[0][0] * z[1];
  p[2] = s->facet[0][1] * z[1];
  for (int k = 1; k < s->facets; k++) {
    p[1] += s->facet[k][0] * z[1 + k];
    p[2] += s->facet[k][1] * z[1 + k];
  }
}

BASE_CLONES void lcp_facet_kernel_sweep(const lcp_facet_lanes *s, lcp_facet_resolve resolve,
                                        void *context) {
  const lcp_v4 zero = {0, 0, 0, 0};
  const int m = s->facets + 2;
  for (int j = 0; j < s->n_batch; j++) {
    const lcp_facet_batch *c = &s->batch[j];
    lcp_v4 *z = s->z + (ptrdiff_t)m * j, *linear = s->linear + (ptrdiff_t)(4 * m) * j;
    lcp_lane_motion motion;
    lcp_v4 b[3], p[3], next[3], x[LCP_FACETS_MAX + 2];
    lcp_m4 left = {0, 0, 0, 0}, basis = c->basis;
    lcp_lanes_open(&c->at, s->body, &motion, b);
    impulse(s, z, p);
    b[0] += c->q[0] - (c->A[0] * p[0] + (c->A[1] * p[1] + c->A[2] * p[2]));
    b[1] += c->q[1] - (c->A[1] * p[0] + (c->A[3] * p[1] + c->A[4] * p[2]));
    b[2] += c->q[2] - (c->A[2] * p[0] + (c->A[4] * p[1] + c->A[5] * p[2]));
    const lcp_v4 size = LCP_SIZE(b[0]) + LCP_SIZE(b[1]) + LCP_SIZE(b[2]);
    for (int i = 0; i < m; i++, linear += 4) {
      const lcp_v4 y = linear[0] * b[0] + (linear[1] * b[1] + linear[2] * b[2]);
      left |= ~(y + linear[3] * size >= zero);
      x[i] = LCP_CHOOSE(-(basis & 1), y, zero);
      basis >>= 1;
    }
    for (int l = 0; LCP_ANY(left) && l < LCP_LANES; l++) {
      if (left[l] != 0) {
        resolve(context, j, l, b, x);
      }
    }
    impulse(s, x, next);
    for (int i = 0; i < 3; i++) {
      next[i] -= p[i];
    }
    for (int i = 0; i < m; i++) {
      z[i] = x[i];
    }
    lcp_lanes_push(&c->at, s->body, &motion, next);
  }
}

BASE_CLONES void lcp_facet_kernel_push(const lcp_facet_lanes *s) {
  for (int j = 0; j < s->n_batch; j++) {
    lcp_lane_motion motion;
    lcp_v4 u[3], p[3];
    lcp_lanes_open(&s->batch[j].at, s->body, &motion, u);
    impulse(s, s->z + (ptrdiff_t)(s->facets + 2) * j, p);
    lcp_lanes_push(&s->batch[j].at, s->body, &motion, p);
  }
}
