/* solver_block_pivoting.c - block principal pivoting of Judice & Pires (1994) with Murty's least-index
 * step as safeguard, on a sparse (KLU) or dense (LAPACK) factorisation of M_FF.
 *
 * All rows of the wrong sign change sides at once while their number falls; after PATIENCE steps
 * without progress one row at a time does, which ends on every P-matrix. Where M_FF is singular
 * (redundant contacts) the problem is solved by the proximal point method (Rockafellar 1976):
 * z_k+1 solves the problem with M + e D and q - e D z_k, D = diag M, which is a P-matrix problem
 * when M is monotone; e is not part of the answer, whose residual is that of M itself. On an
 * infeasible monotone problem z_k+1 - z_k tends to the certificate. */
#include "lcp/base/clock.h"
#include "lcp/lcp_column.h"
#include "lcp/lcp_farkas.h"
#include "lcp/lcp_solver.h"
#include "lcp/linear/direct.h"
#include "lcp/solvers/sets.h"

#include <string.h>

typedef struct options {
  lcp_stop stop;
  double proximal; /* e */
  int start;       /* first F: all rows, or the free ones only */
} options;

typedef struct block_pivoting {
  lcp_stop_state stop;
  lcp_direct direct;
  unsigned char *in, *is_free; /* F; free rows never leave it */
  unsigned char *proof;        /* F of the point handed over */
  double *scale;               /* S: power of two near 1/sqrt M_ii */
  double *weight;              /* e on every row of S M S, or zeros */
  double *q, *z, *w, *bound;   /* of S M S: effective q, z, w, |q| + |M||z| */
  double *last, *move, *tmp;
  double deadline;
} block_pivoting;

enum { PATIENCE = 10, OUTER_MAX = 60 };
static const double noise_first = 1e-13,
                    noise_last = 1e-9; /* wrong signs below this share are round-off */

static void layout(void *state, const lcp_capacity *cap, const void *opt, base_arena *a) {
  (void)opt;
  block_pivoting *s = state;
  lcp_stop_layout(&s->stop, cap, a);
  lcp_direct_layout(&s->direct, cap, a);
  s->in = BASE_ARRAY(a, unsigned char, cap->n);
  s->proof = BASE_ARRAY(a, unsigned char, cap->n);
  s->is_free = BASE_ARRAY(a, unsigned char, cap->n);
  s->scale = BASE_ARRAY(a, double, cap->n);
  s->weight = BASE_ARRAY(a, double, cap->n);
  s->q = BASE_ARRAY(a, double, cap->n);
  s->z = BASE_ARRAY(a, double, cap->n);
  s->w = BASE_ARRAY(a, double, cap->n);
  s->bound = BASE_ARRAY(a, double, cap->n);
  s->last = BASE_ARRAY(a, double, cap->n);
  s->move = BASE_ARRAY(a, double, cap->n);
  s->tmp = BASE_ARRAY(a, double, cap->n);
}

static base_status prepare(void *state, const lcp_problem *p, const void *opt, base_error *err) {
  (void)opt;
  (void)err;
  block_pivoting *s = state;
  lcp_direct_begin(&s->direct);
  lcp_set_binary_scaling(&p->M, s->scale);
  memset(s->is_free, 0, (size_t)p->M.n);
  for (int k = 0; p->block != NULL && k < p->n_block; k++) {
    for (int i = 0; i < p->block[k].size; i++) {
      s->is_free[p->block[k].start + i] = p->block[k].set == LCP_FREE;
    }
  }
  return BASE_OK;
}

/* w = (S M S + weight) z + q and the sum of the absolute terms. */
static void evaluate(block_pivoting *s, const lcp_problem *p) {
  const lcp_matrix *M = &p->M;
  for (int i = 0; i < M->n; i++) {
    s->w[i] = s->q[i] + s->weight[i] * s->z[i];
    s->bound[i] = fabs(s->q[i]) + fabs(s->weight[i] * s->z[i]);
  }
  for (int j = 0; j < M->n; j++) {
    const double zj = s->z[j] * s->scale[j];
    const lcp_column c = lcp_column_of(M, j);
    for (int k = 0; zj != 0 && k < c.count; k++) {
      const int i = lcp_column_row(&c, k);
      const double term = s->scale[i] * c.val[k] * zj;
      s->w[i] += term;
      s->bound[i] += fabs(term);
    }
  }
}

/* z_F from the factored basis, refined once; w. */
static void basic_solution(block_pivoting *s, const lcp_problem *p, lcp_work *work) {
  const int n = p->M.n;
  for (int i = 0; i < n; i++) {
    s->z[i] = 0;
    s->w[i] = s->q[i];
  }
  for (int round = 0; round < 2; round++) {
    for (int i = 0; i < n; i++) {
      s->tmp[i] = s->in[i] ? -s->w[i] : 0;
    }
    lcp_direct_solve(&s->direct, n, s->tmp);
    for (int i = 0; i < n; i++) {
      s->z[i] += s->in[i] ? s->tmp[i] : 0;
    }
    evaluate(s, p);
    work->backsolves++;
    work->matvecs++;
  }
  work->refinements++;
}

static bool wrong(const block_pivoting *s, int i, double noise) {
  if (s->is_free[i]) {
    return false;
  }
  return (s->in[i] ? s->z[i] : s->w[i]) < -noise * s->bound[i];
}

static int count_wrong(const block_pivoting *s, int n, double noise, int *last) {
  int count = 0;
  for (int i = 0; i < n; i++) {
    if (wrong(s, i, noise)) {
      count++;
      *last = i;
    }
  }
  return count;
}

/* Which rows change sides: all wrong ones while that helps, else the last one (Murty's rule, from
 * the end as Judice & Pires do). */
typedef struct exchange {
  int best, patience;
  long single; /* steps of one row since the last progress */
  double noise;
} exchange;

static void flip(block_pivoting *s, int n, int count, int last, exchange *e, lcp_work *work) {
  const bool progress = count < e->best;
  if (progress) {
    e->best = count;
    e->patience = PATIENCE;
    e->single = 0;
  }
  if (progress || e->patience > 0) {
    e->patience -= progress ? 0 : 1;
    for (int i = 0; i < n; i++) {
      if (wrong(s, i, e->noise)) {
        s->in[i] = !s->in[i];
        work->pivots++;
      }
    }
    return;
  }
  s->in[last] = !s->in[last];
  work->pivots++;
  work->fallbacks++;
  if (++e->single > 2L * n + 32) { /* round-off keeps flipping the same rows */
    e->single = 0;
    e->noise *= 10;
  }
}

typedef enum end { FOUND, SINGULAR, LOST, LIMIT, LATE } end;

static end pivot(block_pivoting *s, const lcp_problem *p, const lcp_stop *stop, lcp_result *res,
                 base_status *status) {
  const int n = p->M.n;
  exchange e = {.best = n + 1, .patience = PATIENCE, .noise = noise_first};
  for (;;) {
    res->work.factorizations++; /* a singular one has been paid for, too */
    if (!lcp_direct_factor(&s->direct, &p->M, s->in, s->weight, s->scale, s->scale, status)) {
      return SINGULAR;
    }
    res->work.iterations++;
    basic_solution(s, p, &res->work);
    int last = -1;
    const int count = count_wrong(s, n, e.noise, &last);
    if (count == 0) {
      return FOUND;
    }
    if (e.noise > noise_last) {
      return LOST;
    }
    if (res->work.iterations >= stop->max_iter) {
      return LIMIT;
    }
    if (base_seconds() > s->deadline) {
      return LATE;
    }
    flip(s, n, count, last, &e, &res->work);
  }
}

static void start(block_pivoting *s, const lcp_problem *p, int all, double weight) {
  for (int i = 0; i < p->M.n; i++) {
    s->in[i] = all || s->is_free[i];
    s->weight[i] = s->is_free[i] ? 0 : weight;
    s->q[i] = s->scale[i] * p->q[i];
    s->last[i] = 0;
  }
}

/* The natural map of the true problem against the data alone: on an infeasible monotone problem z
 * grows without bound and takes any residual relative to z along, but not this one. */
static bool small_for_data(const block_pivoting *s, const lcp_problem *p, double tol,
                           const double *z) {
  double size = 0;
  for (int i = 0; i < p->M.n; i++) {
    size = fmax(size, fabs(s->scale[i] * p->q[i]));
  }
  for (int i = 0; i < p->M.n; i++) {
    const double w = s->scale[i] * s->stop.w[i];
    const double r = s->is_free[i] ? fabs(w) : fabs(fmin(z[i] / s->scale[i], w));
    if (r > 10 * tol * size + 1e-14 * s->scale[i] * s->stop.tau[i]) {
      return false;
    }
  }
  return true;
}

/* Hands z out on K and asks the residual of the true problem. */
static bool accepted(block_pivoting *s, const lcp_problem *p, double tol, double *z,
                     lcp_result *res) {
  for (int i = 0; i < p->M.n; i++) {
    const double v = s->is_free[i] ? s->z[i] : fmax(s->z[i], 0.0);
    z[i] = s->in[i] ? s->scale[i] * v : 0;
  }
  return lcp_stop_met(&s->stop, tol, p, z, res) && small_for_data(s, p, tol, z);
}

static bool proves_infeasible(block_pivoting *s, const lcp_problem *p) {
  double top = 0;
  for (int i = 0; i < p->M.n; i++) {
    s->move[i] = s->z[i] - s->last[i];
    top = fmax(top, fabs(s->move[i]));
  }
  for (int i = 0; i < p->M.n; i++) {
    const bool faint = fabs(s->move[i]) < 1e-9 * top;
    s->move[i] = (faint || (s->move[i] < 0 && !s->is_free[i])) ? 0 : s->scale[i] * s->move[i];
  }
  return lcp_farkas_prove(&p->M, p->q, s->is_free, NULL, s->move);
}

static lcp_outcome of_end(end e) {
  static const lcp_outcome outcomes[] = {[FOUND] = LCP_STALLED,
                                         [SINGULAR] = LCP_NUMERICAL,
                                         [LOST] = LCP_STALLED,
                                         [LIMIT] = LCP_MAX_ITER,
                                         [LATE] = LCP_TIME_LIMIT};
  return outcomes[e];
}

/* The point of the last basis, on K, where there is one. */
static void give_up(block_pivoting *s, const lcp_problem *p, const options *o, end e, double *z,
                    lcp_result *res) {
  if (e != SINGULAR) {
    (void)accepted(s, p, o->stop.tol, z, res);
  }
}

/* The true q minus what the proximal term adds for the last center. */
static void pose(block_pivoting *s, const lcp_problem *p) {
  for (int i = 0; i < p->M.n; i++) {
    s->q[i] = s->scale[i] * p->q[i] - s->weight[i] * s->last[i];
  }
}

/* One more outer step costs one factorisation and gains the digits that e leaves: they are taken
 * until the residual stops falling. */
static lcp_outcome proximal(block_pivoting *s, const lcp_problem *p, const options *o, double *z,
                            lcp_result *res, base_status *status) {
  res->variant = "proximal";
  start(s, p, o->start == 0, o->proximal);
  double best = HUGE_VAL;
  bool solved = false;
  for (int k = 0, idle = 0; k < OUTER_MAX; k++) {
    pose(s, p);
    const end e = pivot(s, p, &o->stop, res, status);
    const bool good = e == FOUND && accepted(s, p, o->stop.tol, s->tmp, res);
    const bool better = e == FOUND && res->residual < 0.5 * best;
    if (solved && !(good && better)) {
      res->residual = best;
      return LCP_SOLVED;
    }
    if (e != FOUND) {
      give_up(s, p, o, k == 0 ? e : SINGULAR, z, res); /* from the second on z is the last center */
      return of_end(e);
    }
    memcpy(z, s->tmp, sizeof *z * (size_t)p->M.n);
    memcpy(s->proof, s->in, (size_t)p->M.n);
    idle = better ? 0 : idle + 1;
    best = good ? res->residual : fmin(best, res->residual);
    solved = good;
    if (!solved && idle >= 2 && proves_infeasible(s, p)) {
      res->certificate = (lcp_certificate){.kind = LCP_CERT_FARKAS, .vector = s->move};
      return LCP_INFEASIBLE;
    }
    if (!solved && idle >= 12) {
      return LCP_STALLED;
    }
    memcpy(s->last, s->z, sizeof *s->last * (size_t)p->M.n);
  }
  return solved ? LCP_SOLVED : LCP_STALLED;
}

static base_status solve(void *state, const lcp_problem *p, const void *opt, lcp_trace *trace,
                         double *z, lcp_result *res) {
  (void)trace; /* the number of wrong rows is not a residual */
  block_pivoting *s = state;
  const options *o = opt;
  base_status status = BASE_OK;
  lcp_stop_begin(&s->stop, p);
  s->deadline = base_seconds() + o->stop.max_seconds;
  res->variant = "plain";
  start(s, p, o->start == 0, 0);
  const end e = pivot(s, p, &o->stop, res, &status);
  lcp_outcome outcome = of_end(e);
  if (status == BASE_OK && e == FOUND && accepted(s, p, o->stop.tol, z, res)) {
    outcome = LCP_SOLVED;
    memcpy(s->proof, s->in, (size_t)p->M.n);
  } else if (status == BASE_OK && (e == SINGULAR || e == FOUND || e == LOST)) {
    outcome = proximal(s, p, o, z, res, &status);
  } else if (status == BASE_OK) {
    give_up(s, p, o, e, z, res);
  }
  res->outcome = outcome;
  if (outcome == LCP_SOLVED) {
    res->certificate = (lcp_certificate){.kind = LCP_CERT_BASIS, .basis = s->proof};
  }
  return status;
}

static void release(void *state) {
  block_pivoting *s = state;
  lcp_direct_release(&s->direct);
}

static const base_field fields[] = {
    LCP_STOP_FIELDS(options, 1e-10, 100000),
    BASE_FIELD(options, proximal, BASE_REAL, "1", 1e-6, 1e-12, 1,
               "proximal weight relative to the diagonal, used where M_FF is singular"),
    BASE_FIELD_CHOICE(options, start, "all|none", 0, "rows that are active in the first basis"),
};

const lcp_solver lcp_solver_block_pivoting = {
    .name = "block_pivoting",
    .title = "block pivoting",
    .cite = "judice1994",
    .words = "Exact, by exchanging whole blocks of unknowns.",
    .when = "Large sparse problems without friction.",
    .sets = (1u << LCP_ORTHANT) | (1u << LCP_FREE),
    .storages = (1u << LCP_DENSE) | (1u << LCP_CSC),
    .exact = true,
    .allocates = true,
    .prepare = prepare,
    LCP_SOLVER_PARTS(block_pivoting),
    .release = release,
};
