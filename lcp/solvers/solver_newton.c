/* solver_newton.c - semismooth Newton on the complementarity equations, globalised.
 *
 * In the variables x = z / s, y = s w (s_i^2 M_ii = 1) a row is one equation F_i = 0:
 *   orthant  phi(x, y),  phi(a, b) = a + b - sqrt(a^2 + b^2)          Fischer-Burmeister
 *            or min(x, y)                                              min-map
 *   box      phi(x - lo, -phi(hi - x, -y))                             Billups 1995
 *   free     y
 * A Newton step solves (D_a + D_b s M s) d = -F with D_a, D_b an element of the generalised gradient.
 *   map=fischer  De Luca, Facchinei & Kanzow 1996: d or, where d does not descend enough, the negative
 *                gradient of |F|^2/2; Armijo, nonmonotone over 5 values.
 *   map=min      first the min-map step, taken whole where it brings |F| of Fischer-Burmeister below
 *                0.9 of its smallest value so far (it ends exactly, on an active set); otherwise as
 *                above.
 * A Jacobian that is singular to working precision is replaced by that of M + e D for the direction
 * only (Facchinei & Pang 2003, section 9.1; nonsingular for P0 matrices), e = 1e-10 ... 0.1, counted in
 * `fallbacks`; F itself is never changed. Linear solves: dense LU or KLU. */
#include "lcp/lcp_column.h"
#include "lcp/linear/direct.h"
#include "lcp/solvers/interval_map.h"
#include "lcp/solvers/loop.h"
#include "lcp/solvers/sets.h"

#include <string.h>

enum { MEMORY = 5 };

typedef struct options {
  lcp_stop stop;
  int map;
} options;

static const base_field fields[] = {
    LCP_STOP_FIELDS(options, 1e-12, 200),
    BASE_FIELD_CHOICE(options, map, "fischer|min", LCP_MAP_MIN, "complementarity function"),
};

typedef struct state {
  lcp_loop loop;
  lcp_direct direct;
  double *lo, *hi; /* n, in x */
  double *s;       /* n, scaling */
  double *w;       /* n, M z + q */
  double *F;       /* n */
  double *da, *db; /* n, generalised gradient by x and y */
  double *d;       /* n, direction in x */
  double *trial;   /* n, z */
  double *wt;      /* n, w of the trial */
  double *g;       /* n, gradient of |F|^2/2 in x */
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  lcp_direct_layout(&s->direct, cap, a);
  double **const arrays[] = {&s->lo, &s->hi, &s->s, &s->w,     &s->F, &s->da,
                             &s->db, &s->d,  &s->g, &s->trial, &s->wt};
  for (int i = 0; i < BASE_COUNT(arrays); i++) {
    *arrays[i] = BASE_ARRAY(a, double, cap->n);
  }
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt, (void)err;
  state *s = st;
  lcp_direct_begin(&s->direct);
  lcp_matrix_diagonal(&p->M, s->d);
  lcp_set_scaling(&p->M, s->d, s->s);
  lcp_set_intervals(p, s->lo, s->hi);
  for (int i = 0; i < p->M.n; i++) {
    s->lo[i] /= s->s[i];
    s->hi[i] /= s->s[i];
  }
  return BASE_OK;
}

/* F with da, db at z; returns |F|^2 / 2. */
static double evaluate(state *s, int n, lcp_map map, const double *z, const double *w) {
  double sum = 0.0;
  for (int i = 0; i < n; i++) {
    s->F[i] = lcp_interval_map(map, s->lo[i], s->hi[i], z[i] / s->s[i], w[i] * s->s[i], &s->da[i],
                               &s->db[i]);
    sum += 0.5 * s->F[i] * s->F[i];
  }
  return sum;
}

static double merit(const state *s, int n, const double *z, const double *w) {
  double sum = 0.0, dx, dy;
  for (int i = 0; i < n; i++) {
    const double F = lcp_interval_map(LCP_MAP_FISCHER, s->lo[i], s->hi[i], z[i] / s->s[i],
                                      w[i] * s->s[i], &dx, &dy);
    sum += 0.5 * F * F;
  }
  return sum;
}

/* d = -(D_a + D_b s M s)^-1 F; a perturbed Jacobian where this one is singular. */
static bool direction(state *s, const lcp_problem *p, lcp_result *res, base_status *status) {
  const int n = p->M.n;
  for (int i = 0; i < n; i++) {
    s->g[i] = s->db[i] * s->s[i];
  }
  static const double perturbation[] = {0.0, 1e-10, 1e-7, 1e-4, 0.1};
  for (int k = 0; k < BASE_COUNT(perturbation); k++) {
    for (int i = 0; k > 0 && i < n; i++) {
      s->da[i] += perturbation[k] * s->db[i];
    }
    res->work.factorizations++;
    if (lcp_direct_factor(&s->direct, &p->M, NULL, s->da, s->g, s->s, status)) {
      for (int i = 0; i < n; i++) {
        s->d[i] = -s->F[i];
      }
      lcp_direct_solve(&s->direct, n, s->d);
      res->work.backsolves++;
      return true;
    }
    if (*status != BASE_OK) {
      return false;
    }
    res->work.fallbacks++;
  }
  return false;
}

/* trial = z + t s d and its w; returns the merit. */
static double probe(state *s, const lcp_problem *p, const double *z, double t, lcp_result *res) {
  const int n = p->M.n;
  for (int i = 0; i < n; i++) {
    s->trial[i] = z[i] + t * s->s[i] * s->d[i];
  }
  lcp_matrix_apply(&p->M, s->trial, p->q, s->wt, s->loop.stop.scratch);
  res->work.matvecs++;
  return merit(s, n, s->trial, s->wt);
}

/* g = V'F with V = D_a + D_b s M s, by columns. */
static void gradient(state *s, const lcp_problem *p) {
  const int n = p->M.n;
  for (int j = 0; j < n; j++) {
    const lcp_column c = lcp_column_of(&p->M, j);
    double sum = 0.0;
    for (int k = 0; k < c.count; k++) {
      const int i = lcp_column_row(&c, k);
      sum += c.val[k] * s->s[i] * s->db[i] * s->F[i];
    }
    s->g[j] = s->da[j] * s->F[j] + s->s[j] * sum;
  }
}

/* The accepted z clipped into K, if that passes the test as well. */
static void clip(state *s, const options *o, const lcp_problem *p, double *z, lcp_result *res) {
  lcp_result again = *res;
  for (int i = 0; i < p->M.n; i++) {
    s->trial[i] = lcp_set_clip(z[i], s->lo[i] * s->s[i], s->hi[i] * s->s[i]);
  }
  const lcp_stop now = {o->stop.tol, o->stop.max_iter, 1, o->stop.max_seconds};
  if (lcp_loop_ended(&s->loop, &now, p, s->trial, NULL, &again, NULL) &&
      again.outcome == LCP_SOLVED) {
    memcpy(z, s->trial, (size_t)p->M.n * sizeof *z);
    *res = again;
  }
}

static double dot(int n, const double *a, const double *b) {
  double sum = 0.0;
  for (int i = 0; i < n; i++) {
    sum += a[i] * b[i];
  }
  return sum;
}

/* Armijo along d from z, where the last values allow at most `top`. False: no step is left. */
static bool search(state *s, const lcp_problem *p, double *z, double top, double slope,
                   lcp_result *res) {
  double t = 1.0;
  for (int k = 0; k < 50; k++) {
    if (probe(s, p, z, t, res) <= top + 1e-4 * t * slope) {
      memcpy(z, s->trial, (size_t)p->M.n * sizeof *z);
      return true;
    }
    t *= 0.5;
    res->work.linesearches++;
  }
  return false;
}

/* One Fischer-Burmeister step. False: stuck. */
static bool fischer_step(state *s, const lcp_problem *p, double *z, double top, lcp_result *res,
                         base_status *status) {
  const int n = p->M.n;
  (void)evaluate(s, n, LCP_MAP_FISCHER, z, s->w);
  bool newton = direction(s, p, res, status);
  if (*status != BASE_OK) {
    return false;
  }
  (void)evaluate(s, n, LCP_MAP_FISCHER, z, s->w); /* D_a without the perturbation */
  gradient(s, p);
  double slope = newton ? dot(n, s->g, s->d) : 0.0;
  const double size = newton ? sqrt(dot(n, s->d, s->d)) : 0.0;
  newton = newton && slope <= -1e-10 * size * sqrt(size); /* rho |d|^p, p > 2 in the paper */
  if (newton && search(s, p, z, top, slope, res)) {
    return true;
  }
  for (int i = 0; i < n; i++) {
    s->d[i] = -s->g[i];
  }
  slope = -dot(n, s->g, s->g);
  res->work.fallbacks++;
  return slope < 0.0 && search(s, p, z, top, slope, res);
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  const int n = p->M.n;
  base_status status = BASE_OK;
  double past[MEMORY], least = HUGE_VAL;
  bool fresh;
  res->variant = (o->map == LCP_MAP_FISCHER) ? "fischer" : "min";
  for (int i = 0; i < n; i++) { /* from K: outside, where M z + q = 0, rho has no scale */
    z[i] = lcp_set_clip(z[i], s->lo[i] * s->s[i], s->hi[i] * s->s[i]);
  }
  lcp_loop_begin(&s->loop, p, false);
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
    lcp_loop_product(&s->loop, p, z, fresh, s->w, res);
    const double now = merit(s, n, z, s->w);
    least = fmin(least, now);
    past[res->work.iterations % MEMORY] = now;
    double top = now;
    for (long i = 0; i < MEMORY && i <= res->work.iterations; i++) {
      top = fmax(top, past[i]);
    }
    res->work.iterations++;
    if (o->map == LCP_MAP_MIN) {
      (void)evaluate(s, n, LCP_MAP_MIN, z, s->w);
      if (direction(s, p, res, &status) && probe(s, p, z, 1.0, res) <= 0.81 * least) {
        memcpy(z, s->trial, (size_t)n * sizeof *z);
        continue;
      }
    }
    if (status == BASE_OK && !fischer_step(s, p, z, top, res, &status)) {
      res->outcome = LCP_STALLED;
      return status;
    }
    if (status != BASE_OK) {
      return status;
    }
  }
  if (res->outcome == LCP_SOLVED) {
    clip(s, o, p, z, res);
  }
  return BASE_OK;
}

static void release(void *st) {
  lcp_direct_release(&((state *)st)->direct);
}

const lcp_solver lcp_solver_newton = {
    .name = "newton",
    .title = "Semismooth Newton",
    .cite = "deluca1996",
    .words = "Newton steps on equations with kinks.",
    .when = "Problems of middle size with a good start.",
    .sets = (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC),
    .newton = true,
    .warm = true,
    .allocates = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
    .release = release,
};
