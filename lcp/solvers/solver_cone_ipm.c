/* solver_cone_ipm.c - exact Coulomb friction by a primal-dual interior point with the scaling of Nesterov & Todd.
 *
 * In the scaled variables x, y of cone_scaled.h (M -> s M s, mean diagonal 1) the pairs of cone_barrier.h are kept inside
 * their cones and their products tau are driven to zero. A step, with one factor for two right sides:
 *
 *   (X + s M s + weight I) dx = -r + g,   dy = g - X dx,   r = s (M z + q) - y
 *   predictor  g for the product 0;   corrector  for sigma tau, less the predictor's product,  sigma = (tau_p / tau)^e,
 *              e = max(1, 3 t_p^2) with the step t_p that the predictor may take          (Mehrotra 1992)
 *
 * and of that 0.9 to 1 of the way to the boundary. X comes from the scaling (Nesterov & Todd 1998), the linear
 * system from cone_step.h: dense, CSC, or in the body velocities. r is never that of a problem made easier:
 *
 *   law=coulomb    Coulomb's law as two pairs a contact (Kanno, Martins & Pinto da Costa 2006)
 *   law=de_saxce   De Saxce's change of variable, its |y_t| inside the Newton system, as in Siconos' IPM SNM (Acary et al. 2019)
 *
 * Without friction the problem is monotone and the method the usual one. With friction the path tau -> 0 may have a fold, beyond which no
 * point of smaller tau is near: steps shorten to nothing. The weight is then raised tenfold and falls again with long steps, so
 * that the iterates follow the flow dx/dt = -r off the fold (proximal steps, Rockafellar 1976), while tau waits for r. No
 * proof of convergence exists.
 *
 * Products below 1e-12 are beyond doubles where neither of a pair vanishes in the limit: `polish=on` tries the modes of the
 * iterates as the answer's (cone_polish.h), each time that the products have come down, and where a step is short. */
#include "lcp/solvers/cone_barrier.h"
#include "lcp/solvers/cone_polish.h"
#include "lcp/solvers/cone_step.h"
#include "lcp/solvers/loop.h"

#include <string.h>

enum { OFF, ON };       /* polish */
enum { PATIENCE = 10 }; /* iterations without 0.8 of the lowest error */
static const double least_weight = 1e-12, first_weight = 0.1, most_weight = 10.0;
static const double short_step = 0.1, long_step = 0.7, no_step = 1e-14;

typedef struct options {
  lcp_stop stop;
  int law, polish;
  double weight, shrink;
} options;

static const base_field fields[] = {
    LCP_STOP_FIELDS(options, 1e-10, 500),
    BASE_FIELD_CHOICE(options, law, "de_saxce|coulomb", LCP_LAW_COULOMB, "how a contact is met"),
    BASE_FIELD_CHOICE(options, polish, "off|on", ON, "modes solved to rounding"),
    BASE_FIELD(options, weight, BASE_REAL, "1", 1e-3, 1e-12, 10, "proximal weight of a long step"),
    BASE_FIELD(options, shrink, BASE_REAL, "1", 0.1, 1e-3, 0.9, "factor of a raised weight"),
};

typedef struct state {
  lcp_loop loop;
  lcp_cone_scaled eq;
  lcp_cone_step step;
  lcp_cone_polish polish;
  lcp_barrier barrier;
  double *w;                 /* n, diagonal; then scaled */
  double size;               /* of the data, scaled */
  double raised;             /* weight, 0: as the option says */
  double off, lowest, tried; /* max(|r|, sqrt(tau)) / size: now, least, at the last polish */
  int waited;                /* iterations since the least */
  bool jammed;
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  const options *o = opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  lcp_cone_scaled_layout(&s->eq, cap, a);
  lcp_cone_step_layout(&s->step, cap, a);
  lcp_barrier_layout(&s->barrier, cap, a);
  s->w = BASE_ARRAY(a, double, cap->n);
  if (o->polish == ON) {
    lcp_cone_polish_layout(&s->polish, cap, a);
  }
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  const options *o = opt;
  state *s = st;
  lcp_matrix_diagonal(&p->M, s->w);
  BASE_TRY(lcp_cone_scaled_begin(&s->eq, p, s->w, NULL, err));
  BASE_TRY(lcp_cone_step_prepare(&s->step, p, &s->eq, err));
  return (o->polish == ON) ? lcp_cone_polish_prepare(&s->polish, p, err) : BASE_OK;
}

static void raise_weight(state *s) {
  s->raised = fmin(fmax(10.0 * s->raised, first_weight), most_weight);
  s->jammed = true;
}

/* The errors at z with w = M z + q; returns tau. */
static double measure(state *s, int n, const double *w, lcp_work *work) {
  for (int i = 0; i < n; i++) {
    s->w[i] = w[i] * s->eq.s[i];
  }
  const double tau = lcp_barrier_gap(&s->barrier, &s->eq, 0.0);
  s->off = fmax(lcp_barrier_residual(&s->barrier, &s->eq, s->w), sqrt(tau)) / s->size;
  const bool gained = s->off < 0.8 * s->lowest;
  s->waited = gained ? 0 : s->waited + 1;
  s->lowest = gained ? s->off : s->lowest;
  if (s->waited > PATIENCE) {
    raise_weight(s);
    s->waited = 0;
    s->lowest = s->off;
    work->fallbacks++;
  }
  return tau;
}

static void directions(state *s, const lcp_problem *p, lcp_work *work) {
  lcp_cone_step_solve(&s->step, p, &s->eq, s->barrier.dx, work);
  lcp_barrier_directions(&s->barrier, &s->eq);
}

/* The directions of a step by the factor at hand; returns the product of the predictor over tau. */
static double predict_and_correct(state *s, const lcp_problem *p, double tau, lcp_work *work) {
  lcp_barrier *b = &s->barrier;
  lcp_barrier_target(b, &s->eq, 0.0, false);
  directions(s, p, work);
  if (!(tau > 0.0)) {
    return 0.0; /* joints alone */
  }
  const double step = fmin(1.0, lcp_barrier_longest(b, &s->eq));
  const double ahead = fmax(0.0, lcp_barrier_gap(b, &s->eq, step) / tau);
  double sigma = fmin(1.0, pow(ahead, fmax(1.0, 3.0 * step * step)));
  if (s->raised > 0.0) {
    const double r = lcp_barrier_residual(b, &s->eq, s->w);
    sigma = fmax(sigma, fmin(1.0, r * r / tau));
  }
  lcp_barrier_target(b, &s->eq, sigma * tau, true);
  directions(s, p, work);
  return ahead;
}

/* One step from z with w = M z + q. False: there is none, or *status says no memory. */
static bool advance(state *s, const options *o, const lcp_problem *p, const double *w,
                    lcp_work *work, base_status *status) {
  lcp_barrier *b = &s->barrier;
  const double tau = measure(s, p->M.n, w, work);
  const double usual = o->weight * fmin(1.0, sqrt(tau) / s->size);
  const double weight = fmax(s->raised, fmax(usual, least_weight));
  lcp_barrier_linearise(b, &s->eq);
  if (!lcp_cone_step_factor(&s->step, p, &s->eq, weight, work, status)) {
    return false;
  }
  const double ahead = predict_and_correct(s, p, tau, work);
  const double share = fmax(0.9, 1.0 - fmax(1e-6, 0.1 * fmin(1.0, ahead)));
  const double t = fmin(1.0, share * lcp_barrier_longest(b, &s->eq));
  const double next = lcp_barrier_gap(b, &s->eq, t);
  if (!(t > no_step) || !isfinite(next) || (tau > 0.0 && !(next > 0.0))) {
    return false;
  }
  if (t < short_step) {
    raise_weight(s);
  } else if (t > long_step) {
    s->raised = (o->shrink * s->raised > usual) ? o->shrink * s->raised : 0.0;
  }
  lcp_barrier_move(b, p->M.n, t);
  return true;
}

static void show(const state *s, int n, double *z) {
  for (int i = 0; i < n; i++) {
    z[i] = s->barrier.x[i] * s->eq.s[i];
  }
}

static void begin(state *s, const options *o, const lcp_problem *p) {
  lcp_loop_begin(&s->loop, p, false);
  s->size = (s->loop.q_size > 0.0) ? s->loop.q_size : 1.0;
  s->raised = 0.0;
  s->off = s->tried = 1.0;
  s->lowest = HUGE_VAL;
  s->waited = 0;
  s->jammed = false;
  lcp_barrier_start(&s->barrier, &s->eq, (lcp_law)o->law, s->size);
  if (o->polish == ON) {
    lcp_cone_polish_begin(&s->polish);
  }
}

/* After a residual test at z: are its modes the answer's? */
static bool polished(state *s, const options *o, const lcp_problem *p, double *z, lcp_result *res,
                     base_status *status) {
  if (o->polish == OFF || !(s->jammed || s->off < 0.3 * s->tried)) {
    return false;
  }
  s->tried = s->jammed ? s->tried : s->off;
  s->jammed = false;
  s->polish.next = 0;
  return lcp_cone_polish_try(&s->polish, &s->loop, &o->stop, p, 1.0, NULL, z, res, status);
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  base_status status = BASE_OK;
  bool fresh, started = false;
  begin(s, o, p);
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
    if (!started) {
      show(s, p->M.n, z);
    } else if (fresh && polished(s, o, p, z, res, &status)) {
      break;
    }
    started = true;
    lcp_matrix_apply(&p->M, z, p->q, s->loop.stop.w, s->loop.stop.scratch);
    res->work.matvecs++;
    if (status != BASE_OK || !advance(s, o, p, s->loop.stop.w, &res->work, &status)) {
      res->outcome = LCP_STALLED;
      break;
    }
    show(s, p->M.n, z);
    res->work.iterations++;
  }
  return status;
}

static void release(void *st) {
  state *s = st;
  lcp_cone_step_release(&s->step);
  lcp_cone_polish_release(&s->polish);
}

const lcp_solver lcp_solver_cone_ipm = {
    .name = "cone_ipm",
    .title = "Interior point on cones",
    .cite = "nesterov1998; mehrotra1992; kanno2006; acary2019, GFC3D IPM SNM",
    .words = "Newton steps through the inside of the round cones, towards their boundary.",
    .when = "The round cone, to hold an interior point against Newton steps on the boundary.",
    .sets = (1u << LCP_CONE) | (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .newton = true,
    .by_factors = true,
    .allocates = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
    .release = release,
};
