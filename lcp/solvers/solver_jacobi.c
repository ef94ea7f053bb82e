/* solver_jacobi.c - damped projected Jacobi: z <- P(z - omega D^-1 (M z + q)), D = diag M.
 *
 * Cottle, Pang & Stone 1992, section 5.2 (the splitting B = D / omega). Every component moves on the
 * same w, so an iteration is one product and its order does not matter. For symmetric positive
 * semidefinite M it converges for omega < 2 / lambda, lambda the largest eigenvalue of D^-1 M, which
 * grows with the number of contacts on a body. omega = 0 (default) takes 1 / lambda with lambda from
 * power iterations on D^-1/2 M D^-1/2, whose estimate from below is safe up to a factor two. */
#include "lcp/solvers/loop.h"
#include "lcp/solvers/sets.h"

typedef struct options {
  lcp_stop stop;
  double omega;
} options;

static const base_field fields[] = {
    LCP_LOOP_SWEEP_FIELDS(options, 1e-8, 10000),
    BASE_FIELD(options, omega, BASE_REAL, "1", 0.0, 0.0, 1.99,
               "damping factor; 0: one over the largest eigenvalue of D^-1 M"),
};

typedef struct state {
  lcp_loop loop;
  double *lo, *hi; /* n */
  double *c, *w;   /* n, 1/sqrt(M_ii); M z + q */
  double *x;       /* n, eigenvector */
  double omega;
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  s->lo = BASE_ARRAY(a, double, cap->n);
  s->hi = BASE_ARRAY(a, double, cap->n);
  s->c = BASE_ARRAY(a, double, cap->n);
  s->w = BASE_ARRAY(a, double, cap->n);
  s->x = BASE_ARRAY(a, double, cap->n);
}

/* |D^-1/2 M D^-1/2 x| / |x| after 30 products from a start without symmetry. */
static double largest_eigenvalue(state *s, const lcp_problem *p) {
  const int n = p->M.n;
  double lambda = 1.0;
  for (int i = 0; i < n; i++) {
    s->x[i] = 1.0 + 0.5 * sin(1.0 + i);
  }
  for (int k = 0; k < 30; k++) {
    double size = 0.0;
    for (int i = 0; i < n; i++) {
      size += s->x[i] * s->x[i];
    }
    size = 1.0 / sqrt(size);
    for (int i = 0; i < n; i++) {
      s->x[i] *= size * s->c[i];
    }
    lcp_matrix_apply(&p->M, s->x, NULL, s->w, s->loop.stop.scratch);
    lambda = 0.0;
    for (int i = 0; i < n; i++) {
      s->x[i] = s->c[i] * s->w[i];
      lambda += s->x[i] * s->x[i];
    }
    lambda = sqrt(lambda);
    if (!(lambda > 0.0)) {
      return 1.0;
    }
  }
  return lambda;
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  const options *o = opt;
  state *s = st;
  lcp_matrix_diagonal(&p->M, s->c);
  for (int i = 0; i < p->M.n; i++) {
    if (!(s->c[i] > 0.0) && !lcp_set_still(p, s->c[i], i)) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "diagonal %d is %g: need > 0", i, s->c[i]);
    }
    s->c[i] = (s->c[i] > 0.0) ? 1.0 / sqrt(s->c[i]) : 0.0;
  }
  lcp_set_intervals(p, s->lo, s->hi);
  s->omega = (o->omega > 0.0) ? o->omega : 1.0 / largest_eigenvalue(s, p);
  return BASE_OK;
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  const int n = p->M.n;
  bool fresh;
  for (int i = 0; i < n; i++) {
    z[i] = lcp_set_clip(z[i], s->lo[i], s->hi[i]);
  }
  lcp_loop_begin(&s->loop, p, true);
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
    const double *w = s->loop.stop.w;
    if (!fresh) {
      lcp_matrix_apply(&p->M, z, p->q, s->w, s->loop.stop.scratch);
      res->work.matvecs++;
      w = s->w;
    }
    for (int i = 0; i < n; i++) {
      const double step = s->omega * (s->c[i] * (s->c[i] * w[i]));
      z[i] = (s->c[i] > 0.0) ? lcp_set_clip(z[i] - step, s->lo[i], s->hi[i])
                             : lcp_set_end(z[i], w[i], s->lo[i], s->hi[i]);
    }
    res->work.iterations++;
  }
  return BASE_OK;
}

const lcp_solver lcp_solver_jacobi = {
    .name = "jacobi",
    .title = "Projected Jacobi, damped",
    .cite = "cottle1992, 5.2",
    .words = "Sweeps over all unknowns at once, damped.",
    .when = "Where sweeps are to run in parallel; alone it is slower than one unknown at a time.",
    .sets = (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .warm = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
};
