#include "lcp/solvers/cone_sweep.h"

#include "lcp/solvers/cone_block.h"
#include "lcp/solvers/sets.h"

#include <string.h>

void lcp_cone_sweep_layout(lcp_cone_sweep *s, const lcp_capacity *cap, base_arena *a) {
  lcp_sweep_layout(&s->sweep, cap, a);
  s->lo = BASE_ARRAY(a, double, cap->n);
  s->hi = BASE_ARRAY(a, double, cap->n);
  s->A = BASE_ARRAY(a, double, (size_t)cap->n *(size_t)LCP_CONE_MAX);
}

static const lcp_block *blocks(const lcp_problem *p, lcp_block *whole, int *count) {
  *whole = (lcp_block){.start = 0, .size = p->M.n, .set = LCP_ORTHANT};
  *count = (p->block != NULL) ? p->n_block : 1;
  return (p->block != NULL) ? p->block : whole;
}

base_status lcp_cone_sweep_prepare(lcp_cone_sweep *s, const lcp_problem *p, base_error *err) {
  BASE_TRY(lcp_sweep_prepare(&s->sweep, p, err));
  for (int i = 0; i < p->M.n; i++) {
    if (!(s->sweep.d[i] > 0.0) && !lcp_set_still(p, s->sweep.d[i], i)) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "diagonal %d is %g: need > 0", i, s->sweep.d[i]);
    }
  }
  lcp_set_intervals(p, s->lo, s->hi);
  lcp_block whole;
  int count;
  const lcp_block *block = blocks(p, &whole, &count);
  for (int b = 0; b < count; b++) {
    const lcp_block *k = &block[b];
    if (k->set == LCP_CONE && k->size > LCP_CONE_MAX) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED, "cone block %d has %d rows: need at most %d", b,
                       k->size, (int)LCP_CONE_MAX);
    }
    if (k->set == LCP_CONE) {
      lcp_sweep_block(&s->sweep, p, k->start, k->size, s->A + (size_t)k->start * LCP_CONE_MAX);
    }
  }
  return BASE_OK;
}

/* Moves rows of the block to x with relaxation; returns the relative change. */
static double move(lcp_cone_sweep *s, const lcp_problem *p, const lcp_block *k, double omega,
                   const double *x, double *z) {
  double change = 0.0, size = 0.0;
  for (int i = 0; i < k->size; i++) {
    const double old = z[k->start + i];
    const double next = (omega == 1.0) ? x[i] : old + omega * (x[i] - old);
    if (next != old) {
      lcp_sweep_add(&s->sweep, p, k->start + i, next - old);
      z[k->start + i] = next;
    }
    change += fabs(next - old);
    size += fabs(next);
  }
  return (change > 0.0) ? change / (size + change) : 0.0;
}

static double cone(lcp_cone_sweep *s, const lcp_problem *p, const lcp_block *k, double omega,
                   double weight, const double *center, double *z) {
  const int m = k->size;
  double A[LCP_CONE_MAX * LCP_CONE_MAX], b[LCP_CONE_MAX], x[LCP_CONE_MAX];
  memcpy(A, s->A + (size_t)k->start * LCP_CONE_MAX, (size_t)(m * m) * sizeof *A);
  double trace = 0.0;
  for (int i = 0; i < m; i++) {
    trace += A[i + i * m];
  }
  const double spring = weight * trace / m;
  for (int i = 0; i < m; i++) {
    b[i] = lcp_sweep_row(&s->sweep, p, k->start + i);
    for (int j = 0; j < m; j++) {
      b[i] -= A[i + j * m] * z[k->start + j];
    }
    b[i] -= (weight > 0.0) ? spring * center[k->start + i] : 0.0;
  }
  for (int i = 0; i < m; i++) {
    A[i + i * m] += spring;
  }
  lcp_cone_solve(k, A, b, x);
  return move(s, p, k, omega, x, z);
}

static double rows(lcp_cone_sweep *s, const lcp_problem *p, const lcp_block *k, double omega,
                   double weight, const double *center, double *z) {
  double worst = 0.0;
  for (int i = k->start; i < k->start + k->size; i++) {
    const double spring = weight * s->sweep.d[i];
    double w = lcp_sweep_row(&s->sweep, p, i);
    w += (weight > 0.0) ? spring * (z[i] - center[i]) : 0.0;
    const double x =
        (s->sweep.d[i] > 0.0)
            ? lcp_set_clip(z[i] - omega * (w / (s->sweep.d[i] + spring)), s->lo[i], s->hi[i])
            : lcp_set_end(z[i], w, s->lo[i], s->hi[i]);
    const lcp_block one = {.start = i, .size = 1};
    worst = fmax(worst, move(s, p, &one, 1.0, &x, z));
  }
  return worst;
}

double lcp_cone_sweep_run(lcp_cone_sweep *s, const lcp_problem *p, double omega, double weight,
                          const double *center, double *z) {
  lcp_block whole;
  int count;
  const lcp_block *block = blocks(p, &whole, &count);
  double worst = 0.0;
  for (int b = 0; b < count; b++) {
    worst = fmax(
        worst, (block[b].set == LCP_CONE ? cone : rows)(s, p, &block[b], omega, weight, center, z));
  }
  return worst;
}
