/* solver_murty.c - least-index method of Murty (1974; Murty 1988, section 4.1): of the rows with the wrong
 * sign the first one changes sides, by a principal pivot on a dense tableau.
 *
 * Ends on every P-matrix, after at most 2^n - 1 pivots, and reaches that bound on Murty's own
 * example: kept as the baseline that shows why others exist. Elsewhere a zero pivot or a
 * repeated basis may end it: reported, never repaired. The last basis is solved again from M. */
#include "lcp/base/clock.h"
#include "lcp/lcp_solver.h"
#include "lcp/linear/direct.h"
#include "lcp/solvers/data_test.h"

typedef struct options {
  lcp_stop stop;
} options;

typedef struct murty {
  lcp_stop_state stop;
  lcp_direct direct;
  double *T;         /* n*n, column-major: basic = T nonbasic + b */
  double *b, *noise; /* n; n: size of the terms b is made of */
  double *row, *w;   /* n */
  double *scale;     /* power of two near 1/sqrt |M_ii|: conditions the last factorisation */
  unsigned char *in; /* z_i basic */
} murty;

static const double round_share = 1e-14; /* share of `noise` below which a sign means nothing */

static void layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  murty *s = state;
  lcp_stop_layout(&s->stop, cap, a);
  lcp_direct_layout(&s->direct, cap, a);
  s->T = BASE_ARRAY(a, double, (size_t)cap->n *(size_t)cap->n);
  s->b = BASE_ARRAY(a, double, cap->n);
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
  lcp_matrix_diagonal(&p->M, s->scale);
  for (int i = 0; i < p->M.n; i++) {
    int e = 0;
    (void)frexp(s->scale[i], &e);
    s->scale[i] = (s->scale[i] != 0) ? ldexp(1, -e / 2) : 1;
  }
  return BASE_OK;
}

/* Exchanges w_r and z_r. False: the pivot is zero up to the cancellation in its row and column. */
static bool exchange(murty *s, int n, int r) {
  double *col = s->T + (ptrdiff_t)r * n;
  const double d = col[r];
  double product = 0;
  for (int j = 0; j < n; j++) {
    s->row[j] = s->T[(ptrdiff_t)j * n + r];
    product = (j != r) ? fmax(product, fabs(s->row[j] * col[j])) : product;
  }
  if (!(fabs(d) > 0) || !isfinite(d) || !isfinite(product)) {
    return false;
  }
  const double step = -s->b[r] / d;
  for (int i = 0; i < n; i++) {
    if (i != r) {
      s->b[i] += col[i] * step;
      s->noise[i] = fmax(s->noise[i], fabs(col[i] * step));
    }
  }
  s->b[r] = step;
  s->noise[r] /= fabs(d);
  for (int j = 0; j < n; j++) {
    double *cj = s->T + (ptrdiff_t)j * n;
    const double f = s->row[j] / d;
    if (j == r || f == 0) {
      continue;
    }
    for (int i = 0; i < n; i++) {
      cj[i] -= col[i] * f;
    }
    cj[r] = -f;
  }
  for (int i = 0; i < n; i++) {
    col[i] /= d;
  }
  col[r] = 1 / d;
  s->in[r] = !s->in[r];
  return true;
}

static lcp_outcome pivot(murty *s, const lcp_problem *p, const lcp_stop *stop, lcp_work *work) {
  const int n = p->M.n;
  for (;;) {
    int r = 0;
    while (r < n && !(s->b[r] < -round_share * s->noise[r])) {
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
  lcp_matrix_to_dense(&p->M, s->T);
  for (int i = 0; i < p->M.n; i++) {
    s->b[i] = p->q[i];
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
    z[i] = s->in[i] ? fmax(s->b[i], 0.0) : 0;
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
    .fields = fields,
    .n_fields = BASE_COUNT(fields),
    .options_size = sizeof(options),
    .state_size = sizeof(murty),
    .layout = layout,
    .prepare = prepare,
    .solve = solve,
};
