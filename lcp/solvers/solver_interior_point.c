/* solver_interior_point.c - infeasible primal-dual interior point with Mehrotra's corrector.
 *
 *   (M + Y/X) dx = -(M x + q - y) + c/x,   dy = c/x - (Y/X) dx
 *   predictor  c = -x y;    corrector  c = -x y - dx_p dy_p + sigma mu,  sigma = (mu_p / mu)^3
 *
 * Wright 1997, chapter 8; Mehrotra 1992, in the variables z / s, s w (s_i^2 M_ii = 1); x = y = max|s q|
 * to start with; the same step length for both, 0.9 to 0.9999 of the way to the boundary. Free rows
 * have no y and no barrier. For monotone problems (z'Mz >= 0), elsewhere it may fail and says so.
 *
 * The iterates are interior, so what is zero in the answer comes out tiny. An accepted point is
 * therefore purified: rows with x < y are set to zero, the others solve w = 0 once; kept where that
 * passes the test too. Dense LU or KLU. */
#include "lcp/linear/direct.h"
#include "lcp/solvers/loop.h"
#include "lcp/solvers/sets.h"

#include <string.h>

typedef struct options {
  lcp_stop stop;
} options;

static const base_field fields[] = {
    LCP_STOP_FIELDS(options, 1e-10, 200),
};

typedef struct state {
  lcp_loop loop;
  lcp_direct direct;
  double *lo, *hi;        /* n */
  double *s;              /* n, scaling */
  double *x, *y;          /* n, z / s; slack (0 on free rows) */
  double *r;              /* n, M x + q - y, scaled */
  double *ratio;          /* n, y / x; 0 on free rows */
  double *dx, *dy;        /* n */
  double *c;              /* n, complementarity target */
  double *t;              /* n, s / sqrt(1 + y/x): evens out the rows of the linear system */
  double *a;              /* n, its diagonal part */
  unsigned char *barrier; /* n: an orthant row */
  int m;                  /* orthant rows */
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  lcp_direct_layout(&s->direct, cap, a);
  double **const arrays[] = {&s->lo,    &s->hi, &s->s,  &s->x, &s->y, &s->r,
                             &s->ratio, &s->dx, &s->dy, &s->c, &s->t, &s->a};
  for (int i = 0; i < BASE_COUNT(arrays); i++) {
    *arrays[i] = BASE_ARRAY(a, double, cap->n);
  }
  s->barrier = BASE_ARRAY(a, unsigned char, cap->n);
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt, (void)err;
  state *s = st;
  lcp_direct_begin(&s->direct);
  lcp_matrix_diagonal(&p->M, s->dx);
  lcp_set_scaling(&p->M, s->dx, s->s);
  lcp_set_intervals(p, s->lo, s->hi);
  return BASE_OK;
}

/* dx, dy for the target c by the factorisation at hand. */
static void step_to(state *s, int n, lcp_result *res) {
  for (int i = 0; i < n; i++) {
    s->dx[i] = -s->r[i] + (s->barrier[i] ? s->c[i] / s->x[i] : 0.0);
  }
  for (int i = 0; i < n; i++) {
    s->dx[i] *= s->t[i] / s->s[i];
  }
  lcp_direct_solve(&s->direct, n, s->dx);
  res->work.backsolves++;
  for (int i = 0; i < n; i++) {
    s->dx[i] *= s->t[i] / s->s[i];
  }
  for (int i = 0; i < n; i++) {
    s->dy[i] = s->barrier[i] ? s->c[i] / s->x[i] - s->ratio[i] * s->dx[i] : 0.0;
  }
}

/* Largest step, at most `top`, that keeps x and y nonnegative. */
static double longest(const state *s, int n, double top) {
  double t = top;
  for (int i = 0; i < n; i++) {
    if (s->barrier[i]) {
      t = (s->dx[i] < 0.0) ? fmin(t, -s->x[i] / s->dx[i]) : t;
      t = (s->dy[i] < 0.0) ? fmin(t, -s->y[i] / s->dy[i]) : t;
    }
  }
  return t;
}

static double gap(const state *s, int n, double t) {
  double sum = 0.0;
  for (int i = 0; i < n; i++) {
    sum += s->barrier[i] ? (s->x[i] + t * s->dx[i]) * (s->y[i] + t * s->dy[i]) : 0.0;
  }
  return (s->m > 0) ? sum / s->m : 0.0;
}

/* One predictor-corrector step. False: no step left, outcome set (BASE status apart). */
static bool advance(state *s, const lcp_problem *p, lcp_result *res, base_status *status) {
  const int n = p->M.n;
  for (int i = 0; i < n; i++) {
    s->ratio[i] = s->barrier[i] ? s->y[i] / s->x[i] : 0.0;
    s->c[i] = -s->x[i] * s->y[i];
    s->dx[i] = s->dy[i] = 0.0;
    s->t[i] = s->s[i] / sqrt(1.0 + s->ratio[i]);
    s->a[i] = s->ratio[i] / (1.0 + s->ratio[i]);
  }
  const double mu = gap(s, n, 0.0);
  res->work.factorizations++;
  if (!lcp_direct_factor(&s->direct, &p->M, NULL, s->a, s->t, s->t, status)) {
    res->outcome = LCP_NUMERICAL;
    return false;
  }
  step_to(s, n, res);
  const double ahead = gap(s, n, longest(s, n, 1.0)) / mu;
  const double sigma = (s->m > 0) ? ahead * ahead * ahead : 0.0;
  for (int i = 0; i < n; i++) {
    s->c[i] += sigma * mu - s->dx[i] * s->dy[i];
  }
  step_to(s, n, res);
  const double reach = longest(s, n, 1e300); /* never taken whole: x y = 0 has no next step */
  const double t = fmin(1.0, fmax(0.9, 1.0 - fmax(1e-6, 0.1 * fmin(1.0, ahead))) * reach);
  if (!(t > 1e-10)) {
    res->outcome = (t == t) ? LCP_STALLED : LCP_NUMERICAL;
    return false;
  }
  for (int i = 0; i < n; i++) {
    s->x[i] += t * s->dx[i];
    s->y[i] += t * s->dy[i];
  }
  return true;
}

/* z on its complementary basis, if that passes the test too. */
static base_status purify(state *s, const options *o, const lcp_problem *p, double *z,
                          lcp_result *res) {
  const int n = p->M.n;
  base_status status = BASE_OK;
  lcp_result again = *res;
  unsigned char *member = s->barrier; /* not needed any more */
  for (int i = 0; i < n; i++) {
    member[i] = (unsigned char)(s->barrier[i] == 0 || s->x[i] > s->y[i]);
    s->dx[i] = member[i] ? z[i] : 0.0;
  }
  lcp_matrix_apply(&p->M, s->dx, p->q, s->r, s->loop.stop.scratch);
  again.work.matvecs++;
  again.work.factorizations++;
  if (!lcp_direct_factor(&s->direct, &p->M, member, NULL, s->s, s->s, &status)) {
    return status;
  }
  for (int i = 0; i < n; i++) {
    s->dy[i] = -s->s[i] * s->r[i];
  }
  lcp_direct_solve(&s->direct, n, s->dy);
  again.work.backsolves++;
  for (int i = 0; i < n; i++) {
    const double x = s->dx[i] + (member[i] ? s->s[i] * s->dy[i] : 0.0);
    s->dx[i] = (s->lo[i] == 0.0) ? fmax(0.0, x) : x;
  }
  const lcp_stop now = {o->stop.tol, o->stop.max_iter, 1, o->stop.max_seconds};
  if (lcp_loop_ended(&s->loop, &now, p, s->dx, NULL, &again, NULL) && again.outcome == LCP_SOLVED) {
    memcpy(z, s->dx, (size_t)n * sizeof *z);
    *res = again;
  }
  return BASE_OK;
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  const int n = p->M.n;
  base_status status = BASE_OK;
  bool fresh, started = false;
  s->m = 0;
  for (int i = 0; i < n; i++) {
    s->barrier[i] = s->lo[i] == 0.0;
    s->m += s->barrier[i];
  }
  lcp_loop_begin(&s->loop, p, false);
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
    double *w = s->loop.stop.w;
    for (int i = 0; !started && i < n; i++) {
      s->x[i] = s->barrier[i] ? s->loop.q_size : 0.0;
      s->y[i] = s->x[i];
      z[i] = s->s[i] * s->x[i];
    }
    if (!fresh || !started) {
      lcp_matrix_apply(&p->M, z, p->q, w, s->loop.stop.scratch);
      res->work.matvecs++;
    }
    started = true;
    for (int i = 0; i < n; i++) {
      s->r[i] = s->s[i] * w[i] - s->y[i];
    }
    if (!advance(s, p, res, &status)) {
      return status;
    }
    for (int i = 0; i < n; i++) {
      z[i] = s->s[i] * s->x[i];
    }
    res->work.iterations++;
  }
  return (res->outcome == LCP_SOLVED && started) ? purify(s, o, p, z, res) : BASE_OK;
}

static void release(void *st) {
  lcp_direct_release(&((state *)st)->direct);
}

const lcp_solver lcp_solver_interior_point = {
    .name = "interior_point",
    .title = "Interior point (Mehrotra)",
    .cite = "mehrotra1992; wright1997, chapter 8",
    .words = "Follows a path through the interior of the feasible set.",
    .when = "Redundant contacts and large problems without a start.",
    .sets = (1u << LCP_ORTHANT) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC),
    .newton = true,
    .allocates = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
    .release = release,
};
