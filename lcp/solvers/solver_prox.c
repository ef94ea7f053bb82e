/* solver_prox.c - proximal-point method around nonsmooth Gauss-Seidel, or around a Newton method.
 *
 *   z_k+1 ~ solution with M + S_k and q - S_k z_k,  S_k = weight_k trace(M_bb) / size on block b
 *
 * Rockafellar 1976 (inexact, error summable); for friction Acary, Bremond & Huber 2018, section 5.4.
 * The strongly monotone inner problem is solved
 *
 *   inner=nsgs     by sweeps (cone_sweep.h), until one moves less than a tenth of the distance from the centre
 *   inner=newton   by a semismooth Newton method (cone_inner.h), until a tenth of the residual is left to it
 *
 * then the centre moves. The weight shrinks by `shrink` where the inner problem took few sweeps or steps and grows where it hit its
 * limit; the fixed point is that of the original problem whatever the weight. `polish=on` tries the modes of the iterates
 * as the answer's (cone_polish.h). */
#include "lcp/solvers/cone_inner.h"
#include "lcp/solvers/cone_polish.h"
#include "lcp/solvers/cone_sweep.h"
#include "lcp/solvers/loop.h"

#include <string.h>

enum { NSGS, NEWTON };                  /* inner */
enum { OFF, ON };                       /* polish */
static const double most_weight = 10.0; /* newton */

typedef struct options {
  lcp_stop stop;
  double weight, shrink;
  int inner, sweeps, newton, polish;
} options;

static const base_field fields[] = {
    LCP_STOP_FIELDS(options, 1e-8, 10000),
    BASE_FIELD(options, weight, BASE_REAL, "1", 0.1, 1e-12, 1e3, "first proximal weight"),
    BASE_FIELD(options, shrink, BASE_REAL, "1", 0.5, 0.01, 1.0, "factor of the weight"),
    BASE_FIELD_CHOICE(options, inner, "nsgs|newton", NSGS, "how an inner problem is solved"),
    BASE_FIELD(options, sweeps, BASE_INT, "1", 50, 1, 1e6, "limit of one inner problem, nsgs"),
    BASE_FIELD(options, newton, BASE_INT, "1", 12, 1, 1e3, "limit of one inner problem, newton"),
    BASE_FIELD_CHOICE(options, polish, "off|on", OFF, "modes solved to rounding"),
};

typedef struct state {
  lcp_loop loop;
  lcp_cone_sweep sweep;
  lcp_cone_inner inner;
  lcp_cone_polish polish;
  double *center; /* n */
  double weight;
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  const options *o = opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  if (o->inner == NEWTON) {
    lcp_cone_inner_layout(&s->inner, cap, a);
  } else {
    lcp_cone_sweep_layout(&s->sweep, cap, a);
  }
  if (o->polish == ON) {
    lcp_cone_polish_layout(&s->polish, cap, a);
  }
  s->center = BASE_ARRAY(a, double, cap->n);
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  const options *o = opt;
  state *s = st;
  if (o->polish == ON) {
    BASE_TRY(lcp_cone_polish_prepare(&s->polish, p, err));
  }
  return (o->inner == NEWTON) ? lcp_cone_inner_prepare(&s->inner, p, err)
                              : lcp_cone_sweep_prepare(&s->sweep, p, err);
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

/* One inner problem by sweeps. False: nothing moves any more. */
static bool sweep(state *s, const options *o, const lcp_problem *p, double *z, lcp_work *work) {
  const int n = p->M.n;
  int k = 0;
  double change = 1.0;
  lcp_sweep_refresh(&s->sweep.sweep, p, z, work);
  while (k++ < o->sweeps && change > 0.1 * distance(n, z, s->center)) {
    change = lcp_cone_sweep_run(&s->sweep, p, 1.0, s->weight, s->center, z);
    work->sweeps++;
  }
  s->weight = (k < o->sweeps / 2) ? fmax(s->weight * o->shrink, 1e-12)
                                  : fmin(s->weight / o->shrink, o->weight);
  return change != 0.0 || distance(n, z, s->center) != 0.0;
}

/* One inner problem by Newton's method, from the point before again where it got nowhere. False: that at the largest weight, or
 * *status says no memory. */
static bool newton(state *s, const options *o, const lcp_problem *p, double *z, lcp_work *work,
                   base_status *status) {
  const int taken = lcp_cone_inner_run(&s->inner, p, s->weight, o->newton, z, work, status);
  const bool reached = taken <= o->newton, finite = distance(p->M.n, z, s->center) <= 1.0;
  if (!finite) {
    memcpy(z, s->center, (size_t)p->M.n * sizeof *z);
  }
  if (!reached) {
    work->fallbacks++;
  }
  const bool last = !finite && s->weight >= most_weight;
  s->weight = reached ? ((2 * taken <= o->newton) ? fmax(s->weight * o->shrink, 1e-12) : s->weight)
                      : fmin(s->weight / (o->shrink * o->shrink), most_weight);
  return *status == BASE_OK && !last;
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  bool fresh;
  base_status status = BASE_OK;
  s->weight = o->weight;
  lcp_loop_begin(&s->loop, p, false);
  if (o->polish == ON) {
    lcp_cone_polish_begin(&s->polish);
  }
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
    if (fresh && o->polish == ON &&
        lcp_cone_polish_try(&s->polish, &s->loop, &o->stop, p, 1.0, NULL, z, res, &status)) {
      break;
    }
    memcpy(s->center, z, (size_t)p->M.n * sizeof *z);
    const bool on = (o->inner == NEWTON) ? newton(s, o, p, z, &res->work, &status)
                                         : sweep(s, o, p, z, &res->work);
    if (!on || status != BASE_OK) {
      res->outcome = LCP_STALLED;
      break;
    }
    res->work.iterations++;
  }
  return status;
}

static void release(void *st) {
  state *s = st;
  lcp_cone_inner_release(&s->inner);
  lcp_cone_polish_release(&s->polish);
}

const lcp_solver lcp_solver_prox = {
    .name = "prox",
    .title = "Proximal point",
    .cite = "rockafellar1976; acary2018, 5.4",
    .words = "A fixed point of problems made easier, each solved by sweeps or by Newton steps.",
    .when = "The round cone, where sweeps alone do not converge.",
    .sets = (1u << LCP_CONE) | (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .warm = true,
    .allocates = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
    .release = release,
};
