#include "lcp/solvers/loop.h"

#include "lcp/lcp_rho.h"
#include "lcp/solvers/data_test.h"
#include "lcp/solvers/sets.h"

#include <string.h>

void lcp_loop_layout(lcp_loop *s, const lcp_capacity *cap, base_arena *a) {
  lcp_stop_layout(&s->stop, cap, a);
  s->scale = BASE_ARRAY(a, double, cap->n);
  s->seen = BASE_ARRAY(a, double, cap->n);
}

void lcp_loop_begin(lcp_loop *s, const lcp_problem *p, bool memoryless) {
  lcp_stop_begin(&s->stop, p);
  lcp_matrix_diagonal(&p->M, s->stop.d);
  lcp_set_scaling(&p->M, s->stop.d, s->scale);
  s->tests = 0;
  s->next = 1;
  s->memoryless = memoryless;
  s->q_size = lcp_data_size(p, s->scale);
}

static bool believable(const lcp_loop *s, const lcp_stop *stop, const lcp_problem *p,
                       const double *z, const double *tau0) {
  return lcp_data_allows(p, stop->tol, s->q_size, s->scale, z, s->stop.w, tau0);
}

/* rho with the scales that the entries of M give (of S, where M is held in factors), after lcp_stop_test has
 * been at z: w, the diagonal and its tau are in s->stop. tau0 is left in s->seen. HUGE_VAL where p has cones:
 * lcp_stop_test is exact on those. */
static double rho_of_entries(lcp_loop *s, const lcp_problem *p, const double *z) {
  lcp_stop_state *t = &s->stop;
  double *tau0 = s->seen;
  const bool factored = p->M.storage == LCP_FACTORED;
  lcp_rho_product(p, z, NULL, tau0);
  for (int i = 0; factored && i < p->M.n; i++) { /* J W J' by the triangle inequality */
    tau0[i] = fmax(tau0[i], t->tau[i] - fabs(p->q[i]));
  }
  if ((lcp_problem_sets(p) & (1u << LCP_CONE)) != 0) {
    return HUGE_VAL;
  }
  lcp_rho_references(p, t->d, tau0, t->zref);
  lcp_rho_product(p, t->zref, NULL, t->tau);
  for (int i = 0; factored && i < p->M.n; i++) {
    t->tau[i] = fmax(t->tau[i], fabs(p->q[i]) + tau0[i]);
  }
  return lcp_rho(p, t->d, z, t->w, t->zref, t->tau);
}

/* lcp_stop_test bounds rho from one product. Two things can be wrong with its answer: it accepts a z
 * that ran away, and where the terms of a row cancel (the sigma rows of friction, q_i = 0) it cannot
 * see how large they were and refuses forever. Both are settled here, at the price of two products. */
static bool settle(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, const double *z,
                   lcp_result *res) {
  const bool accepted = res->residual <= stop->tol;
  if (!accepted && !believable(s, stop, p, z, NULL)) {
    return false;
  }
  const double rho = rho_of_entries(s, p, z);
  s->tests = 0; /* `seen` was overwritten: cycle detection starts again */
  s->next = 1;
  res->work.matvecs += 2;
  res->residual = accepted ? res->residual : fmin(res->residual, rho);
  return res->residual <= stop->tol && believable(s, stop, p, z, s->seen);
}

/* True when this z was seen before, bit for bit. */
static bool repeats(lcp_loop *s, int n, const double *z) {
  const size_t bytes = (size_t)n * sizeof *z;
  s->tests++;
  if (s->tests > 1 && memcmp(z, s->seen, bytes) == 0) {
    return true;
  }
  if (s->tests == s->next) {
    memcpy(s->seen, z, bytes);
    s->next *= 2;
  }
  return false;
}

bool lcp_loop_ended(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, const double *z,
                    lcp_trace *trace, lcp_result *res, bool *fresh) {
  const bool last = res->work.iterations >= stop->max_iter;
  const bool due = last || res->work.iterations % stop->check_every == 0;
  if (fresh != NULL) {
    *fresh = due;
  }
  if (!due) {
    return false;
  }
  const bool ended = lcp_stop_test(&s->stop, stop, p, z, trace, res);
  const lcp_outcome otherwise = last ? LCP_MAX_ITER : res->outcome;
  if (ended && res->outcome != LCP_SOLVED && res->outcome != LCP_MAX_ITER) {
    return true;
  }
  if (settle(s, stop, p, z, res)) {
    res->outcome = LCP_SOLVED;
    return true;
  }
  res->outcome = otherwise;
  if (last) {
    return true;
  }
  if (s->memoryless && repeats(s, p->M.n, z)) {
    res->outcome = LCP_STALLED;
    return true;
  }
  return false;
}

void lcp_loop_stationary(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, const double *z,
                         lcp_trace *trace, lcp_result *res) {
  const lcp_stop now = {stop->tol, stop->max_iter, 1, stop->max_seconds};
  if (!lcp_loop_ended(s, &now, p, z, trace, res, NULL)) {
    res->outcome = LCP_STALLED;
  }
}
