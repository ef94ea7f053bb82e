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
 *     whole then, the map is alart_curnier whatever `map` says, since fischer loses a small number beside a large one, and third-order rounding is zero.
 *   - t = 1, 1/2, 1/4 by Armijo's rule on |F|; where all are refused the whole step is taken: a Newton step that a
 *     kink of F stops (a contact about to stick or slip) is not mended by a short one. On 1000 random sets
 *     (tests/bench/bench_cone.c) 46 steps on the mean for 123 with steps down to 2^-10, 1 set left open for 18.
 *   - six steps without a new lowest |F| of four fifths of the last: stalled. The weight is raised tenfold, shrinks more slowly from
 *     then on (shrink^0.8), and the other map takes over; counted in `fallbacks`. So is a singular system.
 *
 * Of an infeasible problem the proximal points run away along a y with y'w < 0 (Rockafellar 1976, theorem 1): the normal
 * parts of an outer step's way are tried as a Farkas vector where it made z four times as large. */
#include "lcp/lcp_farkas.h"
#include "lcp/solvers/cone_step.h"
#include "lcp/solvers/data_test.h"
#include "lcp/solvers/facet_fold.h"
#include "lcp/solvers/loop.h"
#include "lcp/solvers/sets.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

enum { ALART_CURNIER, FISCHER }; /* option */
enum { PATIENCE = 6, ROUNDED = 60 /* most outer steps of a solve that end at rounding */ };
static const double least_weight = 1e-12, most_weight = 10.0, slowest = 0.7;

typedef struct options {
  lcp_stop stop;
  int map;
  double weight, shrink;
} options;

static const base_field fields[] = {
    LCP_STOP_FIELDS(options, 1e-10, 2000),
    BASE_FIELD_CHOICE(options, map, "alart_curnier|fischer", ALART_CURNIER,
                      "first complementarity function"),
    BASE_FIELD(options, weight, BASE_REAL, "1", 0.1, 1e-12, 10, "first proximal weight"),
    BASE_FIELD(options, shrink, BASE_REAL, "1", 0.1, 1e-3, 0.9, "factor of the weight"),
};

typedef struct state {
  lcp_loop loop;
  lcp_cone_scaled eq;
  lcp_cone_step step;
  double *x, *y;  /* n, where F is taken */
  double *center; /* n, in x */
  double *dx;     /* n */
  double *trial;  /* n, z */
  double *wt;     /* n, w of the trial */
  double *best;   /* n, z of the smallest residual */
  double *proof;  /* n, Farkas vector */
  lcp_fold fold; /* facets are solved folded: all above but `best` is of the folded problem then, */
  double *inner, *w;     /* n: the iterate there, its w */
  double *shown;         /* n: what a trial is unfolded */
  unsigned char *kind;   /* n, of lcp_farkas.h */
  lcp_farkas_sum *force; /* n_dof */
  /* of the outer step */
  lcp_map map;
  double weight, shrink;
  double bare;   /* |F|^2 without the weight at the centre */
  double lowest; /* |F|^2 */
  int waited;    /* steps since */
  int rounded;   /* outer steps of this solve that ended at rounding */
  bool started;
  bool blind;           /* |F| is rounding */
  int n_inner;          /* unknowns that the arrays of the inner problem have room for */
  void *wide;           /* owned: those arrays where facets did not fold that could, */
  struct state *narrow; /* owned: and the state to come back to; NULL otherwise */
} state;

/* What is of the size of the problem that is solved. */
static void layout_inner(state *s, const lcp_capacity *cap, base_arena *a) {
  s->n_inner = cap->n;
  lcp_cone_scaled_layout(&s->eq, cap, a);
  lcp_cone_step_layout(&s->step, cap, a);
  double **const arrays[] = {&s->x, &s->y, &s->center, &s->dx, &s->trial, &s->wt, &s->inner, &s->w};
  for (int i = 0; i < BASE_COUNT(arrays); i++) {
    *arrays[i] = BASE_ARRAY(a, double, cap->n);
  }
}

static void layout_proof(state *s, const lcp_capacity *cap, base_arena *a) {
  s->force = BASE_ARRAY(a, lcp_farkas_sum, cap->n_dof);
  s->proof = BASE_ARRAY(a, double, cap->n);
  s->kind = BASE_ARRAY(a, unsigned char, cap->n);
}

/* A proof is tried where an outer step ends: X and Y are made anew behind it, or not needed any more. */
static void place_proof(state *s, const lcp_capacity *cap, base_arena *a) {
  const size_t room = 2 * (size_t)s->n_inner * (size_t)LCP_CONE_MAX * sizeof *s->eq.X;
  base_arena measure = base_arena_measuring(), over = base_arena_over(s->eq.X, room);
  layout_proof(s, cap, &measure);
  layout_proof(s, cap, (measure.used <= room) ? &over : a);
}

/* What is shown is tested, and taken or not, before the step behind it makes X and Y anew. */
static void place_shown(state *s, const lcp_capacity *cap, base_arena *a) {
  const bool fits = (size_t)cap->n <= 2 * (size_t)s->n_inner * (size_t)LCP_CONE_MAX;
  s->shown = fits ? s->eq.X : BASE_ARRAY(a, double, cap->n);
}

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  state *s = st;
  lcp_capacity inner = *cap;
  inner.n = (cap->n_folded > 0) ? cap->n_folded : cap->n;
  inner.n_jac = (cap->n_folded > 0) ? cap->n_jac_folded : cap->n_jac;
  lcp_loop_layout(&s->loop, cap, a);
  s->best = BASE_ARRAY(a, double, cap->n);
  layout_inner(s, &inner, a);
  /* from here on problems without facets touch nothing, so that the pages they touch lie together */
  lcp_fold_layout(&s->fold, cap, a);
  place_proof(s, cap, a);
  place_shown(s, cap, a);
}

/* The problem that is solved: p, or p with its facets folded. */
static const lcp_problem *inner_of(const state *s, const lcp_problem *p) {
  return s->fold.done ? &s->fold.p : p;
}

static base_status prepare_inner(state *s, const lcp_problem *p, const int *facets,
                                 base_error *err) {
  lcp_matrix_diagonal(&p->M, s->dx);
  BASE_TRY(lcp_cone_scaled_begin(&s->eq, p, s->dx, facets, err));
  return lcp_cone_step_prepare(&s->step, p, &s->eq, err);
}

/* Room for all unknowns where facets stay what they are, until the release. */
static base_status widen(state *s, const lcp_problem *p, base_error *err) {
  const lcp_capacity cap = lcp_problem_capacity(p);
  state laid = *s;
  base_arena measure = base_arena_measuring();
  layout_inner(&laid, &cap, &measure);
  state *narrow = malloc(sizeof *narrow);
  void *wide = measure.overflow ? NULL : base_alloc(measure.used);
  if (narrow == NULL || wide == NULL) {
    free(narrow);
    free(wide);
    return BASE_FAIL(err, BASE_ENOMEM, "cone_newton: no memory for %d unknowns as they are", cap.n);
  }
  *narrow = *s;
  base_arena real = base_arena_over(wide, measure.used);
  layout_inner(s, &cap, &real);
  s->narrow = narrow;
  s->wide = wide;
  return BASE_OK;
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  state *s = st;
  lcp_fold_begin(&s->fold, p);
  if (s->fold.done && prepare_inner(s, &s->fold.p, s->fold.facets, err) == BASE_OK) {
    return BASE_OK;
  }
  s->fold.done =
      false; /* a friction without mobility is no cone, but its facets are rows like others */
  if (p->M.n > s->n_inner) {
    lcp_cone_step_release(&s->step);
    BASE_TRY(widen(s, p, err));
  }
  return prepare_inner(s, p, NULL, err);
}

/* w = M z + q. */
static void velocities(const state *s, const lcp_problem *p, const double *z, double *w,
                       lcp_result *res) {
  lcp_matrix_apply(&p->M, z, p->q, w, s->loop.stop.scratch);
  res->work.matvecs++;
}

/* What the iterate x of the inner problem is in p: z itself, or unfolded with w. */
static void show(state *s, const double *x, double *w, double *z, lcp_result *res) {
  if (s->fold.done) {
    velocities(s, &s->fold.p, x, w, res);
    lcp_fold_out(&s->fold, x, w, s->eq.s, z);
  }
}

/* |F|^2 at z with w = M z + q and this weight; F stays, with `slope` its derivatives too. */
static double merit(state *s, int n, double weight, const double *z, const double *w, bool slope) {
  for (int i = 0; i < n; i++) {
    s->x[i] = z[i] / s->eq.s[i];
    s->y[i] = w[i] * s->eq.s[i] + weight * (s->x[i] - s->center[i]);
  }
  return lcp_cone_scaled_map(&s->eq, s->map, s->x, s->y, slope);
}

static void recentre(state *s, int n, const double *z) {
  for (int i = 0; i < n; i++) {
    s->center[i] = z[i] / s->eq.s[i];
  }
  s->started = false;
}

static void stalled(state *s, const options *o, lcp_result *res) {
  s->weight = fmin(10.0 * s->weight, most_weight);
  s->shrink = fmin(pow(s->shrink, 0.8), fmax(o->shrink, slowest));
  s->map = (s->map == LCP_MAP_FISCHER) ? LCP_MAP_MIN : LCP_MAP_FISCHER;
  res->work.fallbacks++;
}

static void unfold_kinds(state *s, const lcp_problem *p) {
  for (int k = 0; k < p->n_block; k++) {
    const lcp_block *b = &p->block[k];
    memset(s->kind + b->start, (b->set == LCP_FREE) ? LCP_FARKAS_FREE : LCP_FARKAS_SIGNED,
           (size_t)b->size);
  }
}

/* Has z run to four times the largest impulse of the outer step's centre, and do the normal parts of the way prove that no w
 * is feasible? */
static bool proved_infeasible(state *s, const lcp_problem *p, const double *z) {
  double here = 0.0, before = 0.0;
  for (int i = 0; i < inner_of(s, p)->M.n; i++) {
    here = fmax(here, fabs(z[i] / s->eq.s[i]));
    before = fmax(before, fabs(s->center[i]));
  }
  if (!(here > 4.0 * before) || (lcp_problem_sets(p) & (1u << LCP_BOX)) != 0) {
    return false;
  }
  for (int k = 0; k < s->eq.n_piece; k++) {
    const lcp_block *b = &s->eq.piece[k];
    for (int i = b->start; i < b->start + b->size; i++) {
      const double way = z[i] - s->eq.s[i] * s->center[i];
      const bool sideways = b->set == LCP_CONE && i > b->start;
      s->kind[i] = sideways ? LCP_FARKAS_SIDEWAYS
                            : ((b->set == LCP_FREE) ? LCP_FARKAS_FREE : LCP_FARKAS_SIGNED);
      s->proof[i] = sideways ? 0.0 : ((b->set == LCP_FREE) ? way : fmax(way, 0.0));
    }
  }
  if (s->fold.done) {
    memcpy(s->trial, s->proof, (size_t)s->fold.p.M.n * sizeof *s->proof);
    lcp_fold_out_rows(&s->fold, s->trial, s->proof);
    unfold_kinds(s, p);
  }
  return lcp_farkas_prove(&p->M, p->q, s->kind, s->force, s->proof);
}

/* z back to the centre, with its w. */
static void turn_back(state *s, const lcp_problem *p, double *z, double *w, lcp_result *res) {
  for (int i = 0; i < p->M.n; i++) {
    z[i] = s->eq.s[i] * s->center[i];
  }
  velocities(s, p, z, w, res);
}

/* |F|^2 of the outer step is the rounding of its sums. */
static bool is_rounding(const state *s, int n, double now) {
  double size = 0.0;
  for (int i = 0; i < n; i++) {
    size += s->x[i] * s->x[i];
  }
  return now <= 64.0 * DBL_EPSILON * DBL_EPSILON * size;
}

/* Where the outer step stands, before the next Newton step from z: on, or on to the next. Returns |F|^2.
 * Over facets an outer step that stalls farther off than it began starts again from its centre, with the larger weight: the map
 * has pieces, and iterates that are lost among them tell nothing. res->outcome turns LCP_INFEASIBLE where that is proved. */
static double advance(state *s, const options *o, const lcp_problem *p, double *z, double *w,
                      lcp_result *res) {
  const int n = inner_of(s, p)->M.n;
  const double bare = merit(s, n, 0.0, z, w, false);
  double now = merit(s, n, s->weight, z, w, true);
  s->blind = s->started && s->rounded < ROUNDED && is_rounding(s, n, now);
  const bool reached = s->started && (s->blind || now <= 0.01 * bare);
  bool lost = false;
  s->bare = (s->bare < HUGE_VAL) ? s->bare : bare; /* the start point is the first centre */
  s->rounded += s->blind;
  s->map = s->blind ? LCP_MAP_MIN : s->map; /* the other loses what is small beside its neighbour */
  if (reached && proved_infeasible(s, p, z)) {
    res->outcome = LCP_INFEASIBLE;
    res->certificate = (lcp_certificate){.kind = LCP_CERT_FARKAS, .vector = s->proof};
    return now; /* with the proof where X and Y were */
  }
  if (reached) {
    s->weight = fmax(s->shrink * s->weight, least_weight);
  } else if (s->waited >= PATIENCE) {
    lost = s->fold.done && s->bare < bare && s->weight < most_weight;
    stalled(s, o, res);
  }
  if (lost) {
    turn_back(s, inner_of(s, p), z, w, res);
  } else if (reached || s->waited >= PATIENCE) {
    s->bare = bare;
  }
  if (reached || s->waited >= PATIENCE) {
    recentre(s, n, z);
    now = merit(s, n, s->weight, z, w, true);
  }
  const bool gained = !s->started || now < 0.64 * s->lowest;
  s->waited = gained ? 0 : s->waited + 1;
  s->lowest = gained ? now : s->lowest;
  s->started = true;
  return now;
}

/* Third-order rounding is zero: what rounding in M couples to a large impulse is of first order, and what that couples of second. */
static void drop_noise(const state *s, int n, double *z) {
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
static void search(state *s, const lcp_problem *p, double now, double *z, lcp_result *res) {
  static const double lengths[] = {1.0, 0.5, 0.25};
  const int n = p->M.n;
  double t = 1.0;
  for (int k = 0; k < BASE_COUNT(lengths) && !s->blind; k++) {
    for (int i = 0; i < n; i++) {
      s->trial[i] = z[i] + lengths[k] * s->eq.s[i] * s->dx[i];
    }
    velocities(s, p, s->trial, s->wt, res);
    const double shorter = 1.0 - 1e-4 * lengths[k];
    if (merit(s, n, s->weight, s->trial, s->wt, false) < shorter * shorter * now) {
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
static void into_polygons(const state *s, const lcp_block *b, double *x) {
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
static void project(const state *s, const double *z, double *to) {
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
static bool whole_step(state *s, const lcp_problem *p, double *z, lcp_result *res,
                       base_status *status) {
  velocities(s, p, z, s->wt, res);
  recentre(s, p->M.n, z);
  (void)merit(s, p->M.n, s->weight, z, s->wt, true);
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
static base_status finish(state *s, const options *o, const lcp_problem *p, const double *x,
                          double *z, lcp_result *res) {
  const lcp_stop now = {o->stop.tol, o->stop.max_iter, 1, o->stop.max_seconds};
  const lcp_problem *in = inner_of(s, p);
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
static bool advance_and_step(state *s, const options *o, const lcp_problem *p, double *w, double *x,
                             lcp_result *res, base_status *status) {
  const lcp_problem *in = inner_of(s, p);
  const double now = advance(s, o, p, x, w, res);
  if (res->outcome == LCP_INFEASIBLE) {
    return false;
  }
  res->work.iterations++;
  if (lcp_cone_step_factor(&s->step, in, &s->eq, s->weight, &res->work, status)) {
    lcp_cone_step_solve(&s->step, in, &s->eq, s->dx, &res->work);
    search(s, in, now, x, res);
  } else if (*status != BASE_OK || s->weight >= most_weight) {
    res->outcome = LCP_STALLED;
    return false;
  } else {
    stalled(s, o, res);
    recentre(s, in->M.n, x);
  }
  return true;
}

/* The start point in K: outside, where M z + q = 0, rho has no scale. */
static void begin(state *s, const options *o, const lcp_problem *p, double *z, double *x) {
  const lcp_problem *in = inner_of(s, p);
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
  recentre(s, in->M.n, x);
  lcp_loop_begin(&s->loop, p, false);
}

/* How far off the start point is, 1 at most: rho, or, where facets are folded, |F| over |x|. Their rho is near 1 until all is
 * solved, since sigma is nothing beside the impulses that its row is made of. */
static double off_at_start(state *s, const lcp_problem *p, const double *x, const double *w,
                           double rho) {
  const int n = inner_of(s, p)->M.n;
  double size = 0.0;
  const double bare = sqrt(merit(s, n, 0.0, x, w, false));
  for (int i = 0; i < n; i++) {
    size += s->x[i] * s->x[i];
  }
  const double off = fmin(1.0, rho);
  return (s->fold.done && size > 0.0) ? fmin(off, bare / sqrt(size)) : off;
}

/* Of the first outer step. */
static double first_weight(const options *o, double off) {
  const double low = fmax(least_weight, 10.0 * DBL_EPSILON / off);
  return fmin(fmax(o->weight * off, low), o->weight);
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
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
      velocities(s, p, z, w, res);
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

static void release(void *st) {
  state *s = st;
  lcp_cone_step_release(&s->step);
  if (s->narrow != NULL) {
    state *narrow = s->narrow;
    free(s->wide);
    *s = *narrow;
    free(narrow);
  }
}

const lcp_solver lcp_solver_cone_newton = {
    .name = "cone_newton",
    .title = "Proximal Newton on cones",
    .cite = "alart1991; fukushima2002; rockafellar1976",
    .words = "Newton steps on the round cone, kept regular by a spring to the last answer.",
    .when = "The round cone: stacks, redundant contacts, tight tolerances.",
    .sets = (1u << LCP_CONE) | (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .by_factors = true,
    .warm = true,
    .allocates = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
    .release = release,
};
