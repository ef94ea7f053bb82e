/* solver_apgd.c - accelerated projected gradient descent with adaptive restart.
 *
 *   x = P(y - t c^2 w(y)),  y <- x + b (x - z),  z <- x
 *
 * Nesterov 1983; for contact Mazhar, Heyn, Negrut & Tasora 2015 (algorithm 1); restart where the step
 * climbs, w(y).(x - z) > 0 (O'Donoghue & Candes 2015). t is cut by backtracking on
 * d'Md <= |d|^2 / t (d = x - y) and lengthened by 1/0.9 after each step; metric c^2 = 1 / M_ii.
 * M symmetric; converges as 1/k^2 where it is positive semidefinite. */
#include "lcp/solvers/loop.h"
#include "lcp/solvers/sets.h"

#include <float.h>
#include <string.h>

typedef struct options {
  lcp_stop stop;
} options;

static const base_field fields[] = {
    LCP_LOOP_SWEEP_FIELDS(options, 1e-8, 10000),
};

typedef struct state {
  lcp_loop loop;
  double *lo, *hi; /* n */
  double *c;       /* n, 1/sqrt(M_ii) */
  double *wz;      /* n, M z + q */
  double *y, *wy;  /* n, extrapolated point and its M y + q */
  double *x, *d;   /* n, projected point; step x - y */
  double *wx;      /* n, M x + q */
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  double **const arrays[] = {&s->lo, &s->hi, &s->c, &s->wz, &s->y, &s->wy, &s->x, &s->d, &s->wx};
  for (int i = 0; i < BASE_COUNT(arrays); i++) {
    *arrays[i] = BASE_ARRAY(a, double, cap->n);
  }
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  state *s = st;
  if (!lcp_set_symmetric(p)) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "matrix: not symmetric, need a gradient");
  }
  lcp_set_intervals(p, s->lo, s->hi);
  lcp_matrix_diagonal(&p->M, s->d);
  lcp_set_scaling(&p->M, s->d, s->c);
  return BASE_OK;
}

/* x, d and wx for the accepted t. M d is a difference of residuals here, so its rounding is allowed
 * for; an update of wx by M d instead would amplify errors by 1 + b an iteration. */
static double trial(state *s, const lcp_problem *p, double t, lcp_result *res) {
  const int n = p->M.n;
  for (int k = 0;; k++) {
    double length = 0.0, curve = 0.0, noise = 0.0;
    for (int i = 0; i < n; i++) {
      s->x[i] = lcp_set_clip(s->y[i] - t * s->c[i] * (s->c[i] * s->wy[i]), s->lo[i], s->hi[i]);
      s->d[i] = s->x[i] - s->y[i];
      length += (s->d[i] / s->c[i]) * (s->d[i] / s->c[i]);
    }
    lcp_matrix_apply(&p->M, s->x, p->q, s->wx, s->loop.stop.scratch);
    res->work.matvecs++;
    for (int i = 0; i < n; i++) {
      curve += s->d[i] * (s->wx[i] - s->wy[i]);
      noise += 16.0 * DBL_EPSILON * fabs(s->d[i]) * (fabs(s->wx[i]) + fabs(s->wy[i]));
    }
    if (!(t * (curve - noise) > length) || k == 60) {
      return t;
    }
    t *= 0.5;
    res->work.linesearches++;
  }
}

static void restart(state *s, int n, const double *z, double *theta) {
  memcpy(s->y, z, (size_t)n * sizeof *z);
  memcpy(s->wy, s->wz, (size_t)n * sizeof *z);
  *theta = 1.0;
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  const int n = p->M.n;
  double t = 1.0, theta = 1.0;
  bool fresh;
  for (int i = 0; i < n; i++) {
    z[i] = lcp_set_clip(z[i], s->lo[i], s->hi[i]);
  }
  lcp_loop_begin(&s->loop, p, false);
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
    if (fresh) {
      memcpy(s->wz, s->loop.stop.w, (size_t)n * sizeof *s->wz);
    }
    if (res->work.iterations == 0) {
      restart(s, n, z, &theta);
    }
    t = trial(s, p, t, res);
    double climb = 0.0;
    for (int i = 0; i < n; i++) {
      climb += s->wy[i] * (s->x[i] - z[i]);
    }
    const double next = 0.5 * theta * (sqrt(theta * theta + 4.0) - theta);
    const double b = theta * (1.0 - theta) / (theta * theta + next);
    for (int i = 0; i < n; i++) {
      s->y[i] = s->x[i] + b * (s->x[i] - z[i]);
      s->wy[i] = s->wx[i] + b * (s->wx[i] - s->wz[i]);
      z[i] = s->x[i];
      s->wz[i] = s->wx[i];
    }
    theta = next;
    if (climb > 0.0) {
      restart(s, n, z, &theta);
      res->work.fallbacks++;
    }
    t /= 0.9;
    res->work.iterations++;
  }
  return BASE_OK;
}

const lcp_solver lcp_solver_apgd = {
    .name = "apgd",
    .title = "Accelerated projected gradient",
    .cite = "mazhar2015, algorithm 1",
    .words = "Accelerated gradient steps.",
    .when = "Large symmetric problems on which plain sweeps are slow.",
    .sets = (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .warm = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
};
