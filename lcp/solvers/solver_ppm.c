/* solver_ppm.c - symmetric principal pivoting of Keller (1973; Cottle, Pang & Stone 1992, algorithm
 * 4.2.11), for symmetric M with orthant, free and box rows.
 *
 * F: basic z with M_FF positive definite, factored as L L'. A row r whose w_r has the wrong sign
 * drives: z_r moves along d = (-M_FF^-1 M_Fr, 1), w_r rises at the rate s = M_rr - M_rF M_FF^-1 M_Fr
 * (the Schur complement) and w_F stays zero. Either w_r reaches zero, and r joins F, or some z_i
 * reaches a bound, and i leaves F. For M = M' >= 0 a row with s = 0 can only be stopped by a z_i,
 * whose removal makes s positive again: singular matrices need no special pivot. The energy
 * z'Mz/2 + q'z falls strictly from one driving row to the next, so no F returns and ties need no
 * rule. When nothing blocks, d >= 0 with Md = 0 and q'd < 0: no feasible point.
 * A start point gives the first F, by the rows strictly inside their bounds; descent to w_F = 0 precedes. With boxes a row
 * whose column depends on those of F stays at its start instead of going to a bound, until it drives: so redundant impulses,
 * of which many are answers, stay those of the start. A start that meets the tolerance is the answer there, to the bit.
 * An indefinite M (s < 0) is allowed: the descent then still ends in a solution or on a ray.
 * Small problems from z = 0 take the same pivots on a tableau (ppm/ppm_table.c). */
#include "lcp/base/clock.h"
#include "lcp/lcp_column.h"
#include "lcp/solvers/ppm/ppm.h"
#include "lcp/solvers/sets.h"

#include <float.h>
#include <string.h>

typedef struct options {
  lcp_stop stop;
} options;

/* Relative sizes; a violation below `sure` is driven at most twice. */
static const double sure_share = 1e-11;
static const double round_share = 16 * DBL_EPSILON;
/* Schur complement over its diagonal below which a row of a start stays where it is: 6e-8 is what rounding leaves of a
 * dependent row behind 108 independent ones, in a hopper of spheres. */
static const double stays = 1e-5;

/* Rows F can have: without S (and so without dense or sparse M) the velocities bound the rank. */
static int most_basic(const lcp_capacity *cap) {
  return (cap->nnz == 0 && cap->n_dof < cap->n) ? cap->n_dof : cap->n;
}

static void layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  ppm *s = state;
  const int m = most_basic(cap);
  lcp_loop_layout(&s->loop, cap, a);
  lcp_sweep_layout(&s->sweep, cap, a);
  s->m_max = m;
  s->dof = BASE_ARRAY(a, double, cap->n_dof);
  s->wide = BASE_ARRAY(a, long double, cap->n_dof);
  s->order = BASE_ARRAY(a, int, cap->n);
  s->pos = BASE_ARRAY(a, int, cap->n);
  s->where = BASE_ARRAY(a, unsigned char, cap->n);
  s->is_free = BASE_ARRAY(a, unsigned char, cap->n);
  s->tries = BASE_ARRAY(a, unsigned char, cap->n);
  s->L = BASE_ARRAY(a, double, lin_chol_row(m));
  s->cs = BASE_ARRAY(a, double, 2 * (size_t)cap->n);
  s->d = BASE_ARRAY(a, double, cap->n);
  s->unit = BASE_ARRAY(a, double, cap->n);
  s->share = BASE_ARRAY(a, double, cap->n);
  s->side = BASE_ARRAY(a, double, cap->n);
  s->table =
      BASE_ARRAY(a, double, lcp_ppm_table_size((cap->n < PPM_TABLE_MAX) ? cap->n : PPM_TABLE_MAX));
  s->lo = BASE_ARRAY(a, double, cap->n);
  s->hi = BASE_ARRAY(a, double, cap->n);
  s->w = BASE_ARRAY(a, double, cap->n);
  s->bound = BASE_ARRAY(a, double, cap->n);
  s->x = BASE_ARRAY(a, double, cap->n);
  s->y = BASE_ARRAY(a, double, cap->n + 3); /* as padded as a column of the table */
  s->ray = BASE_ARRAY(a, double, cap->n);
  s->e = BASE_ARRAY(a, double, cap->n);
  s->force = BASE_ARRAY(a, lcp_farkas_sum, cap->n_dof);
  s->sum = BASE_ARRAY(a, long double, cap->n);
}

static void set_rows(ppm *s, const lcp_problem *p, int first, int end, lcp_set set) {
  for (int i = first; i < end; i++) {
    s->lo[i] = (set == LCP_FREE) ? -HUGE_VAL : ((set == LCP_BOX) ? p->lo[i] : 0);
    s->hi[i] = (set == LCP_BOX) ? p->hi[i] : HUGE_VAL;
    s->is_free[i] = s->lo[i] == -HUGE_VAL && s->hi[i] == HUGE_VAL;
  }
}

static base_status prepare(void *state, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  ppm *s = state;
  const bool factored = p->M.storage == LCP_FACTORED;
  if ((p->traits & LCP_SYMMETRIC) == 0 && factored) { /* stored ones were compared: `needs` */
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "ppm: needs a symmetric matrix");
  }
  if (factored) {
    BASE_TRY(lcp_sweep_prepare(&s->sweep, p, err));
  }
  set_rows(s, p, 0, p->M.n, LCP_ORTHANT);
  for (int k = 0; p->block != NULL && k < p->n_block; k++) {
    set_rows(s, p, p->block[k].start, p->block[k].start + p->block[k].size, p->block[k].set);
  }
  s->boxes = (lcp_problem_sets(p) & (1u << LCP_BOX)) != 0;
  lcp_matrix_diagonal(&p->M, s->d);
  s->small = !factored && p->M.n <= PPM_TABLE_MAX && lcp_problem_sets(p) == 1u << LCP_ORTHANT;
  for (int i = 0; i < p->M.n; i++) {
    s->small = s->small && s->d[i] > 0;
    s->unit[i] = (s->d[i] != 0) ? sqrt(fabs(s->d[i])) : 1;
    s->share[i] = 1 / s->unit[i];
  }
  return BASE_OK;
}

static bool is_sure(const ppm *s, int r) {
  return lcp_ppm_violation(s, r) > sure_share * s->bound[r];
}

/* The nonbasic row to drive, -1: none left. Free rows first, then the largest violation in the
 * energy metric. */
static int choose(ppm *s, int n) {
  int best = -1;
  double top = 0;
  for (int i = 0; i < n; i++) {
    if (s->where[i] == BASIC || s->lo[i] == s->hi[i]) {
      continue;
    }
    const double v = lcp_ppm_violation(s, i);
    const bool sure = v > sure_share * s->bound[i];
    if (!(v > round_share * s->bound[i]) || (!sure && s->tries[i] >= 2)) {
      continue;
    }
    const double score = s->is_free[i] ? HUGE_VAL : v / s->unit[i];
    if (best < 0 || score > top) {
      best = i;
      top = score;
    }
  }
  if (best >= 0 && !is_sure(s, best)) {
    s->tries[best]++;
  }
  return best;
}

/* The direction of the last drive as a proof, when it is one. */
static bool proves_infeasible(ppm *s, const lcp_problem *p, int r) {
  if ((lcp_problem_sets(p) & (1u << LCP_BOX)) != 0) {
    return false;
  }
  const double sign = (s->w[r] < 0) ? 1 : -1;
  for (int i = 0; i < p->M.n; i++) {
    s->ray[i] = 0;
  }
  for (int k = 0; k < s->m; k++) {
    const double v = sign * s->y[k];
    s->ray[s->order[k]] = s->is_free[s->order[k]] ? v : fmax(v, 0.0);
  }
  s->ray[r] = sign;
  return lcp_farkas_prove(&p->M, p->q, s->is_free, s->force, s->ray);
}

static double resting_place(const ppm *s, int i, double z) {
  if (s->where[i] == INSIDE) {
    return z;
  }
  return s->is_free[i] ? 0 : (s->where[i] == AT_HI) ? s->hi[i] : s->lo[i];
}

/* F empty; every z at the bound nearest to its start, or where it is between two bounds. */
static void start_outside(ppm *s, int n, const double *z) {
  s->m = 0;
  for (int i = 0; i < n; i++) {
    const bool high = z[i] >= s->hi[i] || (s->lo[i] == -HUGE_VAL && s->hi[i] < HUGE_VAL);
    const bool inside = s->boxes && z[i] > s->lo[i] && z[i] < s->hi[i];
    s->where[i] = inside ? INSIDE : (high ? AT_HI : AT_LO);
    s->pos[i] = -1;
    s->tries[i] = 0;
    s->e[i] = 0;
  }
}

/* Cold (z = 0): F is empty. Otherwise F takes the rows whose start is strictly between its bounds (free
 * rows: not zero), as far as their columns are independent. True when F has any. A dependent row of a problem with boxes
 * stays where it is: at a bound it would ask the others for another answer than the one that the start is near to. */
static bool start(ppm *s, const lcp_matrix *M, bool warm, double *z, lcp_work *work) {
  start_outside(s, M->n, z);
  for (int i = 0; i < M->n; i++) {
    const bool inside = s->is_free[i] ? z[i] != 0 : z[i] > s->lo[i] && z[i] < s->hi[i];
    const double schur = (warm && inside) ? lcp_ppm_direction(s, M, i, work) : 0;
    const double rank = (s->where[i] == INSIDE) ? stays : lcp_ppm_relative.rank;
    if (schur > rank * fabs(s->d[i]) && s->m < s->m_max) {
      lcp_ppm_enter(s, i, sqrt(schur));
    } else {
      z[i] = resting_place(s, i, z[i]);
    }
  }
  work->pivots = 0; /* that was a factorisation */
  work->factorizations += s->m > 0;
  return s->m > 0;
}

/* From a point of K to one with w_F = 0: along z_F -= M_FF^-1 w_F, dropping from F what meets a bound. The
 * energy falls with each step, as it does afterwards. */
static void settle(ppm *s, const lcp_problem *p, double *z, lcp_work *work) {
  for (double step = 0; s->m > 0 && step < 1;) {
    double worst = 0;
    lcp_ppm_evaluate(s, p, z);
    for (int k = 0; k < s->m; k++) {
      s->y[k] = -s->w[s->order[k]];
      worst = fmax(worst, fabs(s->y[k]) / s->bound[s->order[k]]);
    }
    if (!(worst > round_share)) {
      return; /* the inverse of a nearly singular M_FF would make another answer of what rounding left */
    }
    lin_chol_forward(s->L, s->m, s->y);
    lin_chol_backward(s->L, s->m, s->y);
    work->matvecs++;
    work->backsolves += 2;
    step = 1;
    double t = HUGE_VAL;
    const int k = lcp_ppm_first_block(s, z, 0, 1, &t);
    if (k >= 0 && t < 1) {
      step = t;
    }
    for (int j = 0; j < s->m; j++) {
      z[s->order[j]] += step * s->y[j];
    }
    if (step < 1) {
      lcp_ppm_leave(s, z, k, s->y[k] < 0 ? AT_LO : AT_HI);
      work->pivots++;
    }
  }
}

/* The largest relative violation, for the history. */
static void note(const ppm *s, int n, long pivots, lcp_trace *trace) {
  if (trace == NULL || trace->len >= trace->cap) {
    return;
  }
  double worst = 0;
  for (int i = 0; i < n; i++) {
    const double v = (s->where[i] == BASIC) ? fabs(s->w[i]) : lcp_ppm_violation(s, i);
    worst = (v > worst * s->bound[i]) ? v / s->bound[i] : worst;
  }
  trace->iteration[trace->len] = pivots;
  trace->residual[trace->len++] = worst;
}

static bool is_dependent(ppm *s, const lcp_matrix *M, int r, lcp_work *work) {
  const bool dependent = !(lcp_ppm_direction(s, M, r, work) > stays * fabs(s->d[r]));
  work->pivots--; /* that was none */
  return dependent;
}

/* The row to drive, -1: none is left. With boxes one that misses by rounding and depends on F is passed over: w_r is as small
 * wherever z_r is, and the drive would go to the next bound of any row, however far. */
static int next(ppm *s, const lcp_matrix *M, lcp_work *work) {
  int r = choose(s, M->n);
  while (r >= 0 && s->boxes && !is_sure(s, r) && is_dependent(s, M, r, work)) {
    s->tries[r] = 2;
    r = choose(s, M->n);
  }
  return r;
}

/* Ends with LCP_SOLVED only as a candidate: the residual has the last word. */
static lcp_outcome pivot(ppm *s, const lcp_problem *p, const lcp_stop *stop, double *z,
                         lcp_trace *trace, lcp_result *res) {
  for (;;) {
    lcp_ppm_evaluate(s, p, z);
    res->work.matvecs++;
    lcp_ppm_correct(s, p, z, &res->work);
    note(s, p->M.n, res->work.pivots, trace);
    const int r = next(s, &p->M, &res->work);
    if (r < 0) {
      return LCP_SOLVED;
    }
    const bool sure = is_sure(s, r);
    const lcp_ppm_end e = lcp_ppm_drive(s, p, z, z, r, stop->max_iter, &res->work);
    res->work.iterations++;
    if (e == LCP_PPM_SPENT) {
      return LCP_MAX_ITER;
    }
    if (e == LCP_PPM_UNBLOCKED && !sure) {
      s->tries[r] = 2; /* round-off in a dependent row: nothing to gain, nothing proved */
    } else if (e == LCP_PPM_UNBLOCKED) {
      return proves_infeasible(s, p, r) ? LCP_INFEASIBLE : LCP_RAY;
    }
    if (res->work.iterations % 32 == 0 &&
        base_seconds() - s->loop.stop.started > stop->max_seconds) {
      return LCP_TIME_LIMIT;
    }
  }
}

/* The test of an iterative method: rho alone says nothing of a basis that is regular by rounding (data_test.h), and of
 * rows of factors whose terms cancel only their entries tell how large those were. */
static bool passes(ppm *s, const lcp_problem *p, const lcp_stop *stop, double *z, lcp_result *res) {
  lcp_loop_stationary(&s->loop, stop, p, z, NULL, res);
  return res->outcome == LCP_SOLVED;
}

/* With boxes: is the start, on K, an answer? Another one of as small a residual would move the bounds that follow from it. */
static bool is_answer(ppm *s, const lcp_problem *p, const lcp_stop *stop, double *z,
                      lcp_result *res) {
  if (!s->boxes) {
    return false;
  }
  for (int i = 0; i < p->M.n; i++) {
    z[i] = fmin(fmax(z[i], s->lo[i]), s->hi[i]);
  }
  const bool met = passes(s, p, stop, z, res);
  res->variant = met ? "warm" : res->variant;
  return met;
}

/* Each takes 16 digits off what is too much in a row whose answer is tiny beside the others', as friction is that a turn by
 * 1e-50 asks for; rho sees every row in its own scale. */
enum { REFINEMENTS = 6 };

/* F as a certificate. */
static lcp_certificate basis(ppm *s, int n) {
  for (int i = 0; i < n; i++) {
    s->tries[i] = s->where[i] == BASIC;
  }
  return (lcp_certificate){.kind = LCP_CERT_BASIS, .basis = s->tries};
}

/* A small problem from z = 0. False: nothing is decided, z is as it was. */
static bool solve_small(ppm *s, const lcp_problem *p, const lcp_stop *stop, lcp_trace *trace,
                        double *z, lcp_result *res) {
  if (!lcp_ppm_table_solve(s, p, stop, &lcp_ppm_relative, z, res)) {
    memset(z, 0, (size_t)p->M.n * sizeof *z);
    res->work.pivots = 0;
    res->work.fallbacks++;
    return false;
  }
  res->variant = "table";
  res->outcome = LCP_SOLVED;
  res->work.iterations = res->work.pivots;
  res->certificate = basis(s, p->M.n);
  if (trace != NULL && trace->len < trace->cap) {
    trace->iteration[trace->len] = res->work.pivots;
    trace->residual[trace->len++] = res->residual;
  }
  return true;
}

/* warm: z is another point than zero, as it was given, before it is put into its boxes. */
static void solve_from(ppm *s, const lcp_problem *p, const lcp_stop *stop, lcp_trace *trace,
                       bool warm, double *z, lcp_result *res) {
  lcp_loop_begin(&s->loop, p, false);
  if (warm && is_answer(s, p, stop, z, res)) {
    return;
  }
  if (start(s, &p->M, warm, z, &res->work)) {
    res->variant = "warm";
    settle(s, p, z, &res->work);
  }
  res->outcome = pivot(s, p, stop, z, trace, res);
  res->work.iterations = res->work.pivots;
  const lcp_outcome ended = res->outcome;
  bool met = false;
  for (int pass = 0; pass < (ended == LCP_SOLVED ? REFINEMENTS : 1) && !met; pass++) {
    if (ended == LCP_SOLVED) {
      lcp_ppm_refine(s, p, z, &res->work);
    }
    met = passes(s, p, stop, z, res);
  }
  met = met || (ended == LCP_SOLVED && lcp_ppm_rounded(s, p, stop, z, res));
  if (ended == LCP_INFEASIBLE || ended == LCP_RAY) {
    res->outcome = ended;
    if (!s->boxes) { /* there nothing is proved */
      res->certificate = (lcp_certificate){
          .kind = (ended == LCP_RAY) ? LCP_CERT_RAY : LCP_CERT_FARKAS, .vector = s->ray};
    }
  } else if (met) {
    res->outcome = LCP_SOLVED;
    if (!s->boxes) { /* a basis does not tell the two ends of a box apart */
      res->certificate = basis(s, p->M.n);
    }
  } else {
    res->outcome = (ended == LCP_SOLVED) ? LCP_NUMERICAL : ended;
  }
}

/* With boxes redundant rows keep what a start has of them, and one far off may drown what is asked for: from zero then. */
static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  ppm *s = state;
  const lcp_stop *stop = &((const options *)opt)->stop;
  bool warm = false;
  for (int i = 0; i < p->M.n; i++) {
    warm = warm || z[i] != 0;
  }
  if (s->small && !warm && solve_small(s, p, stop, trace, z, res)) {
    return BASE_OK;
  }
  solve_from(s, p, stop, trace, warm, z, res);
  if (warm && s->boxes && (res->outcome == LCP_NUMERICAL || res->outcome == LCP_RAY)) {
    memset(z, 0, (size_t)p->M.n * sizeof *z);
    res->variant = "";
    res->work.fallbacks++;
    solve_from(s, p, stop, trace, false, z, res);
  }
  return BASE_OK;
}

static const base_field fields[] = {LCP_STOP_FIELDS(options, 1e-10, 1000000)};

const lcp_solver lcp_solver_ppm = {
    .name = "ppm",
    .title = "principal pivoting",
    .cite = "keller1973; cottle1992, algorithm 4.2.11; goodnight1979",
    .words = "Exact, by pivoting on a growing principal block.",
    .when = "Symmetric problems with few changes from step to step.",
    .sets = (1u << LCP_ORTHANT) | (1u << LCP_FREE) | (1u << LCP_BOX),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC) | (1u << LCP_FACTORED),
    .needs = LCP_SYMMETRIC,
    .exact = true,
    .warm = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(ppm),
};
