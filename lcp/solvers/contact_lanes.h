/* contact_lanes.h - four contacts between rigid bodies side by side: their frames, the velocities of their points, the
 * impulses on their bodies. For the kernels of the matrix-free sweeps (contact_sweep.h, cone_batches.h, facet_batches.h).
 *
 *   y = v_a + o_a x r_a - v_b - o_b x r_b,   u_k = t_k.y
 *   p = sum t_k p_k,   v_a += p / m_a,   o_a += inertia_a^-1 (r_a x p),   b likewise with -p */
#pragma once

#include <stddef.h>

typedef double lcp_v4 __attribute__((vector_size(32)));
typedef long long lcp_m4 __attribute__((vector_size(32)));

enum { LCP_LANES = 4 };

#define LCP_LANES_INLINE static inline __attribute__((always_inline))

/* [row][component][lane] */
typedef struct lcp_lane_frame {
  lcp_v4 t[2][3];   /* directions of the first two rows */
  lcp_v4 third;     /* t_2 = third (t_0 x t_1) */
  lcp_v4 arm[2][3]; /* from the bodies to the point [m] */
  int body[2][4];   /* the number of bodies where fixed */
} lcp_lane_frame;

typedef struct lcp_lane_motion {
  lcp_v4 v[2][4], o[2][4]; /* velocity and 1/m, angular velocity, of both bodies */
  lcp_v4 t[3][3];
} lcp_lane_motion;

/* Rows x0..x3 to columns, in place. */
#define LCP_TRANSPOSE(x)                                                                           \
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

/* Part 0..3 of four bodies, 16 numbers each (contact_batches.h). */
#define LCP_GATHER(x, body, index, part)                                                           \
  do {                                                                                             \
    for (int lane = 0; lane < LCP_LANES; lane++) {                                                 \
      (x)[lane] = *(const lcp_v4 *)(const void *)((body) + 16 * (size_t)(index)[lane] +            \
                                                  4 * (size_t)(part));                             \
    }                                                                                              \
    LCP_TRANSPOSE(x);                                                                              \
  } while (0)
#define LCP_SCATTER(x, body, index, part)                                                          \
  do {                                                                                             \
    LCP_TRANSPOSE(x);                                                                              \
    for (int lane = 0; lane < LCP_LANES; lane++) {                                                 \
      *(lcp_v4 *)(void *)((body) + 16 * (size_t)(index)[lane] + 4 * (size_t)(part)) = (x)[lane];   \
    }                                                                                              \
  } while (0)

/* Lanes of a where the mask is set, else of b. */
#define LCP_CHOOSE(mask, a, b) ((lcp_v4)(((mask) & (lcp_m4)(a)) | (~(mask) & (lcp_m4)(b))))
#define LCP_SIZE(x)            LCP_CHOOSE((x) < 0.0, -(x), (x))
#define LCP_ANY(mask)          (((mask)[0] | (mask)[1] | (mask)[2] | (mask)[3]) != 0)

/* (a x b)_i, and component i of the symmetric matrix (xx xy xz yy yz zz) times c. */
#define LCP_CROSS(a, b, i)                                                                         \
  ((a)[((i) + 1) % 3] * (b)[((i) + 2) % 3] - (a)[((i) + 2) % 3] * (b)[((i) + 1) % 3])
#define LCP_DOT(a, b) ((a)[0] * (b)[0] + ((a)[1] * (b)[1] + (a)[2] * (b)[2]))
#define LCP_TURN(m, c, i)                                                                          \
  (((i) == 0)   ? (m)[0] * (c)[0] + ((m)[1] * (c)[1] + (m)[2] * (c)[2])                            \
   : ((i) == 1) ? (m)[1] * (c)[0] + ((m)[3] * (c)[1] + (m)[4] * (c)[2])                            \
                : (m)[2] * (c)[0] + ((m)[4] * (c)[1] + (m)[5] * (c)[2]))

/* u[3]: velocities along the rows. */
LCP_LANES_INLINE void lcp_lanes_open(const lcp_lane_frame *at, const double *body,
                                     lcp_lane_motion *m, lcp_v4 *u) {
  lcp_v4 y[3];
  for (int s = 0; s < 2; s++) {
    LCP_GATHER(m->v[s], body, at->body[s], 0);
    LCP_GATHER(m->o[s], body, at->body[s], 1);
  }
  for (int i = 0; i < 3; i++) {
    m->t[0][i] = at->t[0][i];
    m->t[1][i] = at->t[1][i];
    m->t[2][i] = at->third * LCP_CROSS(at->t[0], at->t[1], i);
    y[i] = (m->v[0][i] - m->v[1][i]) +
           (LCP_CROSS(m->o[0], at->arm[0], i) - LCP_CROSS(m->o[1], at->arm[1], i));
  }
  for (int r = 0; r < 3; r++) {
    u[r] = LCP_DOT(m->t[r], y);
  }
}

/* Impulses p[3] along the rows, on the bodies that were opened. */
LCP_LANES_INLINE void lcp_lanes_push(const lcp_lane_frame *at, double *body, lcp_lane_motion *m,
                                     const lcp_v4 *p) {
  lcp_v4 push[3];
  for (int i = 0; i < 3; i++) {
    push[i] = m->t[0][i] * p[0] + (m->t[1][i] * p[1] + m->t[2][i] * p[2]);
  }
  for (int s = 0; s < 2; s++) {
    lcp_v4 inertia[8], turn[3];
    LCP_GATHER(inertia, body, at->body[s], 2);
    LCP_GATHER(inertia + 4, body, at->body[s], 3);
    for (int i = 0; i < 3; i++) {
      turn[i] = LCP_CROSS(at->arm[s], push, i);
    }
    for (int i = 0; i < 3; i++) {
      const lcp_v4 dv = m->v[s][3] * push[i], spin = LCP_TURN(inertia, turn, i);
      m->v[s][i] = (s == 0) ? m->v[s][i] + dv : m->v[s][i] - dv;
      m->o[s][i] = (s == 0) ? m->o[s][i] + spin : m->o[s][i] - spin;
    }
    LCP_SCATTER(m->v[s], body, at->body[s], 0);
    LCP_SCATTER(m->o[s], body, at->body[s], 1);
  }
}
