#include "lcp/solvers/cone_parts.h"

#include <float.h>
#include <lapacke.h>
#include <string.h>

enum { NEWTON_STEPS = 60, HALVINGS = 8 };

static const double rounding = 16.0 * DBL_EPSILON;

/* A state of the steps. */
typedef struct stage {
  double r[LCP_CONE_MAX];
  double F[LCP_CONE_MAX];                /* the functions, in the units of r */
  double J[LCP_CONE_MAX * LCP_CONE_MAX]; /* their derivatives, column-major */
  double worst; /* the largest of them over what it is known to [1]; 1 and less: rounding */
} stage;

/* x over what it is known to; HUGE_VAL where there is no such number. */
static double over(double x, double known) {
  const double ratio = (x == 0.0) ? 0.0 : fabs(x) / known;
  return (ratio < HUGE_VAL) ? ratio : HUGE_VAL;
}

/* What w_i, and all that it is the sum of, come to. */
static double row(const lcp_block *k, const double *A, const double *b, const double *r, int i,
                  double *size) {
  double w = b[i];
  *size = fabs(b[i]);
  for (int j = 0; j < k->size; j++) {
    w += A[i + j * k->size] * r[j];
    *size += fabs(A[i + j * k->size] * r[j]);
  }
  return w;
}

/* Function i is w_i over a: with its derivatives. */
static void rests(const lcp_block *k, const double *A, double a, int i, double w, double size,
                  stage *s) {
  s->F[i] = w / a;
  s->worst = fmax(s->worst, over(w, rounding * size));
  for (int j = 0; j < k->size; j++) {
    s->J[i + j * k->size] = A[i + j * k->size] / a;
  }
}

/* The functions of a part that takes all of its friction: r - radius u / |u|, with u = r - w / a. */
static void slips(const lcp_block *k, const double *A, double a, int part, int at, const double *u,
                  double known, stage *s) {
  const int n = k->size, dim = k->part_dim[part];
  const double length = (dim == 2) ? hypot(u[0], u[1]) : fabs(u[0]);
  const double mu = k->part_mu[part], radius = mu * s->r[0];
  for (int i = 0; i < dim; i++) {
    const double along = (length > 0.0) ? u[i] / length : 0.0;
    s->F[at + i] = s->r[at + i] - radius * along;
    s->worst = fmax(s->worst, over(s->F[at + i], rounding * fmax(radius, DBL_MIN) * known));
    for (int j = 0; j < n; j++) {
      double turn = 0.0; /* of u / |u| with r_j, times the radius */
      for (int l = 0; l < dim && radius > 0.0; l++) {
        const double across = ((i == l) ? 1.0 : 0.0) - along * u[l] / length;
        turn += radius / length * across * (((at + l == j) ? 1.0 : 0.0) - A[at + l + j * n] / a);
      }
      s->J[at + i + j * n] = ((at + i == j) ? 1.0 : 0.0) - turn;
    }
    s->J[at + i] -= mu * along;
  }
}

static double largest_diagonal(const lcp_block *k, const double *A, int part, int at) {
  double a = 0.0;
  for (int i = at; i < at + k->part_dim[part]; i++) {
    a = fmax(a, A[i + i * k->size]);
  }
  return a;
}

/* The functions at s->r. */
static void look(const lcp_block *k, const double *A, const double *b, stage *s) {
  double size[2];
  s->worst = 0.0;
  const double w_n = row(k, A, b, s->r, 0, size);
  rests(k, A, A[0], 0, w_n, *size, s);
  for (int part = 0, at = 1; part < k->n_part; at += k->part_dim[part++]) {
    const double a = largest_diagonal(k, A, part, at);
    double w[2] = {0}, u[2] = {0}, length = 0.0, all = 0.0;
    for (int i = 0; i < k->part_dim[part]; i++) {
      w[i] = row(k, A, b, s->r, at + i, &size[i]);
      u[i] = s->r[at + i] - w[i] / a;
      length = hypot(length, u[i]);
      all = fmax(all, size[i] / a);
    }
    if (length > k->part_mu[part] * s->r[0] || k->part_mu[part] == 0.0) {
      /* its direction is known as u is */
      slips(k, A, a, part, at, u, fmax(1.0, all / fmax(length, DBL_MIN)), s);
      continue;
    }
    for (int i = 0; i < k->part_dim[part]; i++) {
      rests(k, A, a, at + i, w[i], size[i], s);
    }
  }
}

/* The parts that take all of their friction end on the cone to the last bit, and the others in it. */
static void onto_the_cone(const lcp_block *k, double *r) {
  for (int part = 0, at = 1; part < k->n_part; at += k->part_dim[part++]) {
    const double radius = k->part_mu[part] * r[0];
    const double length = (k->part_dim[part] == 2) ? hypot(r[at], r[at + 1]) : fabs(r[at]);
    const double share =
        (length >= radius * (1.0 - rounding) && length > 0.0) ? radius / length : 1.0;
    for (int i = at; i < at + k->part_dim[part]; i++) {
      r[i] *= share;
    }
  }
}

/* The step of Newton's method from s, into `step`. */
static bool newton_step(const lcp_block *k, const stage *s, double *step) {
  double J[LCP_CONE_MAX * LCP_CONE_MAX];
  lapack_int swap[LCP_CONE_MAX];
  const int n = k->size;
  memcpy(J, s->J, (size_t)(n * n) * sizeof *J);
  memcpy(step, s->F, (size_t)n * sizeof *step);
  return LAPACKE_dgesv_work(LAPACK_COL_MAJOR, n, 1, J, n, swap, step, n) == 0;
}

/* A part without friction takes nothing: rounding of the other rows must not say otherwise. */
static void without_friction(const lcp_block *k, double *r) {
  for (int part = 0, at = 1; part < k->n_part; at += k->part_dim[part++]) {
    for (int i = at; i < at + k->part_dim[part] && k->part_mu[part] == 0.0; i++) {
      r[i] = 0.0;
    }
  }
}

/* Is what rounding leaves of every row small against the data, in the units of the diagonal? Along a null vector of A r grows until any w is
 * rounding. */
static bool is_known(const lcp_block *k, const double *A, const double *b, const double *r) {
  static const double small = 1e-10;
  double data = 0.0;
  double noise = 0.0;
  for (int i = 0; i < k->size; i++) {
    double size;
    (void)row(k, A, b, r, i, &size);
    const double unit = sqrt(A[i + i * k->size]);
    data = fmax(data, fabs(b[i]) / unit);
    noise = fmax(noise, over(rounding * size, unit));
  }
  return noise <= small * data;
}

/* The longest of the halves of the step that brings the functions nearer to zero, the last where none does; the normal impulse stays positive. */
static void go(const lcp_block *k, const double *A, const double *b, const double *step,
               const stage *from, stage *to) {
  double share = (step[0] > 0.0) ? fmin(1.0, 0.9 * from->r[0] / step[0]) : 1.0;
  for (int half = 0; half <= HALVINGS; half++) {
    for (int i = 0; i < k->size; i++) {
      to->r[i] = from->r[i] - share * step[i];
    }
    without_friction(k, to->r);
    look(k, A, b, to);
    if (to->worst < from->worst) {
      return;
    }
    share *= 0.5;
  }
}

bool lcp_cone_parts_newton(const lcp_block *k, const double *A, const double *b, double *r) {
  stage stages[2] = {{.r = {-b[0] / A[0]}}};
  for (int part = 0, at = 1; part < k->n_part; at += k->part_dim[part++]) {
    if (!(largest_diagonal(k, A, part, at) > 0.0)) {
      return false;
    }
  }
  stage *now = &stages[0], *next = &stages[1];
  look(k, A, b, now);
  for (int i = 0; i < NEWTON_STEPS && now->worst > 1.0; i++) {
    double step[LCP_CONE_MAX];
    if (!newton_step(k, now, step)) {
      return false;
    }
    go(k, A, b, step, now, next);
    stage *before = now;
    now = next;
    next = before;
  }
  if (!(now->worst <= 1.0) || !is_known(k, A, b, now->r)) {
    return false;
  }
  memcpy(r, now->r, (size_t)k->size * sizeof *r);
  onto_the_cone(k, r);
  return true;
}
