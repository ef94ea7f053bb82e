#include "lcp/solvers/cone_map.h"

#include "lcp/solvers/facet_fold.h"

#include <string.h>

static double length(const double *v, int n) {
  return (n == 1) ? fabs(v[0]) : hypot(v[0], v[1]);
}

/* Rows at .. at+dim-1 stick: F = y. */
static void stick(int n, int at, int dim, const double *y, double *F, double *Y) {
  for (int i = at; i < at + dim; i++) {
    F[i] = y[i];
    if (Y != NULL) {
      Y[i + i * n] = 1.0;
    }
  }
}

/* Rows at .. at+dim-1 are given: F = x. */
static void vanish(int n, int at, int dim, const double *x, double *F, double *X) {
  for (int i = at; i < at + dim; i++) {
    F[i] = x[i];
    if (X != NULL) {
      X[i + i * n] = 1.0;
    }
  }
}

/* One part on the circle of radius mu p_n, p = x - y of length t outside it. */
// NOLINTNEXTLINE(readability-function-size): a part is told by nine plain values
static void slip(int n, int at, int dim, double mu, double radius, double t, const double *x,
                 const double *y, double *F, double *X, double *Y) {
  double d[2] = {0};
  for (int i = 0; i < dim; i++) {
    d[i] = (x[at + i] - y[at + i]) / t;
    F[at + i] = x[at + i] - radius * d[i];
  }
  for (int i = 0; X != NULL && i < dim; i++) {
    X[at + i] = -mu * d[i];
    Y[at + i] = mu * d[i];
    for (int j = 0; j < dim; j++) {
      const double turn = radius / t * ((i == j) - d[i] * d[j]);
      X[at + i + (at + j) * n] = (i == j) - turn;
      Y[at + i + (at + j) * n] = turn;
    }
  }
}

/* A part over the polygon of f corners mu p_n d_k, p = x - y. */
// NOLINTNEXTLINE(readability-function-size): as of slip
static void on_polygon(int n, int at, int f, double mu, double radius, const double *x,
                       const double *y, double *F, double *X, double *Y) {
  const double p[2] = {x[at] - y[at], x[at + 1] - y[at + 1]};
  double to[2], by_p[4], by_radius[2];
  if (lcp_polygon_project(f, radius, p, to, by_p, by_radius)) {
    stick(n, at, 2, y, F, Y);
    return;
  }
  for (int i = 0; i < 2; i++) {
    F[at + i] = x[at + i] - to[i];
    for (int j = 0; X != NULL && j < 2; j++) {
      X[at + i + (at + j) * n] = (i == j) - by_p[i + 2 * j];
      Y[at + i + (at + j) * n] = by_p[i + 2 * j];
    }
    if (X != NULL) {
      X[at + i] = -mu * by_radius[i];
      Y[at + i] = mu * by_radius[i];
    }
  }
}

void lcp_cone_modes(const lcp_block *b, double lo, double hi, const double *x, const double *y,
                    unsigned char *mode) {
  const double p = x[0] - y[0];
  memset(mode, LCP_MODE_LOW, (size_t)b->size);
  if (b->set != LCP_CONE) {
    mode[0] = (p <= lo) ? LCP_MODE_LOW : ((p >= hi) ? LCP_MODE_HIGH : LCP_MODE_HELD);
    return;
  }
  if (!(p > 0.0)) {
    return;
  }
  mode[0] = LCP_MODE_HELD;
  for (int k = 0, at = 1; k < b->n_part; at += b->part_dim[k++]) {
    const double v[2] = {x[at] - y[at], (b->part_dim[k] == 2) ? x[at + 1] - y[at + 1] : 0.0};
    const double radius = b->part_mu[k] * p;
    if (radius > 0.0) {
      mode[at] = (length(v, b->part_dim[k]) <= radius) ? LCP_MODE_HELD : LCP_MODE_SLIP;
    }
  }
}

static void smooth_interval(double lo, double hi, unsigned char mode, const double *x,
                            const double *y, double *F, double *X, double *Y) {
  const bool held = mode == LCP_MODE_HELD;
  F[0] = held ? y[0] : x[0] - ((mode == LCP_MODE_LOW) ? lo : hi);
  if (X != NULL) {
    X[0] = held ? 0.0 : 1.0;
    Y[0] = held ? 1.0 : 0.0;
  }
}

// NOLINTNEXTLINE(readability-function-size): as of lcp_cone_map
static void smooth_cone(const lcp_block *b, const int *facets, const unsigned char *mode,
                        const double *x, const double *y, double *F, double *X, double *Y) {
  const int n = b->size;
  if (mode[0] == LCP_MODE_LOW) {
    vanish(n, 0, n, x, F, X);
    return;
  }
  F[0] = y[0];
  if (Y != NULL) {
    Y[0] = 1.0;
  }
  for (int k = 0, at = 1; k < b->n_part; at += b->part_dim[k++]) {
    const int dim = b->part_dim[k];
    const double v[2] = {x[at] - y[at], (dim == 2) ? x[at + 1] - y[at + 1] : 0.0};
    if (mode[at] == LCP_MODE_LOW) {
      vanish(n, at, dim, x, F, X);
    } else if (facets != NULL && facets[at] > 2) {
      on_polygon(n, at, facets[at], b->part_mu[k], b->part_mu[k] * (x[0] - y[0]), x, y, F, X, Y);
    } else if (mode[at] == LCP_MODE_HELD || length(v, dim) == 0.0) {
      stick(n, at, dim, y, F, Y); /* zero is in every disc, and has no direction to slip in */
    } else {
      slip(n, at, dim, b->part_mu[k], b->part_mu[k] * (x[0] - y[0]), length(v, dim), x, y, F, X, Y);
    }
  }
}

static void clear(const lcp_block *b, double *X, double *Y) {
  const size_t bytes = (size_t)b->size * (size_t)b->size * sizeof *X;
  if (X != NULL) {
    memset(X, 0, bytes);
    memset(Y, 0, bytes);
  }
}

// NOLINTNEXTLINE(readability-function-size): a map takes its block, its point and three results
void lcp_cone_smooth(const lcp_block *b, double lo, double hi, const unsigned char *mode,
                     const double *x, const double *y, double *F, double *X, double *Y) {
  clear(b, X, Y);
  if (b->set == LCP_CONE) {
    smooth_cone(b, NULL, mode, x, y, F, X, Y);
  } else {
    smooth_interval(lo, hi, mode[0], x, y, F, X, Y);
  }
}

// NOLINTNEXTLINE(readability-function-size): as of lcp_cone_map
static void alart_curnier(const lcp_block *b, const int *facets, const double *x, const double *y,
                          double *F, double *X, double *Y) {
  unsigned char mode[LCP_CONE_MAX];
  lcp_cone_modes(b, 0.0, 0.0, x, y, mode);
  smooth_cone(b, facets, mode, x, y, F, X, Y);
}

/* out = a + L_c^-1 (...) is not formed: columns of L_c^-1 L_a, where L_v is the product with v of the algebra,
 * L_v u = (v'u, v_0 u_t + u_0 v_t). c inside the cone. */
static void quotient(int n, const double *c, const double *a, double *out) {
  double det = c[0] * c[0];
  for (int i = 1; i < n; i++) {
    det -= c[i] * c[i];
  }
  for (int j = 0; j < n; j++) {
    double r[3] = {a[j], 0.0, 0.0}; /* column j of L_a */
    for (int i = 1; i < n; i++) {
      r[i] = ((j == 0) ? a[i] : 0.0) + ((i == j) ? a[0] : 0.0);
    }
    double inner = 0.0;
    for (int i = 1; i < n; i++) {
      inner += c[i] * r[i];
    }
    const double top = (c[0] * r[0] - inner) / det;
    out[(ptrdiff_t)j * n] = top;
    for (int i = 1; i < n; i++) {
      out[i + j * n] = (r[i] - top * c[i]) / c[0];
    }
  }
}

/* c = (a^2 + b^2)^1/2, kept off the boundary by rounding so that its inverse exists. False: a = b = 0. */
static bool root_of_squares(int n, const double *a, const double *b, double *c) {
  double v[3] = {0}, t = 0.0;
  for (int i = 0; i < n; i++) {
    v[0] += a[i] * a[i] + b[i] * b[i];
    v[i] += (i > 0) ? 2.0 * (a[0] * a[i] + b[0] * b[i]) : 0.0;
  }
  for (int i = 1; i < n; i++) {
    t = hypot(t, v[i]);
  }
  if (v[0] == 0.0) {
    return false;
  }
  const double high = sqrt(v[0] + t), low = fmax(sqrt(fmax(v[0] - t, 0.0)), 1e-8 * high);
  c[0] = 0.5 * (high + low);
  for (int i = 1; i < n; i++) {
    c[i] = (t > 0.0) ? 0.5 * (high - low) * v[i] / t : 0.0;
  }
  return true;
}

static void fischer(const lcp_block *k, const double *x, const double *y, double *F, double *X,
                    double *Y) {
  const int n = k->size;
  const double mu = k->part_mu[0], root = sqrt(mu), t = length(y + 1, n - 1);
  double a[3] = {root * x[0]}, b[3] = {(y[0] + mu * t) / root}, c[3], A[9], B[9];
  for (int i = 1; i < n; i++) {
    a[i] = x[i] / root;
    b[i] = root * y[i];
  }
  const bool off = root_of_squares(n, a, b, c);
  for (int i = 0; i < n; i++) {
    F[i] = off ? a[i] + b[i] - c[i] : 0.0;
  }
  if (X == NULL) {
    return;
  }
  if (off) {
    quotient(n, c, a, A);
    quotient(n, c, b, B);
  }
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++) {
      const double unit = (i == j), least = sqrt(0.5) * unit; /* at the origin */
      X[i + j * n] = (unit - (off ? A[i + j * n] : least)) * ((j == 0) ? root : 1.0 / root);
      B[i + j * n] = unit - (off ? B[i + j * n] : least);
    }
  }
  for (int i = 0; i < n; i++) {
    Y[i] = B[i] / root;
    for (int j = 1; j < n; j++) {
      Y[i + j * n] = root * (B[i + j * n] + ((t > 0.0) ? B[i] * y[j] / t : 0.0));
    }
  }
}

// NOLINTNEXTLINE(readability-function-size): a map takes its block, its point and three results
void lcp_cone_map(lcp_map map, const lcp_block *b, const int *facets, double lo, double hi,
                  const double *x, const double *y, double *F, double *X, double *Y) {
  clear(b, X, Y);
  if (b->set != LCP_CONE) {
    double dx, dy;
    F[0] = lcp_interval_map(map, lo, hi, x[0], y[0], &dx, &dy);
    if (X != NULL) {
      /* a tie is an open row, as of a cone: what neither carries nor parts stays out of the system */
      const bool tie = map == LCP_MAP_MIN && y[0] == 0.0 && (x[0] == lo || x[0] == hi);
      X[0] = tie ? 1.0 : dx;
      Y[0] = tie ? 0.0 : dy;
    }
  } else if (map == LCP_MAP_FISCHER && b->n_part == 1 && b->part_mu[0] > 0.0 && facets == NULL) {
    fischer(b, x, y, F, X, Y);
  } else {
    alart_curnier(b, facets, x, y, F, X, Y);
  }
}
