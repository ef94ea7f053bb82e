#include "lcp/solvers/contact_sweep_kernel.h"

#include "lcp/base/clones.h"

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

#define LOAD(body, k, part)                                                                        \
  (*(const lcp_v4 *)(const void *)((body) + 16 * (size_t)(k) + 4 * (size_t)(part)))
#define STORE(body, k, part) (*(lcp_v4 *)(void *)((body) + 16 * (size_t)(k) + 4 * (size_t)(part)))

#define GATHER(x, body, index, part)                                                               \
  do {                                                                                             \
    for (int lane = 0; lane < LCP_LANES; lane++) {                                                 \
      (x)[lane] = LOAD(body, (index)[lane], part);                                                 \
    }                                                                                              \
    TRANSPOSE(x);                                                                                  \
  } while (0)
#define SCATTER(x, body, index, part)                                                              \
  do {                                                                                             \
    TRANSPOSE(x);                                                                                  \
    for (int lane = 0; lane < LCP_LANES; lane++) {                                                 \
      STORE(body, (index)[lane], part) = (x)[lane];                                                \
    }                                                                                              \
  } while (0)

/* Lanes of a where the mask is set, else of b. */
#define CHOOSE(mask, a, b) ((lcp_v4)(((mask) & (lcp_m4)(a)) | (~(mask) & (lcp_m4)(b))))

/* (a x b)_i, and component i of the symmetric matrix (xx xy xz yy yz zz) times c. */
#define CROSS(a, b, i)                                                                             \
  ((a)[((i) + 1) % 3] * (b)[((i) + 2) % 3] - (a)[((i) + 2) % 3] * (b)[((i) + 1) % 3])
#define DOT(a, b) ((a)[0] * (b)[0] + ((a)[1] * (b)[1] + (a)[2] * (b)[2]))
#define TURN(m, c, i)                                                                              \
  (((i) == 0)   ? (m)[0] * (c)[0] + ((m)[1] * (c)[1] + (m)[2] * (c)[2])                            \
   : ((i) == 1) ? (m)[1] * (c)[0] + ((m)[3] * (c)[1] + (m)[4] * (c)[2])                            \
                : (m)[2] * (c)[0] + ((m)[4] * (c)[1] + (m)[5] * (c)[2]))

/* NOLINTNEXTLINE(readability-function-size,readability-function-cognitive-complexity): one kernel */
BASE_CLONES void lcp_contact_kernel_full(lcp_contact_batch *batch, int count, double *body,
                                         double omega) {
  const lcp_v4 zero = {0, 0, 0, 0};
  for (int k = 0; k < count; k++) {
    lcp_contact_batch *c = &batch[k];
    lcp_v4 v[2][4], o[2][4], y[3], t[3][3], dx[3], push[3];
    for (int s = 0; s < 2; s++) {
      GATHER(v[s], body, c->body[s], 0);
      GATHER(o[s], body, c->body[s], 1);
    }
    for (int i = 0; i < 3; i++) {
      t[0][i] = c->t[0][i];
      t[1][i] = c->t[1][i];
      t[2][i] = c->third * CROSS(c->t[0], c->t[1], i);
      y[i] = (v[0][i] - v[1][i]) + (CROSS(o[0], c->arm[0], i) - CROSS(o[1], c->arm[1], i));
    }
    for (int r = 0; r < 3; r++) {
      lcp_v4 w = c->q[r] + DOT(t[r], y);
      if (r == 1) {
        w += c->A[0] * dx[0];
      } else if (r == 2) {
        w += c->A[1] * dx[0] + c->A[2] * dx[1];
      }
      lcp_v4 x = c->x[r] - omega * w;
      if (r == 0) {
        x = CHOOSE(x > zero, x, zero);
      } else {
        const lcp_v4 hi = c->bound[r - 1], lo = -hi;
        x = CHOOSE(x > lo, x, lo);
        x = CHOOSE(x < hi, x, hi);
      }
      dx[r] = x - c->x[r];
      c->x[r] = x;
    }
    for (int i = 0; i < 3; i++) {
      push[i] = t[0][i] * dx[0] + (t[1][i] * dx[1] + t[2][i] * dx[2]);
    }
    for (int s = 0; s < 2; s++) {
      lcp_v4 m[8], turn[3];
      GATHER(m, body, c->body[s], 2);
      GATHER(m + 4, body, c->body[s], 3);
      for (int i = 0; i < 3; i++) {
        turn[i] = CROSS(c->arm[s], push, i);
      }
      for (int i = 0; i < 3; i++) {
        const lcp_v4 dv = v[s][3] * push[i], spin = TURN(m, turn, i);
        v[s][i] = (s == 0) ? v[s][i] + dv : v[s][i] - dv;
        o[s][i] = (s == 0) ? o[s][i] + spin : o[s][i] - spin;
      }
      SCATTER(v[s], body, c->body[s], 0);
      SCATTER(o[s], body, c->body[s], 1);
    }
  }
}

/* ---- one lane, the same arithmetic in the same order ---------------------------------------- */

typedef struct lane {
  double t[3][3], arm[2][3];
  double *b[2]; /* bodies */
} lane;

static void open_lane(lane *g, const lcp_contact_batch *c, int l, double *body) {
  for (int i = 0; i < 3; i++) {
    g->t[0][i] = c->t[0][i][l];
    g->t[1][i] = c->t[1][i][l];
    g->arm[0][i] = c->arm[0][i][l];
    g->arm[1][i] = c->arm[1][i][l];
  }
  for (int i = 0; i < 3; i++) {
    g->t[2][i] = c->third[l] * CROSS(g->t[0], g->t[1], i);
  }
  g->b[0] = body + 16 * (size_t)c->body[0][l];
  g->b[1] = body + 16 * (size_t)c->body[1][l];
}

/* Impulses dx (scaled) on both bodies. */
static void push_lane(const lane *g, const double *dx) {
  double push[3], turn[3];
  for (int i = 0; i < 3; i++) {
    push[i] = g->t[0][i] * dx[0] + (g->t[1][i] * dx[1] + g->t[2][i] * dx[2]);
  }
  for (int s = 0; s < 2; s++) {
    double *b = g->b[s];
    for (int i = 0; i < 3; i++) {
      turn[i] = CROSS(g->arm[s], push, i);
    }
    for (int i = 0; i < 3; i++) {
      const double dv = b[3] * push[i], spin = TURN(b + 8, turn, i);
      b[i] = (s == 0) ? b[i] + dv : b[i] - dv;
      b[4 + i] = (s == 0) ? b[4 + i] + spin : b[4 + i] - spin;
    }
  }
}

static void one(lcp_contact_batch *c, int l, double *body, double omega) {
  lane g;
  open_lane(&g, c, l, body);
  double y[3], dx[3];
  for (int i = 0; i < 3; i++) {
    y[i] =
        (g.b[0][i] - g.b[1][i]) + (CROSS(g.b[0] + 4, g.arm[0], i) - CROSS(g.b[1] + 4, g.arm[1], i));
  }
  for (int r = 0; r < 3; r++) {
    double w = c->q[r][l] + DOT(g.t[r], y);
    if (r == 1) {
      w += c->A[0][l] * dx[0];
    } else if (r == 2) {
      w += c->A[1][l] * dx[0] + c->A[2][l] * dx[1];
    }
    double x = c->x[r][l] - omega * w;
    if (r == 0) {
      x = (x > 0.0) ? x : 0.0;
    } else {
      const double hi = c->bound[r - 1][l];
      x = (x > -hi) ? x : -hi;
      x = (x < hi) ? x : hi;
    }
    dx[r] = x - c->x[r][l];
    c->x[r][l] = x;
  }
  push_lane(&g, dx);
}

void lcp_contact_kernel_serial(lcp_contact_batch *batch, int count, double *body, double omega) {
  for (int k = 0; k < count; k++) {
    one(&batch[k / LCP_LANES], k % LCP_LANES, body, omega);
  }
}

void lcp_contact_kernel_push(const lcp_contact_batch *batch, int count, double *body) {
  for (int k = 0; k < count; k++) {
    const lcp_contact_batch *c = &batch[k / LCP_LANES];
    const int l = k % LCP_LANES;
    const double x[3] = {c->x[0][l], c->x[1][l], c->x[2][l]};
    lane g;
    open_lane(&g, c, l, body);
    push_lane(&g, x);
  }
}
