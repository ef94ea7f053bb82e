#include "lcp/solvers/loop.h"

#include "lcp/base/clock.h"
#include "lcp/lcp_rho.h"
#include "lcp/solvers/data_test.h"
#include "lcp/solvers/sets.h"

#include <float.h>
#include <string.h>

enum { TRIES = 8 }; /* of other numbers of zeros */

void lcp_loop_layout(lcp_loop *s, const lcp_capacity *cap, base_arena *a) {
  s->scale = BASE_ARRAY(a, double, cap->n);
  lcp_stop_layout(&s->stop, cap, a);
  lcp_rho_factored_layout(&s->factored, cap, a); /* what is seldom touched lies together */
  s->seen = BASE_ARRAY(a, double, cap->n);
  s->small = BASE_ARRAY(a, double, cap->n);
}

void lcp_loop_begin(lcp_loop *s, const lcp_problem *p, bool memoryless) {
  lcp_stop_begin(&s->stop, p);
  lcp_set_scaling(&p->M, s->stop.d, s->scale);
  s->factored.ready = false;
  s->tests = 0;
  s->next = 1;
  s->memoryless = memoryless;
  s->q_size = lcp_data_size(p, s->scale);
  s->tried = 0;
  s->tries = 0;
  s->failed = 0;
  s->due = 1;
  s->homogeneous = false;
  for (int i = 0; i < p->M.n && !s->homogeneous; i++) {
    s->homogeneous = p->q[i] == 0.0;
  }
}

static bool believable(const lcp_loop *s, const lcp_stop *stop, const lcp_problem *p,
                       const double *z, const double *tau0) {
  return lcp_data_allows(p, stop->tol, s->q_size, s->scale, z, s->stop.w, tau0);
}

/* After lcp_stop_test has been at z, where M is held in factors: is z worth the price of rho_of_entries? Cones: the
 * natural map is small against the largest tau of all rows (which it puts in the place of every other; ten times, since
 * it is a bound). */
static bool near(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, const double *z) {
  lcp_stop_state *t = &s->stop;
  if ((lcp_problem_sets(p) & (1u << LCP_CONE)) == 0) {
    return believable(s, stop, p, z, NULL);
  }
  double top = 0.0;
  for (int i = 0; i < p->M.n; i++) {
    top = fmax(top, t->tau[i]);
  }
  for (int i = 0; i < p->M.n; i++) {
    t->tau[i] = top;
  }
  return lcp_rho_within(p, 10.0 * stop->tol, t->d, z, t->w, t->zref, t->tau);
}

/* zref of the tau0 in s->seen; marks the rows where it is another than before. */
static void refer_again(lcp_loop *s, const lcp_problem *p) {
  const lcp_stop_state *t = &s->stop;
  for (int i = 0; i < p->M.n; i++) {
    const double ref = lcp_rho_reference(t->d[i], s->seen[i], lcp_column_of(&p->M, i), s->seen);
    s->factored.again[i] = s->factored.again[i] || !(ref == t->zref[i]);
    t->zref[i] = ref;
  }
}

/* rho with the scales that entries of J W J' + S give, those between groups only of rows in s->factored.whole: a
 * bound from above, or rho. tau0 is left in s->seen. */
static double rho_of_entries(lcp_loop *s, const lcp_problem *p, const double *z) {
  lcp_stop_state *t = &s->stop;
  lcp_rho_factored *f = &s->factored;
  lcp_rho_factored_product(f, p, NULL, f->whole, z, s->seen);
  lcp_rho_references(p, t->d, s->seen, t->zref);
  lcp_rho_factored_product(f, p, NULL, f->whole, t->zref, t->tau);
  return lcp_rho(p, t->d, z, t->w, t->zref, t->tau);
}

/* The same where that was just done with fewer rows in `whole`: of groups with a row in s->factored.again, what others have stays. */
static double rho_of_more_entries(lcp_loop *s, const lcp_problem *p, const double *z) {
  lcp_stop_state *t = &s->stop;
  lcp_rho_factored *f = &s->factored;
  lcp_rho_factored_product(f, p, f->again, f->whole, z, s->seen);
  refer_again(s, p);
  lcp_rho_factored_product(f, p, f->again, f->whole, t->zref, t->tau);
  return lcp_rho(p, t->d, z, t->w, t->zref, t->tau);
}

/* whole |= again; false where that adds nothing. */
static bool widen(lcp_rho_factored *f, int n) {
  bool any = false;
  for (int i = 0; i < n; i++) {
    any = any || (f->again[i] && !f->whole[i]);
    f->whole[i] = f->whole[i] || f->again[i];
  }
  return any;
}

/* Entries inside the groups first; then those between groups for the rows that still stand above tol; then for their neighbours
 * too, whose zref their tau is made of. More would change nothing for a row that is still above: it alone decides. */
static double rho_by_need(lcp_loop *s, double tol, const lcp_problem *p, const double *z,
                          lcp_result *res) {
  lcp_stop_state *t = &s->stop;
  lcp_rho_factored *f = &s->factored;
  memset(f->whole, 0, (size_t)p->M.n);
  double rho = rho_of_entries(s, p, z);
  res->work.matvecs += 2;
  for (int more = 0; more < 2 && !(rho <= tol); more++) {
    lcp_rho_above_tol(p, tol, t->d, z, t->w, t->zref, t->tau, f->again);
    if (more > 0) {
      lcp_rho_factored_neighbours(f, p->M.factored, f->again);
    }
    if (!widen(f, p->M.n)) {
      break;
    }
    rho = rho_of_more_entries(s, p, z);
    res->work.matvecs += 2;
  }
  return rho;
}

/* s->seen = tau0 at z: that of the entries of M; where M is held in factors, the bound that lcp_stop_test used. */
static void sizes(lcp_loop *s, const lcp_problem *p, const double *z) {
  lcp_rho_product(p, z, NULL, s->seen);
  for (int i = 0; p->M.storage == LCP_FACTORED && i < p->M.n; i++) {
    s->seen[i] = fmax(s->seen[i], s->stop.tau[i] - fabs(p->q[i]));
  }
}

/* Two things can be wrong with the answer of lcp_stop_test: it accepts a z that ran away, and of a factored M, where
 * it bounds rho from one product, it cannot see how large terms were that cancel (sigma rows of friction, contacts that
 * neither carry nor move) and refuses forever. Both are settled here. */
static bool settle(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, const double *z,
                   lcp_result *res) {
  if (res->residual <= stop->tol) {
    sizes(s, p, z);
    res->work.matvecs++;
  } else if (p->M.storage == LCP_FACTORED && near(s, stop, p, z)) {
    res->residual = fmin(res->residual, rho_by_need(s, stop->tol, p, z, res));
  } else {
    return false;
  }
  s->tests = 0; /* `seen` was overwritten: cycle detection starts again */
  s->next = 1;
  return res->residual <= stop->tol && believable(s, stop, p, z, s->seen);
}

bool lcp_loop_met(lcp_loop *s, double tol, const lcp_problem *p, const double *z, lcp_result *res) {
  if (!lcp_stop_met(&s->stop, tol, p, z, res) && p->M.storage == LCP_FACTORED) {
    res->residual = fmin(res->residual, rho_by_need(s, tol, p, z, res));
    s->tests = 0;
    s->next = 1;
  }
  return res->residual <= tol;
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

static bool cycles(lcp_loop *s, const lcp_problem *p, const double *z, lcp_result *res) {
  const bool cycle = s->memoryless && repeats(s, p->M.n, z);
  if (cycle) {
    res->outcome = LCP_STALLED;
  }
  return cycle;
}

/* Are there entries of rows with q = 0 that are within `share` of the largest? They go to s->small. Their number. */
static int find_small(lcp_loop *s, const lcp_problem *p, double share, const double *z) {
  double top = 0.0;
  int count = 0;
  for (int i = 0; i < p->M.n; i++) {
    top = fmax(top, fabs(z[i]) / s->scale[i]);
  }
  for (int i = 0; i < p->M.n; i++) {
    const bool is = p->q[i] == 0.0 && z[i] != 0.0 && fabs(z[i]) / s->scale[i] <= share * top;
    s->small[i] = is ? z[i] : 0.0;
    count += is;
  }
  return count;
}

/* Does z pass with zeros in their place? If not, it is as before. */
static bool passes_without(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, double *z,
                           lcp_result *res) {
  for (int i = 0; i < p->M.n; i++) {
    z[i] = (s->small[i] != 0.0) ? 0.0 : z[i];
  }
  (void)lcp_stop_met(&s->stop, stop->tol, p, z, res);
  if (settle(s, stop, p, z, res)) {
    return true;
  }
  for (int i = 0; i < p->M.n; i++) {
    z[i] = (s->small[i] != 0.0) ? s->small[i] : z[i];
  }
  return false;
}

/* Tried where another number of entries is small than before, and after 1, 2, 4, ... tests: first all within rounding of the largest,
 * then those beyond even that of rounding, as an answer may be small and not zero. Where none pass, s->stop.w is that of z again. */
static bool passes_with_zeros(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, double *z,
                              lcp_result *res) {
  if (!s->homogeneous) {
    return false;
  }
  const int count = find_small(s, p, DBL_EPSILON, z);
  const bool due = ++s->failed >= s->due;
  if (count == 0 || !(due || (count != s->tried && s->tries < TRIES))) {
    return false;
  }
  const double residual = res->residual;
  s->due = due ? 2 * s->failed : s->due;
  s->tries += count != s->tried;
  s->tried = count;
  if (passes_without(s, stop, p, z, res)) {
    return true;
  }
  const int fewer = find_small(s, p, DBL_EPSILON * DBL_EPSILON, z);
  if (fewer > 0 && fewer < count && passes_without(s, stop, p, z, res)) {
    return true;
  }
  (void)lcp_stop_met(&s->stop, stop->tol, p, z, res);
  res->residual = residual;
  return false;
}

static bool spent(const lcp_loop *s, lcp_result *res, bool *fresh) {
  if (fresh != NULL) {
    *fresh = res->work.iterations == 0;
  }
  if (res->work.iterations >= s->budget) {
    res->outcome = LCP_BUDGET;
    return true;
  }
  return false;
}

bool lcp_loop_ended(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, double *z,
                    lcp_trace *trace, lcp_result *res, bool *fresh) {
  if (s->budget > 0) {
    return spent(s, res, fresh);
  }
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
  if (settle(s, stop, p, z, res) || passes_with_zeros(s, stop, p, z, res)) {
    res->outcome = LCP_SOLVED;
    return true;
  }
  res->outcome = otherwise;
  if (last) {
    return true;
  }
  return cycles(s, p, z, res);
}

bool lcp_loop_put_off(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, const double *z,
                      lcp_result *res) {
  if (base_seconds() - s->stop.started > stop->max_seconds) {
    res->outcome = LCP_TIME_LIMIT;
    return true;
  }
  return cycles(s, p, z, res);
}

long lcp_loop_until_test(const lcp_loop *s, const lcp_stop *stop, const lcp_result *res) {
  const long every = stop->check_every, done = res->work.iterations;
  if (s->budget > 0) {
    return s->budget - done;
  }
  const long due = every - done % every, left = stop->max_iter - done;
  return (due < left) ? due : left;
}

void lcp_loop_stationary(lcp_loop *s, const lcp_stop *stop, const lcp_problem *p, double *z,
                         lcp_trace *trace, lcp_result *res) {
  const lcp_stop now = {stop->tol, stop->max_iter, 1, stop->max_seconds};
  if (!lcp_loop_ended(s, &now, p, z, trace, res, NULL)) {
    res->outcome = LCP_STALLED;
  }
}

void lcp_loop_product(lcp_loop *s, const lcp_problem *p, const double *z, bool fresh, double *w,
                      lcp_result *res) {
  if (fresh) {
    memcpy(w, s->stop.w, (size_t)p->M.n * sizeof *w);
    return;
  }
  lcp_matrix_apply(&p->M, z, p->q, w, s->stop.scratch);
  res->work.matvecs++;
}
