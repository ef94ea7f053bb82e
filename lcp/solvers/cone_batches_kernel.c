#include "lcp/solvers/cone_batches_kernel.h"

#include "lcp/base/clones.h"
#include "lcp/solvers/cone_block.h"

enum { NEWTON_STEPS = 12 };

/* One contact of the lanes by the bracketing solver, in the axes of S. */
static __attribute__((noinline)) void solve_alone(const lcp_cone_batch *k, int l, double rho,
                                                  const double c[2], double *x) {
  const double An = 1.0 / k->inverse[l], g[2] = {k->slope[0][l], k->slope[1][l]};
  const double off = An * g[0] * g[1];
  const double A[9] = {An,
                       An * g[0],
                       An * g[1],
                       An * g[0],
                       k->stiff[0][l] + An * g[0] * g[0],
                       off,
                       An * g[1],
                       off,
                       k->stiff[1][l] + An * g[1] * g[1]};
  const double bn = -rho * An, b[3] = {bn, c[0] + g[0] * bn, c[1] + g[1] * bn};
  const lcp_block block = {
      .size = 3, .set = LCP_CONE, .n_part = 1, .part_dim = {2}, .part_mu = {k->mu[l]}};
  lcp_cone_solve(&block, A, b, x);
}

/* The lanes that slide into x; c and rho = *normal as in the header. Newton's step in a from |y| - mu n = 0,
 * |y| - m = (|y|^2 - m^2) / (|y| + m) with m = mu n, where 2 m (|y|^2 - m^2) / (|y|^2 + 3 m^2) stands for it: the same to
 * third order, without a root. */
LCP_LANES_INLINE void slide(lcp_cone_batch *k, const lcp_v4 *c, const lcp_v4 *normal,
                            const lcp_m4 *sliding, lcp_v4 *x) {
  const lcp_v4 rho = *normal;
  const lcp_m4 slides = *sliding;
  const lcp_v4 zero = {0, 0, 0, 0}, one = zero + 1.0, *g = k->slope, *s = k->stiff;
  const lcp_v4 size0 = LCP_SIZE(c[0]), size1 = LCP_SIZE(c[1]);
  const lcp_v4 larger = LCP_CHOOSE(size0 > size1, size0, size1);
  const lcp_v4 smaller = LCP_CHOOSE(size0 > size1, size1, size0);
  const lcp_v4 fresh = ((0.96 * larger + 0.4 * smaller) / k->mu - (g[0] * c[0] + g[1] * c[1])) /
                           LCP_CHOOSE(slides, rho, one) -
                       0.5 * (s[0] + s[1]); /* the root for a multiple of the identity, nearly */
  lcp_v4 a = LCP_CHOOSE(k->slip > zero, k->slip, LCP_CHOOSE(fresh > zero, fresh, zero));
  lcp_v4 y[2] = {zero, zero}, n = zero;
  lcp_m4 open = slides;
  for (int i = 0; i < NEWTON_STEPS && LCP_ANY(open); i++) {
    const lcp_v4 p = s[0] + a, r = s[1] + a, inverse = one / (p * r);
    const lcp_v4 e[2] = {inverse * r, inverse * p};
    y[0] = -c[0] * e[0];
    y[1] = -c[1] * e[1];
    n = rho - (g[0] * y[0] + g[1] * y[1]);
    const lcp_v4 m = k->mu * n, square = y[0] * y[0] + y[1] * y[1];
    const lcp_v4 ye[2] = {y[0] * e[0], y[1] * e[1]};
    const lcp_v4 slope = (g[0] * ye[0] + g[1] * ye[1]) * square + n * (y[0] * ye[0] + y[1] * ye[1]);
    const lcp_v4 step =
        (square - m * m) * (m + m) * square / ((square + 3.0 * (m * m)) * (k->mu * slope));
    const lcp_v4 next = a + step;
    const lcp_m4 there = LCP_SIZE(step) <= 1e-8 * (a + s[1]);
    for (int j = 0; j < 2; j++) { /* y at the next a, to second order in the step */
      y[j] = y[j] - ye[j] * step;
    }
    a = LCP_CHOOSE(there, next, LCP_CHOOSE(next > zero, next, zero));
    open &= ~there;
  }
  n = rho - (g[0] * y[0] + g[1] * y[1]);
  const lcp_m4 good = slides & ~open & (a >= zero) & (n > zero);
  const lcp_m4 alone = slides & ~good;
  k->slip = LCP_CHOOSE(good, a, zero);
  x[0] = LCP_CHOOSE(slides, n, x[0]);
  x[1] = LCP_CHOOSE(slides, y[0], x[1]);
  x[2] = LCP_CHOOSE(slides, y[1], x[2]);
  for (int l = 0; LCP_ANY(alone) && l < LCP_LANES; l++) {
    if (alone[l] != 0) {
      double one_x[3];
      solve_alone(k, l, rho[l], (const double[2]){c[0][l], c[1][l]}, one_x);
      for (int i = 0; i < 3; i++) {
        x[i][l] = one_x[i];
      }
    }
  }
}

BASE_CLONES void lcp_cone_kernel_sweep(lcp_cone_batch *batch, int count, double *body,
                                       double omega) {
  const lcp_v4 zero = {0, 0, 0, 0};
  for (int b = 0; b < count; b++) {
    lcp_cone_batch *k = &batch[b];
    const lcp_v4 *g = k->slope;
    lcp_lane_motion motion;
    lcp_v4 w[3], c[2], x[3], dr[3];
    lcp_lanes_open(&k->at, body, &motion, w);
    for (int i = 0; i < 3; i++) {
      w[i] += k->q[i];
    }
    const lcp_v4 rho = (k->r[0] - w[0] * k->inverse) + (g[0] * k->r[1] + g[1] * k->r[2]);
    for (int i = 0; i < 2; i++) {
      c[i] = (w[1 + i] - g[i] * w[0]) - k->stiff[i] * k->r[1 + i];
      x[1 + i] = -c[i] * k->soft[i];
    }
    x[0] = rho - (g[0] * x[1] + g[1] * x[2]);
    const lcp_v4 limit = k->mu * x[0];
    const lcp_m4 touches = rho > zero;
    const lcp_m4 sticks = (x[1] * x[1] + x[2] * x[2] <= limit * limit) & (x[0] >= zero);
    const lcp_m4 slides = touches & ~sticks;
    if (LCP_ANY(slides)) {
      slide(k, c, &rho, &slides, x);
    }
    for (int i = 0; i < 3; i++) {
      x[i] = LCP_CHOOSE(touches, x[i], zero);
      dr[i] = omega * (x[i] - k->r[i]);
      k->r[i] = (omega == 1.0) ? x[i] : k->r[i] + dr[i];
    }
    lcp_lanes_push(&k->at, body, &motion, dr);
  }
}

BASE_CLONES void lcp_cone_kernel_push(const lcp_cone_batch *batch, int count, double *body) {
  for (int b = 0; b < count; b++) {
    lcp_lane_motion motion;
    lcp_v4 u[3];
    lcp_lanes_open(&batch[b].at, body, &motion, u);
    lcp_lanes_push(&batch[b].at, body, &motion, batch[b].r);
  }
}
