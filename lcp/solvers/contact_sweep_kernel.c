#include "lcp/solvers/contact_sweep_kernel.h"

/* Compiled for AVX-512, AVX2 and the baseline and chosen at load time; without contraction into fused
 * multiply-adds all of them give the same bits. */
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__)
#define CLONES __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define CLONES
#endif

/* Rows x0..x3 to columns, in place. */
#define TRANSPOSE(x)                                                                               \
  do {                                                                                             \
    const lcp_v4 p0 = __builtin_shufflevector((x)[0], (x)[1], 0, 4, 2, 6);                         \
    const lcp_v4 p1 = __builtin_shufflevector((x)[0], (x)[1], 1, 5, 3, 7);                         \
    const lcp_v4 p2 = __builtin_shufflevector((x)[2], (x)[3], 0, 4, 2, 6);                         \
    const lcp_v4 p3 = __builtin_shufflevector((x)[2], (x)[3], 1, 5, 3, 7);                         \
    (x)[0] = __builtin_shufflevector(p0, p2, 0, 1, 4, 5);                                          \
    (x)[1] = __builtin_shufflevector(p1, p3, 0, 1, 4, 5);                                          \
    (x)[2] = __builtin_shufflevector(p0, p2, 2, 3, 6, 7);                                          \
    (x)[3] = __builtin_shufflevector(p1, p3, 2, 3, 6, 7);                                          \
  } while (0)

#define LOAD(body, k, half)  (*(const lcp_v4 *)(const void *)((body) + 8 * (size_t)(k) + 4 * (half)))
#define STORE(body, k, half) (*(lcp_v4 *)(void *)((body) + 8 * (size_t)(k) + 4 * (half)))

#define GATHER(x, body, index, half)                                                               \
  do {                                                                                             \
    for (int lane = 0; lane < LCP_LANES; lane++) {                                                 \
      (x)[lane] = LOAD(body, (index)[lane], half);                                                 \
    }                                                                                              \
    TRANSPOSE(x);                                                                                  \
  } while (0)
#define SCATTER(x, body, index, half)                                                              \
  do {                                                                                             \
    TRANSPOSE(x);                                                                                  \
    for (int lane = 0; lane < LCP_LANES; lane++) {                                                 \
      STORE(body, (index)[lane], half) = (x)[lane];                                                \
    }                                                                                              \
  } while (0)

/* Lanes of a where the mask is set, else of b. */
#define CHOOSE(mask, a, b) ((lcp_v4)(((mask) & (lcp_m4)(a)) | (~(mask) & (lcp_m4)(b))))

CLONES void lcp_contact_kernel_full(lcp_contact_batch *batch, int count, double *body,
                                    double omega) {
  const lcp_v4 zero = {0, 0, 0, 0};
  for (int k = 0; k < count; k++) {
    lcp_contact_batch *c = &batch[k];
    lcp_v4 ua[4], ub[4], oa[4], ob[4]; /* columns: three components, then s (half 0) or 0 */
    GATHER(ua, body, c->a, 0);
    GATHER(oa, body, c->a, 1);
    GATHER(ub, body, c->b, 0);
    GATHER(ob, body, c->b, 1);
    const lcp_v4 sum = ua[3] * ua[3] + ub[3] * ub[3];
    lcp_v4 y[3], push[3] = {zero, zero, zero};
    for (int i = 0; i < 3; i++) {
      y[i] = ua[3] * ua[i] - ub[3] * ub[i];
    }
    for (int r = 0; r < 3; r++) {
      const lcp_v4 *t = c->t[r], *ga = c->ga[r], *gb = c->gb[r];
      const lcp_v4 w = (c->q[r] + t[0] * y[0]) + (t[1] * y[1] + t[2] * y[2]) +
                       ((ga[0] * oa[0] + ga[1] * oa[1]) + (ga[2] * oa[2] + gb[0] * ob[0]) +
                        (gb[1] * ob[1] + gb[2] * ob[2]));
      lcp_v4 x = c->z[r] - omega * w;
      if (r == 0) {
        x = CHOOSE(x > zero, x, zero);
      } else {
        const lcp_v4 hi = c->bound[r - 1], lo = -hi;
        x = CHOOSE(x > lo, x, lo);
        x = CHOOSE(x < hi, x, hi);
      }
      const lcp_v4 dz = x - c->z[r];
      c->z[r] = x;
      const lcp_v4 dy = sum * dz;
      for (int i = 0; i < 3; i++) {
        push[i] += t[i] * dz;
        y[i] += t[i] * dy;
        oa[i] += ga[i] * dz;
        ob[i] += gb[i] * dz;
      }
    }
    for (int i = 0; i < 3; i++) {
      ua[i] += ua[3] * push[i];
      ub[i] -= ub[3] * push[i];
    }
    SCATTER(ua, body, c->a, 0);
    SCATTER(oa, body, c->a, 1);
    SCATTER(ub, body, c->b, 0);
    SCATTER(ob, body, c->b, 1);
  }
}

/* The same arithmetic in the same order for one lane. */
static void one(lcp_contact_batch *c, int l, double *body, double omega) {
  double *ua = body + 8 * (size_t)c->a[l], *ub = body + 8 * (size_t)c->b[l];
  double *oa = ua + 4, *ob = ub + 4;
  const double sa = ua[3], sb = ub[3], sum = sa * sa + sb * sb;
  double y[3], push[3] = {0};
  for (int i = 0; i < 3; i++) {
    y[i] = sa * ua[i] - sb * ub[i];
  }
  for (int r = 0; r < 3; r++) {
    const lcp_v4 *t = c->t[r], *ga = c->ga[r], *gb = c->gb[r];
    const double w =
        (c->q[r][l] + t[0][l] * y[0]) + (t[1][l] * y[1] + t[2][l] * y[2]) +
        ((ga[0][l] * oa[0] + ga[1][l] * oa[1]) + (ga[2][l] * oa[2] + gb[0][l] * ob[0]) +
         (gb[1][l] * ob[1] + gb[2][l] * ob[2]));
    double x = c->z[r][l] - omega * w;
    if (r == 0) {
      x = (x > 0.0) ? x : 0.0;
    } else {
      const double hi = c->bound[r - 1][l];
      x = (x > -hi) ? x : -hi;
      x = (x < hi) ? x : hi;
    }
    const double dz = x - c->z[r][l], dy = sum * dz;
    c->z[r][l] = x;
    for (int i = 0; i < 3; i++) {
      push[i] += t[i][l] * dz;
      y[i] += t[i][l] * dy;
      oa[i] += ga[i][l] * dz;
      ob[i] += gb[i][l] * dz;
    }
  }
  for (int i = 0; i < 3; i++) {
    ua[i] += sa * push[i];
    ub[i] -= sb * push[i];
  }
}

void lcp_contact_kernel_serial(lcp_contact_batch *batch, int count, double *body, double omega) {
  for (int k = 0; k < count; k++) {
    one(&batch[k / LCP_LANES], k % LCP_LANES, body, omega);
  }
}
