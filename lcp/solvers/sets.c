#include "lcp/solvers/sets.h"

#include "lcp/lcp_column.h"

static void fill(const lcp_problem *p, lcp_set set, int first, int end, double *lo, double *hi) {
  for (int i = first; i < end; i++) {
    lo[i] = (set == LCP_BOX) ? p->lo[i] : ((set == LCP_FREE) ? -HUGE_VAL : 0.0);
    hi[i] = (set == LCP_BOX) ? p->hi[i] : HUGE_VAL;
  }
}

void lcp_set_intervals(const lcp_problem *p, double *lo, double *hi) {
  if (p->block == NULL) {
    fill(p, LCP_ORTHANT, 0, p->M.n, lo, hi);
    return;
  }
  for (int b = 0; b < p->n_block; b++) {
    const lcp_block *k = &p->block[b];
    fill(p, k->set, k->start, k->start + k->size, lo, hi);
  }
}

/* Entry m at (i, j): the line with zero diagonal remembers its largest entry, scaled by the other. */
static void meet(const double *d, int i, int j, double m, double *s) {
  if (!(d[i] > 0.0) && d[j] > 0.0) {
    s[i] = fmax(s[i], fabs(m) / sqrt(d[j]));
  }
  if (!(d[j] > 0.0) && d[i] > 0.0) {
    s[j] = fmax(s[j], fabs(m) / sqrt(d[i]));
  }
}

void lcp_set_scaling(const lcp_matrix *M, const double *d, double *s) {
  bool any_zero = false; /* else no entry counts but the diagonal's */
  for (int i = 0; i < M->n; i++) {
    s[i] = 0.0;
    any_zero = any_zero || !(d[i] > 0.0);
  }
  for (int j = 0; j < M->n && any_zero;
       j++) { /* a zero on the diagonal of J W J' is a zero row: S alone counts there */
    const lcp_column c = lcp_column_of(M, j);
    for (int k = 0; k < c.count; k++) {
      meet(d, lcp_column_row(&c, k), j, c.val[k], s);
    }
  }
  for (int i = 0; i < M->n; i++) {
    s[i] = (d[i] > 0.0) ? 1.0 / sqrt(d[i]) : ((s[i] > 0.0) ? 1.0 / s[i] : 1.0);
  }
}

void lcp_set_binary_scaling(const lcp_matrix *M, double *s) {
  lcp_matrix_diagonal(M, s);
  for (int i = 0; i < M->n; i++) {
    int e = 0;
    (void)frexp(s[i], &e);
    s[i] = (s[i] != 0.0) ? ldexp(1.0, -e / 2) : 1.0;
  }
}

bool lcp_set_symmetric(const lcp_problem *p) {
  return (p->traits & LCP_SYMMETRIC) != 0 || lcp_matrix_is_symmetric(&p->M);
}

bool lcp_set_still(const lcp_problem *p, double d, int i) {
  bool zero = d == 0.0;
  const lcp_column c = lcp_column_of(&p->M, i);
  for (int k = 0; zero && k < c.count; k++) {
    zero = c.val[k] == 0.0;
  }
  return zero && lcp_set_symmetric(p);
}
