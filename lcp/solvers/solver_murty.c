/* solver_murty.c - least-index method of Murty (1974; Murty 1988, section 4.1): of the rows with the wrong
 * sign the first one changes sides, by a principal pivot on the tableau.
 *
 * Ends on every P-matrix, after at most 2^n - 1 pivots, and reaches that bound on Murty's own
 * example: kept as the baseline that shows why others exist. Elsewhere a zero pivot or a
 * repeated basis may end it: reported, never repaired. The last basis is solved again from M. */
#include "lcp/base/clock.h"
#include "lcp/lcp_solver.h"
#include "lcp/linear/direct.h"
#include "lcp/linear/tableau.h"
#include "lcp/solvers/data_test.h"
#include "lcp/solvers/sets.h"

typedef struct options {
  lcp_stop stop;
} options;

typedef struct murty {
  lcp_stop_state stop;
  lcp_direct direct;
  lin_tableau tableau; /* row r is basic in w_r or z_r */
  double *noise;       /* n: size of the terms the basic values are made of */
  double *row, *w;     /* n */
  double *scale;       /* power of two near 1/sqrt |M_ii|: conditions the last factorisation */
  unsigned char *in;   /* z_i basic */
} murty;

static const double round_share = 1e-14; /* share of `noise` below which a sign means nothing */

static void layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  murty *s = state;
  lcp_stop_layout(&s->stop, cap, a);
  lcp_direct_layout(&s->direct, cap, a);
  lin_tableau_layout(&s->tableau, cap->n, a);
  s->noise = BASE_ARRAY(a, double, cap->n);
  s->row = BASE_ARRAY(a, double, cap->n);
  s->w = BASE_ARRAY(a, double, cap->n);
  s->scale = BASE_ARRAY(a, double, cap->n);
  s->in = BASE_ARRAY(a, unsigned char, cap->n);
}

static base_status prepare(void *state, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  (void)err;
  murty *s = state;
  lcp_direct_begin(&s->direct);
  lcp_set_binary_scaling(&p->M, s->scale);
  return BASE_OK;
}

/* Exchanges w_r and z_r. False: there is no pivot, or its row and column are beyond all numbers. */
static bool exchange(murty *s, int n, int r) {
  lin_tableau *t = &s->tableau;
  const int entering = s->in[r] ? r : n + r;
  const double *col = lin_tableau_column(t, entering);
  double product = 0;
  for (int j = 0; j < n; j++) {
    product = (j != r) ? fmax(product, fabs(lin_tableau_entries(t, j)[r] * col[j])) : product;
  }
  if (!(fabs(col[r]) > 0) || !isfinite(col[r]) || !isfinite(product)) {
    return false;
  }
  const double step = t->x[r] / col[r];
  for (int i = 0; i < n; i++) {
    s->noise[i] = (i != r) ? fmax(s->noise[i], fabs(col[i] * step)) : s->noise[r] / fabs(col[r]);
  }
  lin_tableau_replace(t, r, entering);
  s->in[r] = !s->in[r];
  return true;
}

static lcp_outcome pivot(murty *s, const lcp_problem *p, const lcp_stop *stop, lcp_work *work) {
  const int n = p->M.n;
  for (;;) {
    int r = 0;
    while (r < n && !(s->tableau.x[r] < -round_share * s->noise[r])) {
      r++;
    }
    if (r == n) {
      return LCP_SOLVED;
    }
    if (work->pivots >= stop->max_iter) {
      return LCP_MAX_ITER;
    }
    if (work->pivots % 64 == 0 && base_seconds() - s->stop.started > stop->max_seconds) {
      return LCP_TIME_LIMIT;
    }
    if (!exchange(s, n, r)) {
      return LCP_NUMERICAL;
    }
    work->pivots++;
  }
}

/* z of the last basis from a factorisation of M_FF, refined once. */
static bool settle(murty *s, const lcp_problem *p, double *z, lcp_work *work, base_status *status) {
  const int n = p->M.n;
  work->factorizations++; /* a singular one has been paid for, too */
  if (!lcp_direct_factor(&s->direct, &p->M, s->in, NULL, s->scale, s->scale, status)) {
    return false;
  }
  for (int i = 0; i < n; i++) {
    z[i] = 0;
    s->w[i] = p->q[i];
  }
  for (int round = 0; round < 2; round++) {
    for (int i = 0; i < n; i++) {
      s->row[i] = s->in[i] ? -s->scale[i] * s->w[i] : 0;
    }
    lcp_direct_solve(&s->direct, n, s->row);
    for (int i = 0; i < n; i++) {
      z[i] += s->in[i] ? s->scale[i] * s->row[i] : 0;
    }
    lcp_matrix_apply(&p->M, z, p->q, s->w, NULL);
    work->matvecs++;
    work->backsolves++;
  }
  for (int i = 0; i < n; i++) {
    z[i] = fmax(z[i], 0.0); /* on K; the residual decides */
  }
  return true;
}

static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  (void)trace; /* a pivot sequence has no residual */
  murty *s = state;
  const lcp_stop *stop = &((const options *)opt)->stop;
  base_status status = BASE_OK;
  lcp_stop_begin(&s->stop, p);
  lin_tableau_start(&s->tableau, p->M.n);
  for (int j = 0; j < p->M.n; j++) {
    for (int i = 0; i < p->M.n; i++) {
      lin_tableau_entries(&s->tableau, j)[i] = -p->M.val[(ptrdiff_t)j * p->M.n + i];
    }
  }
  for (int i = 0; i < p->M.n; i++) {
    s->tableau.x[i] = p->q[i];
    s->noise[i] = fabs(p->q[i]);
    s->in[i] = 0;
    z[i] = 0;
  }
  lcp_outcome ended = pivot(s, p, stop, &res->work);
  res->work.iterations = res->work.pivots;
  if (ended == LCP_SOLVED && !settle(s, p, z, &res->work, &status)) {
    ended = LCP_NUMERICAL;
  }
  for (int i = 0; ended != LCP_SOLVED && i < p->M.n; i++) { /* where it was given up, on K */
    z[i] = s->in[i] ? fmax(s->tableau.x[i], 0.0) : 0;
  }
  const bool met = lcp_stop_met(&s->stop, stop->tol, p, z, res) &&
                   lcp_data_met(p, stop->tol, &s->stop, z, s->row, s->noise, &res->work);
  res->outcome = (ended == LCP_SOLVED && !met) ? LCP_NUMERICAL : ended;
  if (res->outcome == LCP_SOLVED) {
    res->certificate = (lcp_certificate){.kind = LCP_CERT_BASIS, .basis = s->in};
  }
  return status;
}

static const base_field fields[] = {LCP_STOP_FIELDS(options, 1e-10, 1000000)};

const lcp_solver lcp_solver_murty = {
    .name = "murty",
    .title = "least index",
    .cite = "murty1974; murty1988, 4.1",
    .words = "Exact, by pivoting on the first index that is wrong.",
    .when = "Small problems without friction; the plainest rule to hold others against.",
    .sets = 1u << LCP_ORTHANT,
    .storages = 1u << LCP_DENSE,
    .exact = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(murty),
};
