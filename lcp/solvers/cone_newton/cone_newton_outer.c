/* cone_newton_outer.c - the outer steps: when one ends, the weight of the next, and the proof that an infeasible problem leaves. */
#include "lcp/solvers/cone_newton/cone_newton.h"

#include <float.h>
#include <string.h>

enum { PATIENCE = 6, ROUNDED = 60 /* most outer steps of a solve that end at rounding */ };
static const double slowest = 0.7;

void lcp_cone_newton_velocities(const cone_newton *s, const lcp_problem *p, const double *z,
                                double *w, lcp_result *res) {
  lcp_matrix_apply(&p->M, z, p->q, w, s->loop.stop.scratch);
  res->work.matvecs++;
}

double lcp_cone_newton_merit(cone_newton *s, int n, double weight, const double *z, const double *w,
                             bool slope) {
  for (int i = 0; i < n; i++) {
    s->x[i] = z[i] / s->eq.s[i];
    s->y[i] = w[i] * s->eq.s[i] + weight * (s->x[i] - s->center[i]);
  }
  return lcp_cone_scaled_map(&s->eq, s->map, s->x, s->y, slope);
}

void lcp_cone_newton_recentre(cone_newton *s, int n, const double *z) {
  for (int i = 0; i < n; i++) {
    s->center[i] = z[i] / s->eq.s[i];
  }
  s->started = false;
}

void lcp_cone_newton_stalled(cone_newton *s, const cone_newton_options *o, lcp_result *res) {
  s->weight = fmin(10.0 * s->weight, cone_newton_most_weight);
  s->shrink = fmin(pow(s->shrink, 0.8), fmax(o->shrink, slowest));
  s->map = (s->map == LCP_MAP_FISCHER) ? LCP_MAP_MIN : LCP_MAP_FISCHER;
  res->work.fallbacks++;
}

static void unfold_kinds(cone_newton *s, const lcp_problem *p) {
  for (int k = 0; k < p->n_block; k++) {
    const lcp_block *b = &p->block[k];
    memset(s->kind + b->start, (b->set == LCP_FREE) ? LCP_FARKAS_FREE : LCP_FARKAS_SIGNED,
           (size_t)b->size);
  }
}

/* Has z run to four times the largest impulse of the outer step's centre, and do the normal parts of the way prove that no w
 * is feasible? */
static bool proved_infeasible(cone_newton *s, const lcp_problem *p, const double *z) {
  double here = 0.0, before = 0.0;
  for (int i = 0; i < lcp_cone_newton_inner(s, p)->M.n; i++) {
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
static void turn_back(cone_newton *s, const lcp_problem *p, double *z, double *w, lcp_result *res) {
  for (int i = 0; i < p->M.n; i++) {
    z[i] = s->eq.s[i] * s->center[i];
  }
  lcp_cone_newton_velocities(s, p, z, w, res);
}

/* |F|^2 of the outer step is the rounding of its sums. */
static bool is_rounding(const cone_newton *s, int n, double now) {
  double size = 0.0;
  for (int i = 0; i < n; i++) {
    size += s->x[i] * s->x[i];
  }
  return now <= 64.0 * DBL_EPSILON * DBL_EPSILON * size;
}

double lcp_cone_newton_advance(cone_newton *s, const cone_newton_options *o, const lcp_problem *p,
                               double *z, double *w, lcp_result *res) {
  const int n = lcp_cone_newton_inner(s, p)->M.n;
  const double bare = lcp_cone_newton_merit(s, n, 0.0, z, w, false);
  double now = lcp_cone_newton_merit(s, n, s->weight, z, w, true);
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
    s->weight = fmax(s->shrink * s->weight, cone_newton_least_weight);
  } else if (s->waited >= PATIENCE) {
    lost = s->fold.done && s->bare < bare && s->weight < cone_newton_most_weight;
    lcp_cone_newton_stalled(s, o, res);
  }
  if (lost) {
    turn_back(s, lcp_cone_newton_inner(s, p), z, w, res);
  } else if (reached || s->waited >= PATIENCE) {
    s->bare = bare;
  }
  if (reached || s->waited >= PATIENCE) {
    lcp_cone_newton_recentre(s, n, z);
    now = lcp_cone_newton_merit(s, n, s->weight, z, w, true);
  }
  const bool gained = !s->started || now < 0.64 * s->lowest;
  s->waited = gained ? 0 : s->waited + 1;
  s->lowest = gained ? now : s->lowest;
  s->started = true;
  return now;
}
