/* solver_nncg.c - nonsmooth nonlinear conjugate gradients on the Gauss-Seidel map.
 *
 *   g_k = z_k - PGS(z_k),  b = |g_k|^2 / |g_k-1|^2,  s_k = b s_k-1 - g_k,  z_k+1 = PGS(z_k) + b s_k-1
 *
 * Silcowitz, Niebe & Erleben 2010, algorithm 1 (Fletcher-Reeves; restart with s = 0 where b > 1).
 * Norms in the metric of the diagonal, so that iterates do not depend on units. Departure: the
 * extrapolated point is clipped into K, so every iterate can be judged. The sweep is that of pgs
 * (gauss_seidel.h), with its conditions on the diagonal. */
#include "lcp/solvers/gauss_seidel.h"
#include "lcp/solvers/loop.h"
#include "lcp/solvers/sets.h"

#include <string.h>

typedef struct options {
  lcp_stop stop;
} options;

static const base_field fields[] = {
    LCP_LOOP_SWEEP_FIELDS(options, 1e-8, 10000),
};

typedef struct state {
  lcp_loop loop;
  lcp_gs gs;
  double *before; /* n, z before the sweep */
  double *along;  /* n, search direction */
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  lcp_gs_layout(&s->gs, cap, a);
  s->before = BASE_ARRAY(a, double, cap->n);
  s->along = BASE_ARRAY(a, double, cap->n);
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  return lcp_gs_prepare(&((state *)st)->gs, p, err);
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  const int n = p->M.n;
  const size_t bytes = (size_t)n * sizeof *z;
  double last = 0.0; /* |g_k-1|^2 */
  res->variant = s->gs.by_block ? "block" : "point";
  memset(s->along, 0, bytes);
  lcp_gs_start(&s->gs, p, z, &res->work);
  lcp_loop_begin(&s->loop, p, false);
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, NULL)) {
    memcpy(s->before, z, bytes);
    lcp_gs_sweep(&s->gs, p, 1.0, z, res);
    double size = 0.0;
    for (int i = 0; i < n; i++) {
      const double g = (z[i] - s->before[i]) / s->loop.scale[i];
      size += g * g;
    }
    if (size == 0.0) { /* a fixed point of the sweep that the test does not accept */
      lcp_loop_stationary(&s->loop, &o->stop, p, z, trace, res);
      return BASE_OK;
    }
    const double b = (last > 0.0 && size <= last) ? size / last : 0.0;
    res->work.fallbacks += (last > 0.0 && size > last);
    for (int i = 0; i < n; i++) {
      const double step = b * s->along[i];
      s->along[i] = (b > 0.0 || last == 0.0) ? step + (z[i] - s->before[i]) : 0.0;
      z[i] = lcp_set_clip(z[i] + step, s->gs.lo[i], s->gs.hi[i]);
    }
    lcp_sweep_refresh(&s->gs.sweep, p, z, &res->work);
    last = size;
    res->work.iterations++;
    res->work.sweeps++;
  }
  return BASE_OK;
}

const lcp_solver lcp_solver_nncg = {
    .name = "nncg",
    .title = "Nonsmooth nonlinear CG",
    .cite = "silcowitz2010a, algorithm 1",
    .words = "Sweeps with conjugate directions.",
    .when = "Tall stacks, on which plain sweeps creep.",
    .sets = (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .warm = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
};
