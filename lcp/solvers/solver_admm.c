/* solver_admm.c - exact Coulomb friction by the alternating direction method of multipliers.
 *
 * In the scaled variables x, y of cone_scaled.h (M -> s M s, mean diagonal 1), with a penalty rho:
 *
 *   v, g:  g = rho (v - t),  v and g obey the law              impulse and velocity, contact by contact
 *   x   :  (s M s + rho I) x = rho (2 v - t) - s q             the linear part
 *   t <- t + over (x - v)
 *
 * which is ADMM in the form of Douglas & Rachford (Boyd et al. 2011; Eckstein & Bertsekas 1992): t = v + u with the scaled multiplier
 * u. On orthants, boxes and free rows it is a monotone problem and converges; with friction no proof exists. The law of a cone:
 *
 *   law=de_saxce   v = P_K(t), and x sees sum mu |g_k| on its normal row: De Saxce's term follows g in every iteration
 *                  in the place of an outer loop (Acary, Bremond & Huber 2018, section 5.5)
 *   law=coulomb    the contact of matrix rho I solved exactly, which is Alart & Curnier's projection: v_n = max(0, t_n),
 *                  |v_k| <= mu_k v_n. Nothing lags behind: of 300 random sets 282 are solved for 271 (build/tests/bench_cone)
 *
 * Free rows (joints) see a thousandth of rho: they have no set to be projected on.
 *
 *   - the factor is reused until rho changes. Dense, CSC, and the factored form in the body velocities (cone_step.h).
 *   - rho is balanced where |rho (v - v_old)| / |g| and |x - v| / |v| are apart by more than five (Boyd et al. 2011, 3.4.1), by the root
 *     of their quotient, at iterations that grow by half.
 *   - `accelerate=anderson` mixes the steps of t (mixing.h).
 *   - `polish=on`: the modes of t are tried as the answer's (cone_polish.h). */
#include "lcp/lcp_cone.h"
#include "lcp/solvers/cone_polish.h"
#include "lcp/solvers/cone_step.h"
#include "lcp/solvers/loop.h"
#include "lcp/solvers/mixing.h"
#include "lcp/solvers/sets.h"

#include <string.h>

enum { PLAIN, ANDERSON };   /* accelerate */
enum { OFF, ON };           /* polish */
enum { DE_SAXCE, COULOMB }; /* law */
enum { FIRST_BALANCE = 10 };
static const double free_share = 1e-3, least_rho = 1e-6, most_rho = 1e6;

typedef struct options {
  lcp_stop stop;
  int accelerate, polish, law;
  double penalty, over;
} options;

static const base_field fields[] = {
    LCP_STOP_FIELDS_EVERY(options, 1e-8, 10000, 5),
    BASE_FIELD_CHOICE(options, accelerate, "none|anderson", ANDERSON, "mixing of the steps"),
    BASE_FIELD_CHOICE(options, polish, "off|on", ON, "modes solved to rounding"),
    BASE_FIELD_CHOICE(options, law, "de_saxce|coulomb", COULOMB, "how a contact is met"),
    BASE_FIELD(options, penalty, BASE_REAL, "1", 1.0, 1e-6, 1e6, "first rho, of the mean diagonal"),
    BASE_FIELD(options, over, BASE_REAL, "1", 1.6, 0.1, 1.95, "over-relaxation"),
};

typedef struct state {
  lcp_loop loop;
  lcp_cone_scaled eq;
  lcp_cone_step step;
  lcp_cone_polish polish;
  lcp_mixing mixing;
  double *t, *v, *g, *x, *move; /* n */
  double *before;               /* n: v of the iteration before */
  double *sq;                   /* n, s q */
  double rho;
  long next; /* iteration of the next balance */
} state;

static void layout(void *st, const lcp_capacity *cap, const void *opt, base_arena *a) {
  const options *o = opt;
  state *s = st;
  lcp_loop_layout(&s->loop, cap, a);
  lcp_cone_scaled_layout(&s->eq, cap, a);
  lcp_cone_step_layout(&s->step, cap, a);
  double **const arrays[] = {&s->t, &s->v, &s->g, &s->x, &s->move, &s->before, &s->sq};
  for (int i = 0; i < BASE_COUNT(arrays); i++) {
    *arrays[i] = BASE_ARRAY(a, double, cap->n);
  }
  if (o->polish == ON) {
    lcp_cone_polish_layout(&s->polish, cap, a);
  }
  if (o->accelerate == ANDERSON) {
    lcp_mixing_layout(&s->mixing, cap, a);
  }
}

static base_status prepare(void *st, const lcp_problem *p, const void *opt, base_error *err) {
  const options *o = opt;
  state *s = st;
  lcp_matrix_diagonal(&p->M, s->x);
  BASE_TRY(lcp_cone_scaled_begin(&s->eq, p, s->x, NULL, err));
  BASE_TRY(lcp_cone_step_prepare(&s->step, p, &s->eq, err));
  return (o->polish == ON) ? lcp_cone_polish_prepare(&s->polish, p, err) : BASE_OK;
}

static double penalty_of(const state *s, const lcp_block *b) {
  return (b->set == LCP_FREE) ? free_share * s->rho : s->rho;
}

/* Factors s M s + rho. False: singular, or *status says no memory. */
static bool factor(state *s, const lcp_problem *p, lcp_result *res, base_status *status) {
  for (int k = 0; k < s->eq.n_piece; k++) {
    const lcp_block *b = &s->eq.piece[k];
    double *X = s->eq.X + lcp_cone_scaled_at(&s->eq, b);
    double *Y = s->eq.Y + lcp_cone_scaled_at(&s->eq, b);
    for (int i = 0; i < b->size * b->size; i++) {
      const bool diagonal = i % (b->size + 1) == 0;
      X[i] = diagonal ? penalty_of(s, b) : 0.0;
      Y[i] = diagonal ? 1.0 : 0.0;
    }
  }
  return lcp_cone_step_factor(&s->step, p, &s->eq, 0.0, &res->work, status);
}

/* v with g = rho (v - t) as Coulomb's law has it between an impulse and its velocity, whatever rho: the contact takes off
 * or holds its normal, and its parts are cut to their circles. */
static void coulomb(const lcp_block *b, const double *t, double *v) {
  v[0] = fmax(t[0], 0.0);
  for (int k = 0, at = 1; k < b->n_part; at += b->part_dim[k++]) {
    const double length = (b->part_dim[k] == 2) ? hypot(t[at], t[at + 1]) : fabs(t[at]);
    const double bound = b->part_mu[k] * v[0];
    for (int i = at; i < at + b->part_dim[k]; i++) {
      v[i] = (length > bound) ? t[i] * (bound / length) : t[i];
    }
  }
}

/* v and g of t. */
static void split(state *s, const options *o) {
  for (int k = 0; k < s->eq.n_piece; k++) {
    const lcp_block *b = &s->eq.piece[k];
    const int at = b->start;
    if (b->set == LCP_CONE) {
      (o->law == COULOMB ? coulomb : lcp_cone_project)(b, s->t + at, s->v + at);
    } else {
      s->v[at] = lcp_set_clip(s->t[at], s->eq.lo[at], s->eq.hi[at]);
    }
    for (int i = at; i < at + b->size; i++) {
      s->g[i] = penalty_of(s, b) * (s->v[i] - s->t[i]);
    }
  }
}

/* x, and move = over (x - v). Returns |x - v|. */
static double linear(state *s, const options *o, const lcp_problem *p, lcp_result *res) {
  double sum = 0.0;
  for (int k = 0; k < s->eq.n_piece; k++) {
    const lcp_block *b = &s->eq.piece[k];
    const double rho = penalty_of(s, b);
    for (int i = b->start; i < b->start + b->size; i++) {
      s->eq.F[i] = s->sq[i] - rho * (2.0 * s->v[i] - s->t[i]);
    }
    if (b->set == LCP_CONE && o->law == DE_SAXCE) {
      s->eq.F[b->start] += lcp_cone_shift(b, s->g + b->start);
    }
  }
  lcp_cone_step_solve(&s->step, p, &s->eq, s->x, &res->work);
  for (int i = 0; i < p->M.n; i++) {
    const double way = s->x[i] - s->v[i];
    s->move[i] = o->over * way;
    sum += way * way;
  }
  return sqrt(sum);
}

/* t of v and g, after a change of rho. */
static void join(state *s) {
  for (int k = 0; k < s->eq.n_piece; k++) {
    const lcp_block *b = &s->eq.piece[k];
    for (int i = b->start; i < b->start + b->size; i++) {
      s->t[i] = s->v[i] - s->g[i] / penalty_of(s, b);
    }
  }
}

static void forget(state *s, const options *o, int n) {
  if (o->accelerate == ANDERSON) {
    lcp_mixing_begin(&s->mixing, n);
  }
}

/* A new rho where one side is ahead. False: no factor, or *status says no memory. */
static bool balance(state *s, const options *o, const lcp_problem *p, double apart, lcp_result *res,
                    base_status *status) {
  const int n = p->M.n;
  double moved = 0.0, impulse = 0.0, velocity = 0.0;
  if (res->work.iterations < s->next) {
    return true;
  }
  s->next += s->next / 2;
  for (int i = 0; i < n; i++) {
    const double way = s->rho * (s->v[i] - s->before[i]);
    moved += way * way;
    impulse += s->v[i] * s->v[i];
    velocity += s->g[i] * s->g[i];
  }
  const double primal = apart / sqrt(impulse), dual = sqrt(moved / velocity);
  const double ratio = primal / dual;
  if (!(ratio > 0.0) || !isfinite(ratio) || (ratio < 5.0 && ratio > 0.2)) {
    return true;
  }
  s->rho = fmin(fmax(s->rho * fmin(fmax(sqrt(ratio), 0.1), 10.0), least_rho), most_rho);
  join(s);
  forget(s, o, n);
  return factor(s, p, res, status);
}

/* t <- t + move, mixed where that is asked for. */
static base_status advance(state *s, const options *o, int n, lcp_result *res) {
  if (o->accelerate == ANDERSON) {
    return lcp_mixing_next(&s->mixing, s->move, s->t, &res->work);
  }
  for (int i = 0; i < n; i++) {
    s->t[i] += s->move[i];
  }
  return BASE_OK;
}

/* t from the start point z: its impulse in K, its velocity in K*. */
static void start(state *s, const options *o, const lcp_problem *p, double *z, lcp_result *res) {
  const int n = p->M.n;
  double *w = s->loop.stop.w;
  lcp_cone_scaled_project(&s->eq, z, s->t);
  memcpy(z, s->t, (size_t)n * sizeof *z);
  lcp_matrix_apply(&p->M, z, p->q, w, s->loop.stop.scratch);
  res->work.matvecs++;
  for (int i = 0; i < n; i++) {
    s->v[i] = z[i] / s->eq.s[i];
    s->g[i] = w[i] * s->eq.s[i];
    s->sq[i] = p->q[i] * s->eq.s[i];
  }
  for (int k = 0; k < s->eq.n_piece; k++) {
    const lcp_block *b = &s->eq.piece[k];
    if (b->set == LCP_CONE && o->law == DE_SAXCE) {
      s->g[b->start] += lcp_cone_shift(b, s->g + b->start);
    }
  }
  join(s);
}

static base_status solve(void *st, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  const options *o = opt;
  state *s = st;
  const int n = p->M.n;
  bool fresh;
  base_status status = BASE_OK;
  s->rho = o->penalty;
  s->next = FIRST_BALANCE;
  lcp_loop_begin(&s->loop, p, false);
  if (o->polish == ON) {
    lcp_cone_polish_begin(&s->polish);
  }
  start(s, o, p, z, res);
  forget(s, o, n);
  bool regular = true, made = false;
  while (!lcp_loop_ended(&s->loop, &o->stop, p, z, trace, res, &fresh)) {
    if (fresh && o->polish == ON &&
        lcp_cone_polish_try(&s->polish, &s->loop, &o->stop, p, s->rho, s->t, z, res, &status)) {
      break;
    }
    regular = made || factor(s, p, res, &status);
    made = true;
    split(s, o);
    const double apart = regular ? linear(s, o, p, res) : 0.0;
    regular = regular && balance(s, o, p, apart, res, &status);
    status = (status == BASE_OK && regular) ? advance(s, o, n, res) : status;
    if (status != BASE_OK || !regular) {
      res->outcome = LCP_STALLED;
      break;
    }
    for (int i = 0; i < n; i++) {
      z[i] = s->v[i] * s->eq.s[i];
    }
    memcpy(s->before, s->v, (size_t)n * sizeof *z);
    res->work.iterations++;
  }
  return status;
}

static void release(void *st) {
  state *s = st;
  lcp_cone_step_release(&s->step);
  lcp_cone_polish_release(&s->polish);
}

const lcp_solver lcp_solver_admm = {
    .name = "admm",
    .title = "Alternating directions",
    .cite = "boyd2011; eckstein1992; acary2018, 5.5",
    .words = "Linear solves with one factor, and cones met one by one, in turns.",
    .when = "The round cone with many redundant contacts, where sweeps are slow.",
    .sets = (1u << LCP_CONE) | (1u << LCP_ORTHANT) | (1u << LCP_BOX) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .by_factors = true,
    .warm = true,
    .allocates = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(state),
    .release = release,
};
