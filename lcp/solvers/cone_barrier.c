#include "lcp/solvers/cone_barrier.h"

#include <string.h>

enum { SOC = 3 }; /* rows of the largest second-order cone */
static const double narrowest = 1e-20;

void lcp_barrier_layout(lcp_barrier *b, const lcp_capacity *cap, base_arena *a) {
  double **const arrays[] = {&b->x, &b->y, &b->t, &b->dx, &b->dy, &b->dt, &b->g, &b->gt, &b->r};
  for (int i = 0; i < BASE_COUNT(arrays); i++) {
    *arrays[i] = BASE_ARRAY(a, double, cap->n);
  }
  b->nt = BASE_ARRAY(a, lcp_nt, cap->n);
}

/* ---- the second-order cone ------------------------------------------------------------------ */

/* a'J b. */
static double minkowski(int n, const double *a, const double *b) {
  double sum = a[0] * b[0];
  for (int i = 1; i < n; i++) {
    sum -= a[i] * b[i];
  }
  return sum;
}

/* a'J a of a point inside, where it is nearly zero as a product of small factors. */
static double square(int n, const double *a) {
  const double length = (n == 2) ? fabs(a[1]) : hypot(a[1], a[2]);
  return (a[0] - length) * (a[0] + length);
}

static lcp_nt scaling(int n, const double *a, const double *b) {
  lcp_nt s = {0};
  const double aa = sqrt(square(n, a)), bb = sqrt(square(n, b));
  double inner = 0.0;
  for (int i = 0; i < n; i++) {
    inner += (a[i] / aa) * (b[i] / bb);
  }
  const double gamma = sqrt(0.5 * (1.0 + inner));
  for (int i = 0; i < n; i++) {
    s.w[i] = 0.5 / gamma * (b[i] / bb + ((i == 0) ? a[i] : -a[i]) / aa);
  }
  s.root = sqrt(bb / aa);
  return s;
}

/* to = W v, with `inverse` W^-1 v. */
static void scale(int n, const lcp_nt *s, bool inverse, const double *v, double *to) {
  double inner = 0.0, w[SOC];
  for (int i = 1; i < n; i++) {
    w[i] = inverse ? -s->w[i] : s->w[i];
    inner += w[i] * v[i];
  }
  const double r = inverse ? 1.0 / s->root : s->root, top = v[0];
  for (int i = 1; i < n; i++) {
    to[i] = r * (v[i] + (top + inner / (1.0 + s->w[0])) * w[i]);
  }
  to[0] = r * (s->w[0] * top + inner);
}

/* Entry i, j of H. */
static double metric(const lcp_nt *s, int i, int j) {
  const double J = (i == j) ? ((i == 0) ? 1.0 : -1.0) : 0.0;
  return s->root * s->root * (2.0 * s->w[i] * s->w[j] - J);
}

/* to of l o to = v. */
static void divide(int n, const double *l, const double *v, double *to) {
  double inner = 0.0;
  for (int i = 1; i < n; i++) {
    inner += l[i] * v[i];
  }
  const double top = (l[0] * v[0] - inner) / square(n, l);
  for (int i = 1; i < n; i++) {
    to[i] = (v[i] - top * l[i]) / l[0];
  }
  to[0] = top;
}

/* g of db = g - H da: tau a^-1 - b - W (l \ (W da o W^-1 db)), l = W a; da NULL: without the last. */
// NOLINTNEXTLINE(readability-function-size): a pair, its scaling and its directions
static void target(int n, const lcp_nt *s, double tau, const double *a, const double *b,
                   const double *da, const double *db, double *g) {
  const double aa = square(n, a);
  for (int i = 0; i < n; i++) {
    g[i] = tau * ((i == 0) ? a[i] : -a[i]) / aa - b[i];
  }
  if (da == NULL) {
    return;
  }
  double l[SOC], u[SOC], v[SOC] = {0}, product[SOC] = {0};
  scale(n, s, false, a, l);
  scale(n, s, false, da, u);
  scale(n, s, true, db, v);
  for (int i = 0; i < n; i++) {
    product[0] += u[i] * v[i];
    product[i] = (i > 0) ? u[0] * v[i] + v[0] * u[i] : product[0];
  }
  divide(n, l, product, u);
  scale(n, s, false, u, v);
  for (int i = 0; i < n; i++) {
    g[i] -= v[i];
  }
}

/* The longest step from a, inside, along da. */
static double reach(int n, const double *a, const double *da) {
  const double quad = minkowski(n, da, da), half = minkowski(n, a, da), free = square(n, a);
  const double disc = half * half - quad * free;
  const double root = (disc >= 0.0) ? sqrt(disc) - half : 0.0; /* quad t^2 + 2 half t + free = 0 */
  return (root > 0.0) ? free / root : HUGE_VAL;
}

/* ---- pieces --------------------------------------------------------------------------------- */

static bool has_friction(const lcp_block *p) {
  for (int k = 0; k < p->n_part; k++) {
    if (p->part_mu[k] > 0.0) {
      return true;
    }
  }
  return false;
}

/* Is the normal row of a cone a pair of its own? */
static bool paired(const lcp_barrier *b, const lcp_block *p) {
  return b->law == LCP_LAW_COULOMB || !has_friction(p);
}

static double length_of(int dim, const double *v) {
  return (dim == 1) ? fabs(v[0]) : hypot(v[0], v[1]);
}

/* a = (mu x_n, x_k) and b = (t_k, y_k) of the part at row `at`, from x, y, t or from their directions. */
static void pair_of(const lcp_block *p, int k, int at, const double *x, const double *y,
                    const double *t, double *a, double *b) {
  a[0] = p->part_mu[k] * x[p->start];
  b[0] = t[at];
  for (int i = 0; i < p->part_dim[k]; i++) {
    a[i + 1] = x[at + i];
    b[i + 1] = y[at + i];
  }
}

static void start_cone(lcp_barrier *b, const lcp_block *p, double size) {
  b->x[p->start] = size;
  b->y[p->start] = size;
  b->pairs += paired(b, p);
  for (int k = 0, at = p->start + 1; k < p->n_part; at += p->part_dim[k++]) {
    for (int i = at; i < at + p->part_dim[k]; i++) {
      b->x[i] = b->y[i] = 0.0;
    }
    b->t[at] = size;
    b->pairs += p->part_mu[k] > 0.0;
  }
}

/* An interval that rounding does not tell from a point. */
static bool pinned(const lcp_barrier *b, const lcp_cone_scaled *c, int i) {
  return c->hi[i] - c->lo[i] <= b->point;
}

static void start_interval(lcp_barrier *b, const lcp_cone_scaled *c, int i, double size) {
  const double lo = c->lo[i], hi = c->hi[i];
  const bool low = lo > -HUGE_VAL, high = hi < HUGE_VAL;
  if (low && high) {
    b->x[i] = fmin(lo + size, 0.5 * (lo + hi));
  } else {
    b->x[i] = low ? lo + size : (high ? hi - size : 0.0);
  }
  const bool fixed = pinned(b, c, i);
  /* a narrow interval has the same products as the others, else no step from here keeps near the path */
  const double other = (low && high && !fixed) ? size * (size / (b->x[i] - lo)) : size;
  b->y[i] = (low && !fixed) ? other : 0.0;
  b->t[i] = (high && !fixed) ? other : 0.0;
  b->pairs += fixed ? 0 : low + high;
}

void lcp_barrier_start(lcp_barrier *b, const lcp_cone_scaled *c, lcp_law law, double size) {
  b->law = law;
  b->point = narrowest * size;
  b->pairs = 0;
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *p = &c->piece[k];
    double *const none[] = {b->t, b->dx, b->dy, b->dt};
    for (int i = 0; i < BASE_COUNT(none); i++) {
      memset(none[i] + p->start, 0, (size_t)p->size * sizeof *b->t);
    }
    if (p->set == LCP_CONE) {
      start_cone(b, p, size);
    } else {
      start_interval(b, c, p->start, size);
    }
  }
}

double lcp_barrier_residual(lcp_barrier *b, const lcp_cone_scaled *c, const double *w) {
  double worst = 0.0;
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *p = &c->piece[k];
    const int n = p->start;
    if (p->set == LCP_CONE && !paired(b, p)) {
      b->y[n] = 0.0;
      for (int j = 0, at = n + 1; j < p->n_part; at += p->part_dim[j++]) {
        b->y[n] += p->part_mu[j] * (b->t[at] - length_of(p->part_dim[j], b->y + at));
      }
    }
    for (int i = n; i < n + p->size; i++) {
      b->r[i] = w[i] - b->y[i] + ((p->set == LCP_CONE) ? 0.0 : b->t[i]);
    }
    if (p->set == LCP_CONE) {
      for (int j = 0, at = n + 1; j < p->n_part; at += p->part_dim[j++]) {
        for (int i = at; i < at + p->part_dim[j] && !(p->part_mu[j] > 0.0); i++) {
          b->r[i] = 0.0;
        }
      }
    } else if (pinned(b, c, n)) {
      b->r[n] = 0.0;
    }
    for (int i = n; i < n + p->size; i++) {
      worst = fmax(worst, fabs(b->r[i]));
    }
  }
  return worst;
}

double lcp_barrier_gap(const lcp_barrier *b, const lcp_cone_scaled *c, double step) {
  double sum = 0.0;
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *p = &c->piece[k];
    const int n = p->start;
    const double x = b->x[n] + step * b->dx[n], y = b->y[n] + step * b->dy[n];
    if (p->set != LCP_CONE) {
      const double t = b->t[n] + step * b->dt[n];
      sum += (y != 0.0) ? (x - c->lo[n]) * y : 0.0;
      sum += (t != 0.0) ? (c->hi[n] - x) * t : 0.0;
      continue;
    }
    sum += paired(b, p) ? x * y : 0.0;
    for (int j = 0, at = n + 1; j < p->n_part; at += p->part_dim[j++]) {
      if (p->part_mu[j] > 0.0) {
        sum += p->part_mu[j] * x * (b->t[at] + step * b->dt[at]);
        for (int i = at; i < at + p->part_dim[j]; i++) {
          sum += (b->x[i] + step * b->dx[i]) * (b->y[i] + step * b->dy[i]);
        }
      }
    }
  }
  return (b->pairs > 0) ? sum / b->pairs : 0.0;
}

/* The direction of a part's velocity, zero where it rests: the derivative of |y_k|. */
static void heading(int dim, const double *y, double *d) {
  const double length = length_of(dim, y);
  for (int i = 0; i < dim; i++) {
    d[i] = (length > 0.0) ? y[i] / length : 0.0;
  }
}

static void linearise_part(lcp_barrier *b, const lcp_block *p, int k, int at, double *X,
                           double *Y) {
  const int m = p->size, dim = p->part_dim[k], row = at - p->start;
  const double mu = p->part_mu[k];
  if (!(mu > 0.0)) {
    for (int i = row; i < row + dim; i++) {
      X[i + i * m] = 1.0;
    }
    return;
  }
  double a[SOC] = {0}, v[SOC] = {0}, d[SOC] = {0};
  pair_of(p, k, at, b->x, b->y, b->t, a, v);
  b->nt[at] = scaling(dim + 1, a, v);
  const lcp_nt *s = &b->nt[at];
  heading(dim, b->y + at, d);
  for (int i = 0; i < dim; i++) {
    Y[(row + i) * (m + 1)] = 1.0;
    X[row + i] = metric(s, i + 1, 0) * mu;
    for (int j = 0; j < dim; j++) {
      X[row + i + (row + j) * m] = metric(s, i + 1, j + 1);
    }
  }
  for (int j = 0; j <= dim && !paired(b, p); j++) {
    double sum = metric(s, 0, j);
    for (int i = 0; i < dim; i++) {
      sum -= d[i] * metric(s, i + 1, j);
    }
    X[(j == 0) ? 0 : (row + j - 1) * m] += mu * sum * ((j == 0) ? mu : 1.0);
  }
}

/* X and Y of one piece with X at most 1 on the diagonal, and Y[0] what they were multiplied by (0: the row is fixed): that of an
 * open contact grows without bound, which a direct solver takes for a singular matrix. */
static void even_out(int m, double *X, double *Y) {
  double top = 1.0;
  for (int i = 0; i < m; i++) {
    top = fmax(top, X[i * (m + 1)]);
  }
  for (int i = 0; i < m * m; i++) {
    X[i] /= top;
    Y[i] /= top;
  }
}

void lcp_barrier_linearise(lcp_barrier *b, lcp_cone_scaled *c) {
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *p = &c->piece[k];
    const int n = p->start;
    double *X = c->X + lcp_cone_scaled_at(c, p), *Y = c->Y + lcp_cone_scaled_at(c, p);
    const size_t bytes = (size_t)p->size * (size_t)p->size * sizeof *X;
    memset(X, 0, bytes);
    memset(Y, 0, bytes);
    Y[0] = 1.0;
    if (p->set == LCP_CONE) {
      X[0] = paired(b, p) ? b->y[n] / b->x[n] : 0.0;
      for (int j = 0, at = n + 1; j < p->n_part; at += p->part_dim[j++]) {
        linearise_part(b, p, j, at, X, Y);
      }
    } else if (pinned(b, c, n)) {
      X[0] = 1.0;
      Y[0] = 0.0;
    } else {
      X[0] += (c->lo[n] > -HUGE_VAL) ? b->y[n] / (b->x[n] - c->lo[n]) : 0.0;
      X[0] += (c->hi[n] < HUGE_VAL) ? b->t[n] / (c->hi[n] - b->x[n]) : 0.0;
    }
    even_out(p->size, X, Y);
  }
}

/* g and gt of the part at row `at`, and what the normal row has of it. */
static void target_part(lcp_barrier *b, const lcp_block *p, int k, int at, double tau,
                        bool corrected) {
  const int dim = p->part_dim[k];
  if (!(p->part_mu[k] > 0.0)) {
    memset(b->g + at, 0, (size_t)dim * sizeof *b->g);
    return;
  }
  double a[SOC] = {0}, v[SOC] = {0}, da[SOC] = {0}, dv[SOC] = {0}, g[SOC] = {0}, d[SOC] = {0};
  pair_of(p, k, at, b->x, b->y, b->t, a, v);
  pair_of(p, k, at, b->dx, b->dy, b->dt, da, dv);
  target(dim + 1, &b->nt[at], tau, a, v, corrected ? da : NULL, dv, g);
  heading(dim, b->y + at, d);
  b->gt[at] = g[0];
  double share = g[0];
  for (int i = 0; i < dim; i++) {
    b->g[at + i] = g[i + 1];
    share -= d[i] * g[i + 1];
  }
  b->g[p->start] += paired(b, p) ? 0.0 : p->part_mu[k] * share;
}

void lcp_barrier_target(lcp_barrier *b, lcp_cone_scaled *c, double tau, bool corrected) {
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *p = &c->piece[k];
    const int n = p->start;
    const double *Y = c->Y + lcp_cone_scaled_at(c, p);
    const double cross = corrected ? b->dx[n] * b->dy[n] : 0.0;
    if (p->set == LCP_CONE) {
      b->g[n] = paired(b, p) ? (tau - cross) / b->x[n] - b->y[n] : 0.0;
      for (int j = 0, at = n + 1; j < p->n_part; at += p->part_dim[j++]) {
        target_part(b, p, j, at, tau, corrected);
      }
      for (int i = n; i < n + p->size; i++) {
        c->F[i] = Y[0] * (b->r[i] - b->g[i]);
      }
      continue;
    }
    b->g[n] = b->gt[n] = 0.0;
    if (b->y[n] != 0.0) {
      b->g[n] = (tau - cross) / (b->x[n] - c->lo[n]) - b->y[n];
    }
    if (b->t[n] != 0.0) {
      const double other = corrected ? b->dx[n] * b->dt[n] : 0.0;
      b->gt[n] = (tau + other) / (c->hi[n] - b->x[n]) - b->t[n];
    }
    c->F[n] = Y[0] * (b->r[n] - b->g[n] + b->gt[n]);
  }
}

static void directions_cone(lcp_barrier *b, const lcp_cone_scaled *c, const lcp_block *p) {
  const size_t at_block = lcp_cone_scaled_at(c, p);
  const double *X = c->X + at_block, unit = c->Y[at_block], *dx = b->dx + p->start;
  for (int i = 0; i < p->size; i++) {
    double sum = 0.0;
    for (int j = 0; j < p->size; j++) {
      sum += X[i + j * p->size] * dx[j];
    }
    b->dy[p->start + i] = b->g[p->start + i] - sum / unit;
  }
  for (int k = 0, at = p->start + 1; k < p->n_part; at += p->part_dim[k++]) {
    const lcp_nt *s = &b->nt[at];
    if (!(p->part_mu[k] > 0.0)) {
      memset(b->dy + at, 0, (size_t)p->part_dim[k] * sizeof *b->dy);
      continue;
    }
    b->dt[at] = b->gt[at] - metric(s, 0, 0) * p->part_mu[k] * dx[0];
    for (int i = 0; i < p->part_dim[k]; i++) {
      b->dt[at] -= metric(s, 0, i + 1) * b->dx[at + i];
    }
  }
}

void lcp_barrier_directions(lcp_barrier *b, const lcp_cone_scaled *c) {
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *p = &c->piece[k];
    const int n = p->start;
    if (p->set == LCP_CONE) {
      directions_cone(b, c, p);
      continue;
    }
    b->dy[n] = b->dt[n] = 0.0;
    if (b->y[n] != 0.0) {
      b->dy[n] = b->g[n] - b->y[n] / (b->x[n] - c->lo[n]) * b->dx[n];
    }
    if (b->t[n] != 0.0) {
      b->dt[n] = b->gt[n] + b->t[n] / (c->hi[n] - b->x[n]) * b->dx[n];
    }
  }
}

/* The longest step that keeps a positive. */
static double along(double a, double da) {
  return (da < 0.0) ? -a / da : HUGE_VAL;
}

double lcp_barrier_longest(const lcp_barrier *b, const lcp_cone_scaled *c) {
  double t = HUGE_VAL;
  for (int k = 0; k < c->n_piece; k++) {
    const lcp_block *p = &c->piece[k];
    const int n = p->start;
    if (p->set != LCP_CONE) {
      if (b->y[n] != 0.0) {
        t = fmin(t, fmin(along(b->x[n] - c->lo[n], b->dx[n]), along(b->y[n], b->dy[n])));
      }
      if (b->t[n] != 0.0) {
        t = fmin(t, fmin(along(c->hi[n] - b->x[n], -b->dx[n]), along(b->t[n], b->dt[n])));
      }
      continue;
    }
    if (paired(b, p)) {
      t = fmin(t, fmin(along(b->x[n], b->dx[n]), along(b->y[n], b->dy[n])));
    }
    for (int j = 0, at = n + 1; j < p->n_part; at += p->part_dim[j++]) {
      if (p->part_mu[j] > 0.0) {
        double a[SOC] = {0}, v[SOC] = {0}, da[SOC] = {0}, dv[SOC] = {0};
        pair_of(p, j, at, b->x, b->y, b->t, a, v);
        pair_of(p, j, at, b->dx, b->dy, b->dt, da, dv);
        t = fmin(t, fmin(reach(p->part_dim[j] + 1, a, da), reach(p->part_dim[j] + 1, v, dv)));
      }
    }
  }
  return t;
}

void lcp_barrier_move(lcp_barrier *b, int n, double step) {
  for (int i = 0; i < n; i++) {
    b->x[i] += step * b->dx[i];
    b->y[i] += step * b->dy[i];
    b->t[i] += step * b->dt[i];
  }
}
