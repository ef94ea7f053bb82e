/* lcp_stop.c - the stopping test all iterative methods share.
 *
 * For stored matrices it is the judge's rho in double precision. In the factored form |M| is not at
 * hand, so the scales are replaced by lower bounds from the one product w = M z + q,
 *   tau0_i >= |q_i| + |d_i z_i| + |w_i - q_i - d_i z_i|,   tau_i >= |q_i| + tau0_i
 * (triangle inequality): the residual is then an upper bound, and a method that stops by it is
 * never kinder to itself than the judge. */
#include "lcp/base/clock.h"
#include "lcp/lcp_cone.h"
#include "lcp/lcp_solver.h"

void lcp_stop_layout(lcp_stop_state *s, const lcp_capacity *cap, base_arena *a) {
  s->w = BASE_ARRAY(a, double, cap->n);
  s->d = BASE_ARRAY(a, double, cap->n);
  s->tau = BASE_ARRAY(a, double, cap->n);
  s->zref = BASE_ARRAY(a, double, cap->n);
  s->scratch = BASE_ARRAY(a, double, 2 * cap->n_dof);
}

void lcp_stop_begin(lcp_stop_state *s, const lcp_problem *p) {
  s->started = base_seconds();
  lcp_matrix_diagonal(&p->M, s->d);
}

/* max over rows j with M_ji != 0 of tau0_j / |M_ji|, 1 for a zero column. */
static double column_reference(const lcp_matrix *M, int i, const double *tau0) {
  double ref = 0.0;
  bool empty = true;
  if (M->storage == LCP_DENSE) {
    const double *col = M->val + (size_t)i * (size_t)M->n;
    for (int j = 0; j < M->n; j++) {
      if (col[j] != 0.0) {
        ref = fmax(ref, tau0[j] / fabs(col[j]));
        empty = false;
      }
    }
    return empty ? 1.0 : ref;
  }
  /* a zero diagonal in the factored form means a zero row of J: its column is that of S */
  const lcp_csc *m = (M->storage == LCP_CSC) ? &M->csc : M->factored->shift;
  for (int k = (m != NULL) ? m->colptr[i] : 0; m != NULL && k < m->colptr[i + 1]; k++) {
    if (m->val[k] != 0.0) {
      ref = fmax(ref, tau0[m->rowind[k]] / fabs(m->val[k]));
      empty = false;
    }
  }
  return empty ? 1.0 : ref;
}

/* y += |M| |x|, and w += M x where w is given; stored matrices only. */
static void absolute_apply(const lcp_matrix *M, const double *x, double *w, double *y) {
  const bool dense = M->storage == LCP_DENSE;
  for (int j = 0; j < M->n; j++) {
    const double xj = x[j];
    if (xj == 0.0) {
      continue;
    }
    const int first = dense ? 0 : M->csc.colptr[j];
    const int last = dense ? M->n : M->csc.colptr[j + 1];
    const double *val = dense ? M->val + (size_t)j * (size_t)M->n : M->csc.val;
    for (int k = first; k < last; k++) {
      const int i = dense ? k : M->csc.rowind[k];
      const double term = val[k] * xj;
      y[i] += fabs(term);
      if (w != NULL) {
        w[i] += term;
      }
    }
  }
}

/* w = M z + q, zref and tau. */
static void scales(lcp_stop_state *s, const lcp_problem *p, const double *z) {
  const int n = p->M.n;
  const bool stored = p->M.storage != LCP_FACTORED;
  if (stored) {
    for (int i = 0; i < n; i++) {
      s->w[i] = p->q[i];
      s->tau[i] = fabs(p->q[i]);
    }
    absolute_apply(&p->M, z, s->w, s->tau);
  } else {
    lcp_matrix_apply(&p->M, z, p->q, s->w, s->scratch);
    for (int i = 0; i < n; i++) {
      const double own = s->d[i] * z[i];
      s->tau[i] = fabs(p->q[i]) + fabs(own) + fabs(s->w[i] - p->q[i] - own);
    }
  }
  for (int i = 0; i < n; i++) {
    s->zref[i] = (s->d[i] != 0.0) ? s->tau[i] / fabs(s->d[i]) : column_reference(&p->M, i, s->tau);
  }
  for (int i = 0; i < n; i++) {
    s->tau[i] = fabs(p->q[i]) + (stored ? 0.0 : s->tau[i]);
  }
  if (stored) {
    absolute_apply(&p->M, s->zref, NULL, s->tau);
  }
}

static double over(double x, double scale) {
  if (scale > 0.0) {
    return x / scale;
  }
  return (x == 0.0) ? 0.0 : copysign(HUGE_VAL, x);
}

static double row_residual(const lcp_stop_state *s, const lcp_problem *p, lcp_set set, int i,
                           const double *z) {
  const double x = over(z[i], s->zref[i]), y = over(s->w[i], s->tau[i]);
  if (set == LCP_FREE) {
    return fabs(y);
  }
  if (set == LCP_BOX) {
    const double lo = over(p->lo[i], s->zref[i]), hi = over(p->hi[i], s->zref[i]);
    return fabs(x - fmin(fmax(x - y, lo), hi));
  }
  return fabs(fmin(x, y));
}

static double cone_residual(const lcp_stop_state *s, const lcp_block *b, const double *z) {
  double moved[1 + 2 * LCP_PARTS_MAX], d = 0.0, tau = 0.0, worst = 0.0;
  for (int i = 0; i < b->size; i++) {
    d += s->d[b->start + i] / b->size;
    tau = fmax(tau, s->tau[b->start + i]);
  }
  d = (d > 0.0) ? d : 1.0;
  for (int i = 0; i < b->size; i++) {
    moved[i] = d * z[b->start + i] - s->w[b->start + i];
  }
  moved[0] -= lcp_cone_shift(b, s->w + b->start);
  lcp_cone_project(b, moved, moved);
  for (int i = 0; i < b->size; i++) {
    worst = fmax(worst, over(fabs(d * z[b->start + i] - moved[i]), tau));
  }
  return worst;
}

/* fmax drops NaN; a residual must not. */
static double worse(double worst, double r) {
  return (r > worst || r != r) ? r : worst;
}

static double residual(const lcp_stop_state *s, const lcp_problem *p, const double *z) {
  double worst = 0.0;
  for (int i = 0; p->block == NULL && i < p->M.n; i++) {
    worst = worse(worst, row_residual(s, p, LCP_ORTHANT, i, z));
  }
  for (int k = 0; p->block != NULL && k < p->n_block; k++) {
    const lcp_block *b = &p->block[k];
    if (b->set == LCP_CONE) {
      worst = worse(worst, cone_residual(s, b, z));
      continue;
    }
    for (int i = b->start; i < b->start + b->size; i++) {
      worst = worse(worst, row_residual(s, p, b->set, i, z));
    }
  }
  return worst;
}

bool lcp_stop_met(lcp_stop_state *s, double tol, const lcp_problem *p, const double *z,
                  lcp_result *res) {
  scales(s, p, z);
  res->work.matvecs++;
  res->residual = residual(s, p, z);
  return res->residual <= tol;
}

bool lcp_stop_test(lcp_stop_state *s, const lcp_stop *stop, const lcp_problem *p, const double *z,
                   lcp_trace *trace, lcp_result *res) {
  const bool at_limit = res->work.iterations >= stop->max_iter;
  if (!at_limit && res->work.iterations % stop->check_every != 0) {
    return false;
  }
  const bool met = lcp_stop_met(s, stop->tol, p, z, res);
  if (trace != NULL && trace->len < trace->cap) {
    trace->iteration[trace->len] = res->work.iterations;
    trace->residual[trace->len++] = res->residual;
  }
  if (met) {
    res->outcome = LCP_SOLVED;
  } else if (!(res->residual < HUGE_VAL)) {
    res->outcome = LCP_NUMERICAL;
  } else if (at_limit) {
    res->outcome = LCP_MAX_ITER;
  } else if (base_seconds() - s->started > stop->max_seconds) {
    res->outcome = LCP_TIME_LIMIT;
  } else {
    return false;
  }
  return true;
}
