/* solver_sqp.c - sequential quadratic programming on  min z'Mz/2 + q'z  over K, by NLopt's SLSQP.
 *
 * Kraft 1988 (algorithm 733, 1994) as packaged by NLopt, in the variables z / s (s_i^2 M_ii = u^2 with
 * u the size of q, so that SLSQP's own absolute tolerances see numbers near one).
 * For symmetric M, whose LCP is the optimality condition. SLSQP keeps a dense quasi-Newton
 * factor, O(n^3) an iteration: at most 100 unknowns. It is started again from where it ended until
 * the residual test passes, or nothing moves. */
#include "lcp/base/clock.h"
#include "lcp/base/nlopt_library.h"
#include "lcp/solvers/loop.h"
#include "lcp/solvers/sets.h"

#include <string.h>

enum { LARGEST = 100, ROUND = 100 };

typedef struct options {
  lcp_stop stop;
} options;

static const base_field fields[] = {
    LCP_STOP_FIELDS(options, 1e-8, 2000),
};

typedef struct state {
  nlopt_library nlopt;
  lcp_loop loop;
  double *lo, *hi; /* n, of x */
  double *s, *x;   /* n, scaling; z / s */
  double *z, *w;   /* n, of the objective */
  double energy;   /* u^2 [J] */
  const lcp_problem *p;
  lcp_result *res;
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  double **const arrays[] = {&s->lo, &s->hi, &s->s, &s->x, &s->z, &s->w};
  for (int i = 0; i < BASE_COUNT(arrays); i++) {
    *arrays[i] = BASE_ARRAY(a, double, cap->n);
  }
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  state *s = st;
  if (p->M.n > LARGEST) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "n=%d: need at most %d", p->M.n, (int)LARGEST);
  }
  if (!lcp_set_symmetric(p)) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "matrix: not symmetric, need an objective");
  }
  BASE_TRY(nlopt_open(&s->nlopt, err));
  lcp_matrix_diagonal(&p->M, s->w);
  lcp_set_scaling(&p->M, s->w, s->s);
  lcp_set_intervals(p, s->lo, s->hi);
  double size = 0.0;
  for (int i = 0; i < p->M.n; i++) {
    size = fmax(size, fabs(s->s[i] * p->q[i]));
  }
  int e = 0;
  (void)frexp(size, &e);
  const double u = (size > 0.0) ? ldexp(1.0, e) : 1.0;
  s->energy = u * u;
  for (int i = 0; i < p->M.n; i++) {
    s->s[i] *= u;
    s->lo[i] /= s->s[i];
    s->hi[i] /= s->s[i];
  }
  return BASE_OK;
}

static double objective(unsigned n, const double *x, double *gradient, void *data) {
  state *s = data;
  double f = 0.0;
  for (unsigned i = 0; i < n; i++) {
    s->z[i] = s->s[i] * x[i];
  }
  lcp_matrix_apply(&s->p->M, s->z, s->p->q, s->w, s->loop.stop.scratch);
  s->res->work.matvecs++;
  for (unsigned i = 0; i < n; i++) {
    f += 0.5 * s->z[i] * (s->w[i] + s->p->q[i]) / s->energy;
    if (gradient != NULL) {
      gradient[i] = s->s[i] * s->w[i] / s->energy;
    }
  }
  return f;
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  const int n = p->M.n;
  s->p = p;
  s->res = res;
  nlopt_opt sqp = s->nlopt.nlopt_create(NLOPT_LD_SLSQP, (unsigned)n);
  if (sqp == NULL) {
    return BASE_ENOMEM;
  }
  bool ready = s->nlopt.nlopt_set_lower_bounds(sqp, s->lo) > 0 &&
               s->nlopt.nlopt_set_upper_bounds(sqp, s->hi) > 0 &&
               s->nlopt.nlopt_set_min_objective(sqp, objective, s) > 0 &&
               s->nlopt.nlopt_set_xtol_rel(sqp, 1e-15) > 0;
  for (int i = 0; i < n; i++) {
    s->x[i] = lcp_set_clip(z[i] / s->s[i], s->lo[i], s->hi[i]);
    z[i] = s->s[i] * s->x[i];
  }
  lcp_loop_begin(&s->loop, p, true);
  while (ready && !lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, NULL)) {
    const long left = o->stop.max_iter - res->work.iterations;
    const double seconds = o->stop.max_seconds - (base_seconds() - s->loop.stop.started);
    ready = s->nlopt.nlopt_set_maxeval(sqp, (left < ROUND) ? (int)left : ROUND) > 0 &&
            s->nlopt.nlopt_set_maxtime(sqp, fmax(seconds, 1e-3)) > 0;
    double f;
    const nlopt_result end = ready ? s->nlopt.nlopt_optimize(sqp, s->x, &f) : NLOPT_SUCCESS;
    ready = ready && end != NLOPT_INVALID_ARGS && end != NLOPT_OUT_OF_MEMORY;
    const int evaluations = s->nlopt.nlopt_get_numevals(sqp);
    res->work.iterations += (evaluations > 0) ? evaluations : 1;
    for (int i = 0; i < n; i++) {
      s->x[i] = lcp_set_clip(s->x[i], s->lo[i], s->hi[i]);
      z[i] = s->s[i] * s->x[i];
    }
  }
  s->nlopt.nlopt_destroy(sqp);
  return ready ? BASE_OK : BASE_EEXTERNAL;
}

const lcp_solver lcp_solver_sqp = {
    .name = "sqp",
    .title = "SQP (NLopt SLSQP)",
    .cite = "kraft1994",
    .words = "A general optimiser that knows nothing of contacts.",
    .when = "A yardstick: what a library does out of the box.",
    .sets = (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .warm = true,
    .allocates = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
};
