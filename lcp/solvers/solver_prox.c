/* solver_prox.c - proximal-point method around nonsmooth Gauss-Seidel.
 *
 *   z_k+1 ~ solution with M + S_k and q - S_k z_k,  S_k = weight_k trace(M_bb) / size on block b
 *
 * Rockafellar 1976 (inexact, error summable); for friction Acary, Bremond & Huber 2018, section 5.4.
 * The strongly monotone inner problem is swept (cone_sweep.h) until the sweep moves less than a tenth
 * of the distance from the centre, then the centre moves. The weight shrinks by `shrink` where the
 * inner problem took few sweeps and grows where it hit its limit; the fixed point is that of the
 * original problem whatever the weight. */
#include "lcp/solvers/cone_sweep.h"
#include "lcp/solvers/loop.h"

#include <string.h>

typedef struct options {
  lcp_stop stop;
  double weight, shrink;
  int inner;
} options;

static const base_field fields[] = {
    LCP_STOP_FIELDS(options, 1e-8, 10000),
    BASE_FIELD(options, weight, BASE_REAL, "1", 0.1, 1e-12, 1e3, "first proximal weight"),
    BASE_FIELD(options, shrink, BASE_REAL, "1", 0.5, 0.01, 1.0, "factor of the weight"),
    BASE_FIELD(options, inner, BASE_INT, "1", 50, 1, 1e6, "sweeps of one inner problem"),
};

typedef struct state {
  lcp_loop loop;
  lcp_cone_sweep sweep;
  double *center; /* n */
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  lcp_cone_sweep_layout(&s->sweep, cap, a);
  s->center = BASE_ARRAY(a, double, cap->n);
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  return lcp_cone_sweep_prepare(&((state *)st)->sweep, p, err);
}

/* max |z - c| / (|z| + |z - c|) over rows. */
static double distance(int n, const double *z, const double *c) {
  double worst = 0.0;
  for (int i = 0; i < n; i++) {
    const double move = fabs(z[i] - c[i]);
    worst = fmax(worst, (move > 0.0) ? move / (fabs(z[i]) + move) : 0.0);
  }
  return worst;
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  const int n = p->M.n;
  double weight = o->weight;
  lcp_loop_begin(&s->loop, p, false);
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, NULL)) {
    memcpy(s->center, z, (size_t)n * sizeof *z);
    lcp_sweep_refresh(&s->sweep.sweep, p, z, &res->work);
    int k = 0;
    double change = 1.0;
    while (k++ < o->inner && change > 0.1 * distance(n, z, s->center)) {
      change = lcp_cone_sweep_run(&s->sweep, p, 1.0, weight, s->center, z);
      res->work.sweeps++;
    }
    if (change == 0.0 && distance(n, z, s->center) == 0.0) {
      res->outcome = LCP_STALLED;
      return BASE_OK;
    }
    weight =
        (k < o->inner / 2) ? fmax(weight * o->shrink, 1e-12) : fmin(weight / o->shrink, o->weight);
    res->work.iterations++;
  }
  return BASE_OK;
}

const lcp_solver lcp_solver_prox = {
    .name = "prox",
    .title = "Proximal point with Gauss-Seidel",
    .cite = "rockafellar1976; acary2018, 5.4",
    .words = "A fixed point of problems made easier, each solved by sweeps.",
    .when = "The round cone, where sweeps alone do not converge.",
    .sets = (1u << LCP_CONE) | (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .warm = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
};
