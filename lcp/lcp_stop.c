/* lcp_stop.c - the stopping test all iterative methods share.
 *
 * For stored matrices it is the judge's rho in double precision. In the factored form |M| is not at
 * hand, so the scales are replaced by lower bounds from the one product w = M z + q,
 *   tau0_i >= |q_i| + |d_i z_i| + |w_i - q_i - d_i z_i|,   tau_i >= |q_i| + tau0_i
 * (triangle inequality): the residual is then an upper bound, and a method that stops by it is
 * never kinder to itself than the judge. */
#include "lcp/base/clock.h"
#include "lcp/lcp_rho.h"
#include "lcp/lcp_solver.h"

void lcp_stop_layout(lcp_stop_state *s, const lcp_capacity *cap, base_arena *a) {
  s->w = BASE_ARRAY(a, double, cap->n);
  s->d = BASE_ARRAY(a, double, cap->n);
  s->scratch = BASE_ARRAY(a, double, 2 * cap->n_dof);
  s->tau = BASE_ARRAY(a, double, cap->n);
  s->zref = BASE_ARRAY(a, double, cap->n);
}

void lcp_stop_begin(lcp_stop_state *s, const lcp_problem *p) {
  s->started = base_seconds();
  lcp_matrix_diagonal(&p->M, s->d);
}

/* w = M z + q, zref and tau. */
static void scales(lcp_stop_state *s, const lcp_problem *p, const double *z) {
  if (p->M.storage != LCP_FACTORED) {
    lcp_rho_product(p, z, s->w, s->tau);
    lcp_rho_references(p, s->d, s->tau, s->zref);
    lcp_rho_product(p, s->zref, NULL, s->tau);
    return;
  }
  lcp_matrix_apply(&p->M, z, p->q, s->w, s->scratch);
  for (int i = 0; i < p->M.n; i++) {
    const double own = s->d[i] * z[i];
    s->tau[i] = fabs(p->q[i]) + fabs(own) + fabs(s->w[i] - p->q[i] - own);
  }
  lcp_rho_references(p, s->d, s->tau, s->zref);
  for (int i = 0; i < p->M.n; i++) {
    s->tau[i] += fabs(p->q[i]);
  }
}

bool lcp_stop_met(lcp_stop_state *s, double tol, const lcp_problem *p, const double *z,
                  lcp_result *res) {
  scales(s, p, z);
  res->work.matvecs++;
  res->residual = lcp_rho(p, s->d, z, s->w, s->zref, s->tau);
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
