/* solver_cone_newton.c - exact Coulomb friction by a semismooth Newton method inside proximal point steps.
 *
 * In the scaled variables x, y of cone_scaled.h (M -> s M s, mean diagonal 1) an outer step looks for
 *
 *   x+ :  F(x+, y(x+) + weight (x+ - c)) = 0,      c = x of the outer step before     (Rockafellar 1976)
 *
 * with F of cone_map.h: `alart_curnier` (Alart & Curnier 1991) or `fischer` (Fukushima, Luo & Tseng 2002). The
 * weight makes the Newton system of cone_step.h regular however redundant the contacts are; its fixed
 * point is that of the problem itself, whatever the weight, and that alone is tested. No proof of convergence exists:
 * Coulomb's law is no monotone problem.
 *
 * Steps, each one factorisation:
 *   - |F| with the weight a tenth of |F| without it, or rounding: the outer step ends, weight *= shrink. The first weight
 *     is `weight` times the residual of the start point, so a warm start begins where the last one ended; but no less than ten
 *     times the unit of rounding over that residual: where M does not see a step, it is rounding over the weight, which
 *     from a nearly right start would be more than what is missing.
 *   - |F| that is rounding says nothing of rows that are small beside it, whose residual is of their own size: one that nothing
 *     acts on and that starts from another value keeps a share of that, weight over mobility, in each outer step. So steps are
 *     whole then, the map is alart_curnier whatever `map` says, since fischer loses a small number beside a large one, and third-order rounding is
 *     zero.
 *   - t = 1, 1/2, 1/4 by Armijo's rule on |F|; where all are refused the whole step is taken: a Newton step that a
 *     kink of F stops (a contact about to stick or slip) is not mended by a short one. On 1000 random sets
 *     (tests/bench/bench_cone.c) 46 steps on the mean for 123 with steps down to 2^-10, which left 18 sets open; how
 *     many are solved stands in README.md.
 *   - six steps without a new lowest |F| of four fifths of the last: stalled. The weight is raised tenfold, shrinks more slowly from
 *     then on (shrink^0.8), and the other map takes over; counted in `fallbacks`. So is a singular system.
 *
 * Of an infeasible problem the proximal points run away along a y with y'w < 0 (Rockafellar 1976, theorem 1): the normal
 * parts of an outer step's way are tried as a Farkas vector where it made z four times as large. */
#include "lcp/solvers/cone_newton/cone_newton.h"
#include "lcp/solvers/data_test.h"
#include "lcp/solvers/sets.h"

#include <float.h>
#include <string.h>

enum { ALART_CURNIER, FISCHER }; /* option */

typedef cone_newton state;
typedef cone_newton_options options;

static const base_field fields[] = {
    LCP_STOP_FIELDS(options, 1e-10, 2000),
    BASE_FIELD_CHOICE(options, map, "alart_curnier|fischer", ALART_CURNIER,
                      "first complementarity function"),
    BASE_FIELD(options, weight, BASE_REAL, "1", 0.1, 1e-12, 10, "first proximal weight"),
    BASE_FIELD(options, shrink, BASE_REAL, "1", 0.1, 1e-3, 0.9, "factor of the weight"),
};

/* What the iterate x of the inner problem is in p: z itself, or unfolded with w. */
static void show(cone_newton *s, const double *x, double *w, double *z, lcp_result *res) {
  if (s->fold.done) {
    lcp_cone_newton_velocities(s, &s->fold.p, x, w, res);
    lcp_fold_out(&s->fold, x, w, s->eq.s, z);
  }
}

/* Third-order rounding is zero: what rounding in M couples to a large impulse is of first order, and what that couples of second. */
static void drop_noise(const cone_newton *s, int n, double *z) {
  double most = 0.0;
  for (int i = 0; i < n; i++) {
    most = fmax(most, fabs(z[i] / s->eq.s[i]));
  }
  const double noise = DBL_EPSILON * DBL_EPSILON * DBL_EPSILON * most;
  for (int i = 0; i < n; i++) {
    z[i] = (fabs(z[i] / s->eq.s[i]) <= noise) ? 0.0 : z[i];
  }
}

/* z <- z + t s dx; whole where |F| is rounding, which tells nothing of lengths. */
static void search(cone_newton *s, const lcp_problem *p, double now, double *z, lcp_result *res) {
  static const double lengths[] = {1.0, 0.5, 0.25};
  const int n = p->M.n;
  double t = 1.0;
  for (int k = 0; k < BASE_COUNT(lengths) && !s->blind; k++) {
    for (int i = 0; i < n; i++) {
      s->trial[i] = z[i] + lengths[k] * s->eq.s[i] * s->dx[i];
    }
    lcp_cone_newton_velocities(s, p, s->trial, s->wt, res);
    const double shorter = 1.0 - 1e-4 * lengths[k];
    if (lcp_cone_newton_merit(s, n, s->weight, s->trial, s->wt, false) < shorter * shorter * now) {
      t = lengths[k];
      break;
    }
    res->work.linesearches++;
  }
  for (int i = 0; i < n; i++) {
    z[i] += t * s->eq.s[i] * s->dx[i];
  }
  if (s->blind) {
    drop_noise(s, n, z);
  }
}

/* Into the cone over polygons: the normal impulse first, then friction within what it bears. */
static void into_polygons(const cone_newton *s, const lcp_block *b, double *x) {
  x[0] = fmax(x[0], 0.0);
  for (int k = 0, at = 1; k < b->n_part; at += b->part_dim[k++]) {
    const double radius = b->part_mu[k] * x[0];
    double to[2], by_v[4], by_radius[2];
    if (b->part_dim[k] == 1) {
      x[at] = lcp_set_clip(x[at], -radius, radius);
    } else {
      (void)lcp_polygon_project(s->eq.facets[b->start + at], radius, x + at, to, by_v, by_radius);
      memcpy(x + at, to, sizeof to);
    }
  }
}

/* to = the point of K nearest to z, cones as they are. */
static void project(const cone_newton *s, const double *z, double *to) {
  if (!s->fold.done) {
    lcp_cone_scaled_project(&s->eq, z, to);
    return;
  }
  for (int k = 0; k < s->eq.n_piece; k++) {
    const lcp_block *b = &s->eq.piece[k];
    const int i = b->start;
    if (b->set == LCP_CONE) { /* in x, where mu is scaled */
      double x[LCP_CONE_MAX] = {0};
      for (int r = 0; r < b->size; r++) {
        x[r] = z[i + r] / s->eq.s[i + r];
      }
      into_polygons(s, b, x);
      for (int r = 0; r < b->size; r++) {
        to[i + r] = x[r] * s->eq.s[i + r];
      }
    } else {
      to[i] = lcp_set_clip(z[i], s->eq.lo[i] * s->eq.s[i], s->eq.hi[i] * s->eq.s[i]);
    }
  }
}

/* Newton's step from z taken whole; false without one. */
static bool whole_step(cone_newton *s, const lcp_problem *p, double *z, lcp_result *res,
                       base_status *status) {
  lcp_cone_newton_velocities(s, p, z, s->wt, res);
  lcp_cone_newton_recentre(s, p->M.n, z);
  (void)lcp_cone_newton_merit(s, p->M.n, s->weight, z, s->wt, true);
  if (!lcp_cone_step_factor(&s->step, p, &s->eq, s->weight, &res->work, status)) {
    return false;
  }
  lcp_cone_step_solve(&s->step, p, &s->eq, s->dx, &res->work);
  for (int i = 0; i < p->M.n; i++) {
    z[i] += s->eq.s[i] * s->dx[i];
  }
  res->work.refinements++;
  return true;
}

/* The accepted x moved into K, where that passes the test as well; where it does not, after one or two more Newton steps:
 * rho hardly sees an impulse of a light body that is out of its cone. An x that is in K to the bit, as a start point is that
 * was right, is z already and has passed. */
static base_status finish(cone_newton *s, const cone_newton_options *o, const lcp_problem *p,
                          const double *x, double *z, lcp_result *res) {
  const lcp_stop now = {o->stop.tol, o->stop.max_iter, 1, o->stop.max_seconds};
  const lcp_problem *in = lcp_cone_newton_inner(s, p);
  double *shown = s->fold.done ? s->shown : s->trial;
  base_status status = BASE_OK;
  memcpy(s->best, x, (size_t)in->M.n * sizeof *x);
  for (int k = 0; k < 3; k++) {
    lcp_result again = *res;
    project(s, s->best, s->trial);
    if (k == 0 && memcmp(s->trial, s->best, (size_t)in->M.n * sizeof *x) == 0) {
      break;
    }
    show(s, s->trial, s->wt, shown, &again);
    if (lcp_loop_ended(&s->loop, &now, p, shown, NULL, &again, NULL) &&
        again.outcome == LCP_SOLVED) {
      memcpy(z, shown, (size_t)p->M.n * sizeof *z);
      *res = again;
      break;
    }
    if (k == 2 || !whole_step(s, in, s->best, res, &status)) {
      break;
    }
  }
  return status;
}

/* One Newton step from x, whose w is given. False: the solve ends with the outcome that is set. */
static bool advance_and_step(cone_newton *s, const cone_newton_options *o, const lcp_problem *p,
                             double *w, double *x, lcp_result *res, base_status *status) {
  const lcp_problem *in = lcp_cone_newton_inner(s, p);
  const double now = lcp_cone_newton_advance(s, o, p, x, w, res);
  if (res->outcome == LCP_INFEASIBLE) {
    return false;
  }
  res->work.iterations++;
  if (lcp_cone_step_factor(&s->step, in, &s->eq, s->weight, &res->work, status)) {
    lcp_cone_step_solve(&s->step, in, &s->eq, s->dx, &res->work);
    search(s, in, now, x, res);
  } else if (*status != BASE_OK || s->weight >= cone_newton_most_weight) {
    res->outcome = LCP_STALLED;
    return false;
  } else {
    lcp_cone_newton_stalled(s, o, res);
    lcp_cone_newton_recentre(s, in->M.n, x);
  }
  return true;
}

/* The start point in K: outside, where M z + q = 0, rho has no scale. */
static void begin(cone_newton *s, const cone_newton_options *o, const lcp_problem *p, double *z,
                  double *x) {
  const lcp_problem *in = lcp_cone_newton_inner(s, p);
  s->map = (o->map == FISCHER) ? LCP_MAP_FISCHER : LCP_MAP_MIN;
  s->shrink = o->shrink;
  s->waited = 0;
  s->rounded = 0;
  s->bare = HUGE_VAL;
  if (s->fold.done) {
    lcp_fold_in(&s->fold, z, x);
  }
  project(s, x, s->trial);
  memcpy(x, s->trial, (size_t)in->M.n * sizeof *x);
  lcp_cone_newton_recentre(s, in->M.n, x);
  lcp_loop_begin(&s->loop, p, false);
}

/* How far off the start point is, 1 at most: rho, or, where facets are folded, |F| over |x|. Their rho is near 1 until all is
 * solved, since sigma is nothing beside the impulses that its row is made of. */
static double off_at_start(cone_newton *s, const lcp_problem *p, const double *x, const double *w,
                           double rho) {
  const int n = lcp_cone_newton_inner(s, p)->M.n;
  double size = 0.0;
  const double bare = sqrt(lcp_cone_newton_merit(s, n, 0.0, x, w, false));
  for (int i = 0; i < n; i++) {
    size += s->x[i] * s->x[i];
  }
  const double off = fmin(1.0, rho);
  return (s->fold.done && size > 0.0) ? fmin(off, bare / sqrt(size)) : off;
}

/* Of the first outer step. */
static double first_weight(const cone_newton_options *o, double off) {
  const double low = fmax(cone_newton_least_weight, 10.0 * DBL_EPSILON / off);
  return fmin(fmax(o->weight * off, low), o->weight);
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const cone_newton_options *o = opt;
  cone_newton *s = st;
  const size_t bytes = (size_t)p->M.n * sizeof *z;
  double *x = s->fold.done ? s->inner : z, *w = s->fold.done ? s->w : s->loop.stop.w;
  double best = HUGE_VAL;
  bool fresh;
  base_status status = BASE_OK;
  begin(s, o, p, z, x);
  for (bool first = true;; first = false) {
    show(s, x, w, z, res);
    if (lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
      break;
    }
    if (fresh && res->residual < best) {
      best = res->residual;
      memcpy(s->best, z, bytes);
    } else if (!fresh && !s->fold.done) {
      lcp_cone_newton_velocities(s, p, z, w, res);
    }
    if (first) {
      s->weight = first_weight(o, off_at_start(s, p, x, w, res->residual));
    }
    if (!advance_and_step(s, o, p, w, x, res, &status)) {
      break;
    }
  }
  if (res->outcome == LCP_SOLVED) {
    status = finish(s, o, p, x, z, res);
  } else if (res->outcome != LCP_INFEASIBLE &&
             (best < res->residual || res->residual != res->residual)) {
    memcpy(z, s->best, bytes);
    res->residual = best;
  }
  return status;
}

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  lcp_cone_newton_layout(st, cap, a);
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  return lcp_cone_newton_prepare(st, p, err);
}

static void release(void *st) {
  lcp_cone_newton_release(st);
}

const lcp_solver lcp_solver_cone_newton = {
    .name = "cone_newton",
    .title = "Proximal Newton on cones",
    .cite = "alart1991; fukushima2002; rockafellar1976",
    .words = "Newton steps on the round cone, kept regular by a spring to the last answer.",
    .when = "The round cone: stacks, redundant contacts, tight tolerances.",
    .sets = (1u << LCP_CONE) | (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .newton = true,
    .by_factors = true,
    .warm = true,
    .allocates = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
    .release = release,
};
