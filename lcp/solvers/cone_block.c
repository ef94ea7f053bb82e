#include "lcp/solvers/cone_block.h"

#include "lcp/solvers/cone_parts.h"

#include <string.h>

enum { ROOT_STEPS = 200 };

/* A scalar function of x with its data. */
typedef double (*curve)(double x, void *data);

/* Root in [a, b] with f(a) fa > 0 > fb at b or the reverse: Illinois regula falsi, bisection where
 * it shortens the bracket by less than half in three steps. Ends on adjacent numbers or f = 0. */
static double root(curve f, void *data, double a, double fa, double b, double fb) {
  double width = fabs(b - a);
  for (int k = 0; k < ROOT_STEPS; k++) {
    double x = (a * fb - b * fa) / (fb - fa);
    if (k % 3 == 2) {
      x = (fabs(b - a) > 0.5 * width) ? 0.5 * (a + b) : x;
      width = fabs(b - a);
    }
    if (!(x > fmin(a, b) && x < fmax(a, b))) {
      x = 0.5 * (a + b);
      if (x == a || x == b) {
        break;
      }
    }
    const double fx = f(x, data);
    if (fx == 0.0) {
      return x;
    }
    if ((fx > 0.0) == (fb > 0.0)) {
      fa *= 0.5;
    } else {
      a = b;
      fa = fb;
    }
    b = x;
    fb = fx;
    if (fabs(b - a) <= 4e-16 * fabs(b)) {
      break;
    }
  }
  return b;
}

/* y = (T + a I)^-1 x for a 1x1 or 2x2 block T at row and column `at` of A. */
static void solve_part(const double *A, int n, int at, int dim, double a, const double *x,
                       double *y) {
  const double *T = &A[at + at * n];
  if (dim == 1) {
    y[0] = x[0] / (T[0] + a);
    return;
  }
  const double p = T[0] + a, q = T[n + 1] + a, u = T[n], v = T[1];
  const double det = p * q - u * v;
  y[0] = (q * x[0] - u * x[1]) / det;
  y[1] = (p * x[1] - v * x[0]) / det;
}

/* ---- one part ----------------------------------------------------------------------------- */

typedef struct sliding {
  const double *A, *b;
  int n; /* 2 or 3 */
  double mu;
  double r[3];
} sliding;

/* |r_t| - mu r_n of the sliding branch at a; leaves r. */
static double slide(double a, void *data) {
  sliding *s = data;
  const int n = s->n, dim = n - 1;
  double f[2] = {0}, g[2] = {0}; /* (T + a)^-1 b_t, (T + a)^-1 A_tn */
  solve_part(s->A, n, 1, dim, a, s->b + 1, f);
  solve_part(s->A, n, 1, dim, a, s->A + 1, g);
  double top = s->b[0], bottom = s->A[0], size = 0.0;
  for (int i = 0; i < dim; i++) {
    top -= s->A[n + i * (ptrdiff_t)n] * f[i];
    bottom -= s->A[n + i * (ptrdiff_t)n] * g[i];
  }
  s->r[0] = -top / bottom;
  for (int i = 0; i < dim; i++) {
    s->r[1 + i] = -(f[i] + g[i] * s->r[0]);
    size += s->r[1 + i] * s->r[1 + i];
  }
  return sqrt(size) - s->mu * s->r[0];
}

static const double singular_noise = 1e-13; /* share of a diagonal that a zero is computed with */

/* A tangential block of the Schur complement of A_nn, diagonal in the axes e. */
typedef struct tangential {
  double value[2], axis[2][2]; /* largest first */
  double b[2], coupling[2];    /* b_t - A_tn b_n / A_nn and A_tn / A_nn along the axes */
  double size;                 /* of what b is a difference of */
} tangential;

static void diagonalise(const double *A, const double *b, int n, tangential *t) {
  const int dim = n - 1;
  double S[2][2] = {{0}}, off[2] = {0}, rest[2] = {0};
  *t = (tangential){.axis = {{1.0, 0.0}, {0.0, 1.0}}};
  for (int i = 0; i < dim; i++) {
    off[i] = A[1 + i] / A[0];
    rest[i] = b[1 + i] - off[i] * b[0];
    t->size = fmax(t->size, fabs(b[1 + i]) + fabs(off[i] * b[0]));
    for (int j = 0; j < dim; j++) {
      S[i][j] = A[1 + i + (1 + j) * n] - A[1 + i] * A[(1 + j) * n] / A[0];
    }
  }
  if (dim == 2) {
    const double half = 0.5 * (S[0][0] - S[1][1]), q = 0.5 * (S[0][1] + S[1][0]);
    const double angle = 0.5 * atan2(q, half);
    t->axis[0][0] = t->axis[1][1] = cos(angle);
    t->axis[0][1] = sin(angle);
    t->axis[1][0] = -t->axis[0][1];
    const double mean = 0.5 * (S[0][0] + S[1][1]), root = hypot(half, q);
    t->value[0] = mean + root;
    t->value[1] = mean - root;
  } else {
    t->value[0] = S[0][0];
  }
  for (int k = 0; k < dim; k++) {
    t->b[k] = t->axis[k][0] * rest[0] + t->axis[k][1] * rest[1];
    t->coupling[k] = t->axis[k][0] * off[0] + t->axis[k][1] * off[1];
  }
}

/* Is the Schur complement of A_nn, whose smaller value is at least det / trace, regular for sure? */
static bool is_regular(const double *A, int n, double largest) {
  const double inverse = 1.0 / A[0];
  const double first = A[1 + n] - A[1] * A[n] * inverse;
  if (n == 2) {
    return first > singular_noise * 4.0 * largest;
  }
  const double second = A[2 + 2 * n] - A[2] * A[2 * n] * inverse;
  const double off = A[2 + n] - A[2] * A[n] * inverse;
  const double back = A[1 + 2 * n] - A[1] * A[2 * n] * inverse;
  const double shared = 0.5 * (off + back);
  return first > 0.0 && second > 0.0 &&
         first * second - shared * shared > singular_noise * 4.0 * largest * (first + second);
}

/* Joints that let a contact move along one line, or in one plane, through its normal make A singular. */
typedef enum singular { REGULAR, RESTS, SLIDES } singular;

/* Rest (w = 0) of a singular A: of all r with w = 0 the one of least friction, from there along the null vector to the
 * cone. SLIDES: no such r is in the cone. */
static singular rest_of_singular(const lcp_block *k, const double *A, const double *b, double *r) {
  const double noise = singular_noise;
  const int n = k->size, dim = n - 1;
  const double mu = k->part_mu[0];
  double largest = 0.0, x[2] = {0};
  for (int i = 1; i < n; i++) {
    largest = fmax(largest, A[i + i * n]);
  }
  if (is_regular(A, n, largest)) {
    return REGULAR;
  }
  tangential t;
  diagonalise(A, b, n, &t);
  if (t.value[dim - 1] > noise * largest) {
    return REGULAR;
  }
  int null = -1;
  double normal = -b[0] / A[0];
  for (int i = 0; i < dim; i++) {
    if (t.value[i] > noise * largest) {
      x[i] = -t.b[i] / t.value[i];
      normal -= t.coupling[i] * x[i];
    } else if (fabs(t.b[i]) > noise * t.size) {
      return SLIDES; /* moves whatever r is */
    } else {
      null = i;
    }
  }
  const double friction = fabs(x[0]) + fabs(x[1]); /* at most one is not zero */
  if (friction > mu * normal) {
    /* |(friction, s)| = mu (normal + s slope) for the least s > 0 */
    const double slope = fabs(t.coupling[null]);
    const double p = 1.0 - mu * mu * slope * slope, half = mu * mu * normal * slope;
    const double rest = friction * friction - mu * mu * normal * normal;
    const double root = half * half - p * rest;
    const double s = (root >= 0.0) ? rest / (half + sqrt(root)) : -1.0;
    if (!(normal > 0.0 && s > 0.0 && s < HUGE_VAL)) {
      return SLIDES;
    }
    x[null] = (t.coupling[null] > 0.0) ? -s : s;
    normal += slope * s;
  }
  r[0] = normal;
  for (int i = 0; i < dim; i++) {
    r[1 + i] = t.axis[0][i] * x[0] + ((dim == 2) ? t.axis[1][i] * x[1] : 0.0);
  }
  return RESTS;
}

static void one_part(const lcp_block *k, const double *A, const double *b, double *r) {
  const int n = k->size;
  const singular kind = rest_of_singular(k, A, b, r);
  if (kind == RESTS) {
    return;
  }
  sliding s = {.A = A, .b = b, .n = n, .mu = k->part_mu[0]};
  double low = (kind == SLIDES) ? 1e-12 * A[0] : 0.0, at_low = slide(low, &s);
  if (!(at_low <= 0.0)) { /* not stick (NaN: no stick at all, T singular) */
    double size = A[1 + n];
    size = (n == 3) ? 0.5 * (size + A[2 + 2 * n]) : size;
    double high = (size > 0.0) ? size : A[0], at_high = slide(high, &s);
    for (int i = 0; i < 1000 && at_high > 0.0; i++) {
      low = high;
      at_low = at_high;
      high *= 4.0;
      at_high = slide(high, &s);
    }
    if (!(at_low < HUGE_VAL)) {
      low = 1e-16 * high;
      at_low = slide(low, &s);
    }
    (void)slide((at_low > 0.0) ? root(slide, &s, low, at_low, high, at_high) : low, &s);
    double length = 0.0; /* onto the cone to the last bit */
    for (int i = 1; i < n; i++) {
      length += s.r[i] * s.r[i];
    }
    length = sqrt(length);
    for (int i = 1; i < n && length > 0.0; i++) {
      s.r[i] *= s.mu * s.r[0] / length;
    }
  }
  memcpy(r, s.r, (size_t)n * sizeof *r);
}

/* ---- several parts ------------------------------------------------------------------------ */

typedef struct disc {
  const double *A, *f; /* block matrix; right-hand side of this part */
  int n, at, dim;
  double radius;
  double x[2];
} disc;

static double outside(double a, void *data) {
  disc *s = data;
  double y[2] = {0};
  solve_part(s->A, s->n, s->at, s->dim, a, s->f, y);
  s->x[0] = -y[0];
  s->x[1] = (s->dim == 2) ? -y[1] : 0.0;
  return hypot(s->x[0], s->x[1]) - s->radius;
}

/* argmin x'Tx/2 + f'x over |x| <= radius. */
static void solve_disc(disc *s) {
  double low = 0.0, at_low = outside(0.0, s);
  if (at_low <= 0.0) {
    return;
  }
  double high = s->A[s->at + s->at * s->n], at_high;
  if (!(s->radius > 0.0 && high > 0.0)) { /* what cannot move rubs where it is moved */
    const double speed = hypot(s->f[0], (s->dim == 2) ? s->f[1] : 0.0);
    for (int i = 0; i < 2; i++) {
      s->x[i] = (speed > 0.0 && i < s->dim) ? -s->radius * s->f[i] / speed : 0.0;
    }
    return;
  }
  at_high = outside(high, s);
  for (int i = 0; i < 1000 && at_high > 0.0; i++) {
    low = high;
    at_low = at_high;
    high *= 4.0;
    at_high = outside(high, s);
  }
  if (!(at_low < HUGE_VAL)) {
    low = 1e-16 * high;
    at_low = outside(low, s);
  }
  (void)outside((at_low > 0.0) ? root(outside, s, low, at_low, high, at_high) : low, s);
}

typedef struct stacked {
  const lcp_block *k;
  const double *A, *b;
  double r[LCP_CONE_MAX];
} stacked;

/* Part `part` (rows from `at`) to its optimum for the others; returns how far it moved, its size. */
static double settle_part(stacked *s, int part, int at, double *size) {
  const int n = s->k->size, dim = s->k->part_dim[part];
  double f[2] = {0}, change = 0.0;
  for (int i = 0; i < dim; i++) {
    f[i] = s->b[at + i];
    for (int j = 0; j < n; j++) {
      f[i] += (j < at || j >= at + dim) ? s->A[at + i + j * n] * s->r[j] : 0.0;
    }
  }
  disc d = {s->A, f, n, at, dim, s->k->part_mu[part] * s->r[0], {0}};
  solve_disc(&d);
  for (int i = 0; i < dim; i++) {
    change += fabs(d.x[i] - s->r[at + i]);
    *size += fabs(d.x[i]);
    s->r[at + i] = d.x[i];
  }
  return change;
}

/* Where sweeps that change r by `now`, after `before`, lead to if all go on in that ratio. The next sweep settles each part again, so that
 * this is a start and no more. */
static void leap(stacked *s, const double *before, const double *now) {
  const int n = s->k->size;
  double with = 0.0, own = 0.0;
  for (int i = 1; i < n; i++) {
    with += now[i] * before[i];
    own += before[i] * before[i];
  }
  const double ratio = (own > 0.0) ? with / own : 0.0;
  for (int i = 1; i < n && ratio > 0.0 && ratio < 1.0; i++) {
    s->r[i] += now[i] * ratio / (1.0 - ratio);
  }
}

/* w_n at a given normal impulse, tangential parts at their optimum; leaves r. */
static double normal_velocity(double rn, void *data) {
  stacked *s = data;
  const int n = s->k->size;
  double change = 1.0, size = 0.0, moved[2][LCP_CONE_MAX], from[LCP_CONE_MAX];
  s->r[0] = rn;
  for (int sweep = 0; sweep < 500 && change > 1e-15 * size; sweep++) {
    change = size = 0.0;
    memcpy(from, s->r, sizeof from);
    for (int p = 0, at = 1; p < s->k->n_part; at += s->k->part_dim[p++]) {
      change += settle_part(s, p, at, &size);
    }
    for (int i = 1; i < n; i++) {
      moved[sweep % 2][i] = s->r[i] - from[i];
    }
    if (sweep % 6 == 5 &&
        change > 1e-15 * size) { /* parts that turn each other settle by a few percent a sweep */
      leap(s, moved[0], moved[1]);
    }
  }
  double w = s->b[0];
  for (int j = 0; j < n; j++) {
    w += s->A[j * (ptrdiff_t)n] * s->r[j];
  }
  return w;
}

void lcp_cone_solve_by_brackets(const lcp_block *k, const double *A, const double *b, double *r) {
  stacked s = {.k = k, .A = A, .b = b, .r = {0}};
  double low = 0.0, at_low = b[0], high = -b[0] / A[0];
  double at_high = normal_velocity(high, &s);
  for (int i = 0; i < 1000 && at_high < 0.0; i++) {
    low = high;
    at_low = at_high;
    high *= 2.0;
    at_high = normal_velocity(high, &s);
  }
  if (at_high > 0.0) {
    (void)normal_velocity(root(normal_velocity, &s, low, at_low, high, at_high), &s);
  }
  memcpy(r, s.r, (size_t)k->size * sizeof *r);
}

void lcp_cone_solve(const lcp_block *k, const double *A, const double *b, double *r) {
  memset(r, 0, (size_t)k->size * sizeof *r);
  if (b[0] >= 0.0 || !(A[0] > 0.0)) { /* take-off; or nothing stops the approach */
    return;
  }
  if (k->n_part == 0 || (k->n_part == 1 && k->part_mu[0] == 0.0)) {
    r[0] = -b[0] / A[0];
  } else if (k->n_part == 1) {
    one_part(k, A, b, r);
  } else if (!lcp_cone_parts_newton(k, A, b, r)) {
    lcp_cone_solve_by_brackets(k, A, b, r);
  }
}
