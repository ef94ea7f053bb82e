/* Proof of infeasibility from a ray. For M positive semidefinite, or copositive-plus, the z-part of
 * a terminating ray is a Farkas vector (Cottle, Pang & Stone 1992, theorem 4.4.11). */
#include "lcp/solvers/lemke.h"

#include <math.h>
#include <string.h>

/* A row with w_i < 0 for every z >= 0. */
static bool hopeless_row(const lemke_system *s, const lcp_problem *p, double *y) {
  memset(y, 0, sizeof(double) * (size_t)p->M.n);
  for (int i = 0; i < p->M.n; ++i) {
    s->row_top[i] = s->is_free[i] ? 0 : -1; /* sign of the largest entry */
  }
  for (int j = 0; j < p->M.n; ++j) {
    for (int k = s->colptr[j]; k < s->colptr[j + 1]; ++k) {
      if (s->val[k] > 0 || s->is_free[j]) {
        s->row_top[s->rowind[k]] = 1;
      }
    }
  }
  for (int i = 0; i < p->M.n; ++i) {
    if (s->row_top[i] < 0 && p->q[i] < 0) {
      y[i] = 1;
      return true;
    }
  }
  return false;
}

/* The ray: basic values move by -d, the driving variable by 1. */
static void read_ray(const lemke_path *t, const lemke_system *s, double *y) {
  for (int i = 0; i < s->n; ++i) {
    const int var = s->rows + i;
    const int at = t->basis.where[var];
    const double v = (var == t->entering) ? 1 : (at < 0) ? 0 : -t->d[at];
    y[i] = ldexp((v > 0 || s->is_free[i]) ? v : 0, s->col_exp[i]);
  }
}

bool lemke_farkas(const lemke_path *t, const lemke_system *s, const lcp_problem *p, double *y) {
  if (p->M.storage != LCP_FACTORED && hopeless_row(s, p, y)) {
    return true;
  }
  read_ray(t, s, y);
  if (lcp_farkas_prove(&p->M, p->q, s->is_free, s->force, y)) {
    return true;
  }
  read_ray(t, s, y); /* undo the rounding */
  return false;
}
