/* solver_pgs_sm.c - projected Gauss-Seidel with subspace minimisation.
 *
 * Silcowitz, Niebe & Erleben 2010: `sweeps` Gauss-Seidel sweeps guess the active set
 *   A = { i : lo_i < z_i < hi_i },
 * then  M_AA x_A = -q_A - M_AB z_B  is solved directly. Departures: the active set is corrected up to
 * `inner` times from signs, { z_i > lo_i in A } + { w_i < 0 outside } (the primal-dual active set step
 * of Hintermuller, Ito & Kunisch 2002), where the paper only removes; and the subspace point replaces
 * the swept one only where its natural map is smaller, so a bad guess costs time, not progress.
 *
 * Singular subspaces (redundant contacts): where the plain solve fails or does not help, the system is
 * solved as the fixed point of
 *   x <- x - (s M_AA s + 1e-10 I)^-1 s w_A,     s_i^2 M_ii = 1,
 * proximal-point steps, each of which divides the error by 1e10 times the eigenvalue and leaves the
 * null space where it is (counted in `fallbacks`); the equations solved are the original ones. Dense LU
 * or KLU. */
#include "lcp/linear/direct.h"
#include "lcp/solvers/gauss_seidel.h"
#include "lcp/solvers/loop.h"
#include "lcp/solvers/sets.h"

#include <string.h>

enum { STEPS = 6 }; /* of refinement at most; a shift of 1e-10 reaches rounding in two or three */

typedef struct options {
  lcp_stop stop;
  int sweeps, inner;
} options;

static const base_field fields[] = {
    LCP_STOP_FIELDS(options, 1e-10, 1000),
    BASE_FIELD(options, sweeps, BASE_INT, "1", 5, 1, 1e6, "Gauss-Seidel sweeps per iteration"),
    BASE_FIELD(options, inner, BASE_INT, "1", 10, 1, 1e4, "active sets tried per iteration"),
};

typedef struct state {
  lcp_loop loop;
  lcp_gs gs;
  lcp_direct direct;
  double *s;             /* n, scaling */
  double *shift;         /* n, 0 or 1e-10 */
  double *x, *w, *step;  /* n, subspace point; M x + q */
  unsigned char *active; /* n */
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  lcp_gs_layout(&s->gs, cap, a);
  lcp_direct_layout(&s->direct, cap, a);
  double **const arrays[] = {&s->s, &s->shift, &s->x, &s->w, &s->step};
  for (int i = 0; i < BASE_COUNT(arrays); i++) {
    *arrays[i] = BASE_ARRAY(a, double, cap->n);
  }
  s->active = BASE_ARRAY(a, unsigned char, cap->n);
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  state *s = st;
  lcp_direct_begin(&s->direct);
  BASE_TRY(lcp_gs_prepare(&s->gs, p, err));
  lcp_set_scaling(&p->M, s->gs.sweep.d, s->s);
  return BASE_OK;
}

static void residual(state *s, const lcp_problem *p, lcp_result *res) {
  lcp_matrix_apply(&p->M, s->x, p->q, s->w, s->loop.stop.scratch);
  res->work.matvecs++;
}

/* |natural map|^2 in scaled variables. */
static double natural(const state *s, int n, const double *z, const double *w) {
  double sum = 0.0;
  for (int i = 0; i < n; i++) {
    const double x = z[i] / s->s[i], lo = s->gs.lo[i] / s->s[i], hi = s->gs.hi[i] / s->s[i];
    const double r = x - lcp_set_clip(x - s->s[i] * w[i], lo, hi);
    sum += r * r;
  }
  return sum;
}

/* Solves w_A = 0 from x; false: the shifted matrix is singular. */
static bool solve_subspace(state *s, const lcp_problem *p, lcp_result *res, base_status *status) {
  const int n = p->M.n;
  double last = HUGE_VAL;
  res->work.factorizations++;
  if (!lcp_direct_factor(&s->direct, &p->M, s->active, s->shift, s->s, s->s, status)) {
    return false;
  }
  for (int k = 0; k < STEPS; k++) {
    double size = 0.0;
    for (int i = 0; i < n; i++) {
      s->step[i] = s->active[i] ? -s->s[i] * s->w[i] : 0.0;
      size += s->step[i] * s->step[i];
    }
    if (!(size < 0.01 * last)) { /* down to rounding */
      break;
    }
    last = size;
    lcp_direct_solve(&s->direct, n, s->step);
    for (int i = 0; i < n; i++) {
      s->x[i] += s->active[i] ? s->s[i] * s->step[i] : 0.0;
    }
    residual(s, p, res);
    res->work.backsolves++;
  }
  return true;
}

/* Next active set from signs at (x, w); clips x to it. Returns how many rows changed sides. */
static int change_sides(state *s, int n) {
  int changed = 0;
  for (int i = 0; i < n; i++) {
    const double lo = s->gs.lo[i], hi = s->gs.hi[i];
    bool inside;
    if (s->active[i]) {
      inside = s->x[i] > lo && s->x[i] < hi;
      s->x[i] = lcp_set_clip(s->x[i], lo, hi);
    } else {
      inside = lo < hi && ((s->x[i] <= lo) ? s->w[i] < 0.0 : s->w[i] > 0.0);
    }
    changed += inside != (s->active[i] != 0);
    s->active[i] = inside;
  }
  return changed;
}

/* Tries up to `inner` active sets from z; the best point replaces z where it is better. True: it is,
 * by two digits. */
static bool subspace(state *s, const options *o, const lcp_problem *p, double shift, double *z,
                     lcp_result *res, base_status *status) {
  const int n = p->M.n;
  for (int i = 0; i < n; i++) {
    s->active[i] = z[i] > s->gs.lo[i] && z[i] < s->gs.hi[i];
    s->shift[i] = shift;
  }
  memcpy(s->x, z, (size_t)n * sizeof *z);
  residual(s, p, res);
  const double start = natural(s, n, s->x, s->w);
  double best = start;
  for (int k = 0; k < o->inner && solve_subspace(s, p, res, status); k++) {
    const int changed = change_sides(s, n);
    residual(s, p, res);
    const double now = natural(s, n, s->x, s->w);
    if (now < best) {
      best = now;
      memcpy(z, s->x, (size_t)n * sizeof *z);
    }
    if (changed == 0) {
      break;
    }
  }
  return best <= 1e-4 * start;
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  res->variant = s->gs.by_block ? "block" : "point";
  lcp_gs_start(&s->gs, p, z, &res->work);
  lcp_loop_begin(&s->loop, p, true);
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, NULL)) {
    lcp_sweep_refresh(&s->gs.sweep, p, z, &res->work);
    for (int k = 0; k < o->sweeps; k++) {
      lcp_gs_sweep(&s->gs, p, 1.0, z, res);
      res->work.sweeps++;
    }
    base_status status = BASE_OK;
    if (!subspace(s, o, p, 0.0, z, res, &status) && status == BASE_OK) {
      (void)subspace(s, o, p, 1e-10, z, res, &status);
      res->work.fallbacks++;
    }
    BASE_TRY(status);
    res->work.iterations++;
  }
  return BASE_OK;
}

static void release(void *st) {
  lcp_direct_release(&((state *)st)->direct);
}

const lcp_solver lcp_solver_pgs_sm = {
    .name = "pgs_sm",
    .title = "Gauss-Seidel with subspace minimisation",
    .cite = "silcowitz2010b",
    .words = "Sweeps, then a linear solve for the unknowns that they left inside the bounds.",
    .when = "Where sweeps find the active contacts soon and accuracy is asked for.",
    .sets = (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC),
    .warm = true,
    .allocates = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
    .release = release,
};
