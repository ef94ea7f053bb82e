/* solver_projected_gradient.c - projections along the gradient, or along the field where there is
 * no gradient. The result says in `variant` which ran.
 *
 * M symmetric: the LCP is the optimality condition of min z'Mz/2 + q'z over K.
 *   "spg"  spectral projected gradient (Birgin, Martinez & Raydan 2000, algorithm SPG2):
 *          d = P(z - a c^2 w) - z,  a = |d|^2 / d'Md in the metric 1/c^2,  nonmonotone line search
 *          over the last 50 values; on a quadratic it costs no product of its own.
 * M nonsymmetric: no gradient exists; the monotone LCP is a variational inequality.
 *   "extragradient"  self-adaptive projection and contraction (Khobotov 1987; He & Liao 2002):
 *          x = P(z - b c r w(z)),  b cut until b |r (w(z) - w(x))| <= 0.9 |(z - x) / c|,
 *          e = (z - x)/c - b r (w(z) - w(x)),  z <- P(z - 1.8 a b c r w(x)),
 *          a = (z - x)/c . e / |e|^2
 *
 * Metric: c = r = 1/sqrt(M_ii), which makes the iterates independent of the units of the rows.
 * Departure: a nonsymmetric M of no declared definiteness gets row and column factors of its own
 * (equilibrate.h), since no monotonicity is there to be kept. */
#include "lcp/solvers/equilibrate.h"
#include "lcp/solvers/loop.h"
#include "lcp/solvers/sets.h"

#include <string.h>

enum { MEMORY = 50 }; /* 10 in the paper; that cuts the long steps stiff stacks live on */

typedef struct options {
  lcp_stop stop;
} options;

static const base_field fields[] = {
    LCP_LOOP_SWEEP_FIELDS(options, 1e-8, 10000),
};

typedef struct state {
  lcp_loop loop;
  double *lo, *hi;  /* n */
  double *d;        /* n, diagonal */
  double *r, *c;    /* n, row and column factors */
  double *w;        /* n, M z + q */
  double *x, *step; /* n, trial point; step */
  double *v;        /* n, M step, or M x + q */
  bool symmetric;
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  double **const arrays[] = {&s->lo, &s->hi, &s->d, &s->r, &s->c, &s->w, &s->x, &s->step, &s->v};
  for (int i = 0; i < BASE_COUNT(arrays); i++) {
    *arrays[i] = BASE_ARRAY(a, double, cap->n);
  }
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt, (void)err;
  state *s = st;
  s->symmetric = lcp_set_symmetric(p);
  lcp_set_intervals(p, s->lo, s->hi);
  lcp_matrix_diagonal(&p->M, s->d);
  const unsigned definite = LCP_PSD | LCP_PD | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  if (s->symmetric || (p->traits & definite) != 0) {
    lcp_set_scaling(&p->M, s->d, s->c);
    memcpy(s->r, s->c, (size_t)p->M.n * sizeof *s->r);
  } else {
    lcp_equilibrate(&p->M, s->d, s->r, s->c);
  }
  return BASE_OK;
}

/* out = P(z - a c r w) */
static void project(const state *s, int n, const double *z, double a, const double *w,
                    double *out) {
  for (int i = 0; i < n; i++) {
    out[i] = lcp_set_clip(z[i] - a * s->c[i] * (s->r[i] * w[i]), s->lo[i], s->hi[i]);
  }
}

/* Largest step along d that keeps the sufficient decrease of the nonmonotone search:
 * f + t slope + t^2 curve/2 <= top + 1e-4 t slope. */
static double search(double f, double top, double slope, double curve, lcp_result *res) {
  double t = 1.0;
  for (int k = 0; k < 60 && f + t * slope + 0.5 * t * t * curve > top + 1e-4 * t * slope; k++) {
    const double best = -slope / curve; /* curve > 0 here: otherwise t = 1 was accepted */
    t = (best > 0.1 * t && best < 0.9 * t) ? best : 0.5 * t;
    res->work.linesearches++;
  }
  return t;
}

static void spg(state *s, const options *o, const lcp_problem *p, lcp_trace *trace, double *z,
                lcp_result *res) {
  const int n = p->M.n;
  double past[MEMORY], a = 1.0;
  long seen = 0;
  bool fresh;
  lcp_loop_begin(&s->loop, p, false);
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
    if (fresh) {
      memcpy(s->w, s->loop.stop.w, (size_t)n * sizeof *s->w);
    }
    project(s, n, z, a, s->w, s->x);
    double f = 0.0, slope = 0.0, length = 0.0, curve = 0.0;
    for (int i = 0; i < n; i++) {
      s->step[i] = s->x[i] - z[i];
      f += 0.5 * z[i] * (s->w[i] + p->q[i]);
      slope += s->w[i] * s->step[i];
      length += (s->step[i] / s->c[i]) * (s->step[i] / s->r[i]);
    }
    if (length == 0.0 || !(slope < 0.0)) { /* stationary to the last bit */
      lcp_loop_stationary(&s->loop, &o->stop, p, z, trace, res);
      return;
    }
    lcp_matrix_apply(&p->M, s->step, NULL, s->v, s->loop.stop.scratch);
    res->work.matvecs++;
    for (int i = 0; i < n; i++) {
      curve += s->step[i] * s->v[i];
    }
    past[seen++ % MEMORY] = f;
    double top = f;
    for (long i = 0; i < seen && i < MEMORY; i++) {
      top = fmax(top, past[i]);
    }
    const double t = search(f, top, slope, curve, res);
    for (int i = 0; i < n; i++) {
      z[i] = lcp_set_clip(z[i] + t * s->step[i], s->lo[i], s->hi[i]);
      s->w[i] += t * s->v[i];
    }
    a = (curve > 0.0) ? fmin(fmax(length / curve, 1e-10), 1e10) : 1e10;
    res->work.iterations++;
  }
}

/* x, v = M x + q and the accepted b; ratio of the last trial in *ratio. */
static double trial(state *s, const lcp_problem *p, const double *z, double b, double *ratio,
                    lcp_result *res) {
  const int n = p->M.n;
  for (int k = 0;; k++) {
    project(s, n, z, b, s->w, s->x);
    lcp_matrix_apply(&p->M, s->x, p->q, s->v, s->loop.stop.scratch);
    res->work.matvecs++;
    double field = 0.0, move = 0.0;
    for (int i = 0; i < n; i++) {
      const double f = s->r[i] * (s->w[i] - s->v[i]), m = (z[i] - s->x[i]) / s->c[i];
      field += f * f;
      move += m * m;
    }
    *ratio = (move > 0.0) ? b * sqrt(field / move) : 0.0;
    if (*ratio <= 0.9 || k == 60) {
      return b;
    }
    b *= 0.7 * fmin(1.0, 1.0 / *ratio);
    res->work.linesearches++;
  }
}

static void extragradient(state *s, const options *o, const lcp_problem *p, lcp_trace *trace,
                          double *z, lcp_result *res) {
  const int n = p->M.n;
  double b = 1.0;
  bool fresh;
  lcp_loop_begin(&s->loop, p, false);
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
    lcp_loop_product(&s->loop, p, z, fresh, s->w, res);
    double ratio = 0.0, along = 0.0, size = 0.0;
    b = trial(s, p, z, b, &ratio, res);
    for (int i = 0; i < n; i++) {
      const double move = (z[i] - s->x[i]) / s->c[i];
      const double e = move - b * s->r[i] * (s->w[i] - s->v[i]);
      along += move * e;
      size += e * e;
    }
    if (!(size > 0.0)) { /* z = P(z - b c r w) to the last bit */
      lcp_loop_stationary(&s->loop, &o->stop, p, z, trace, res);
      return;
    }
    project(s, n, z, 1.8 * b * (along / size), s->v, z);
    b *= (ratio < 0.4) ? 1.5 : 1.0;
    res->work.iterations++;
  }
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  state *s = st;
  for (int i = 0; i < p->M.n; i++) {
    z[i] = lcp_set_clip(z[i], s->lo[i], s->hi[i]);
  }
  res->variant = s->symmetric ? "spg" : "extragradient";
  (s->symmetric ? spg : extragradient)(s, opt, p, trace, z, res);
  return BASE_OK;
}

const lcp_solver lcp_solver_projected_gradient = {
    .name = "projected_gradient",
    .title = "Projected gradient",
    .cite = "birgin2000; he2002",
    .words = "Gradient steps, cut off at the bounds.",
    .when = "Large symmetric problems, to a moderate accuracy.",
    .sets = (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .warm = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
};
