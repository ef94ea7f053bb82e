/* Proof of infeasibility from a ray. For M positive semidefinite, or copositive-plus, the z-part of
 * a terminating ray is a Farkas vector (Cottle, Pang & Stone 1992, theorem 4.4.11). */
#include "lcp/solvers/lemke/proof.h"

#include <math.h>
#include <string.h>

/* A row with w_i < 0 for every z >= 0. */
static bool hopeless_row(const lemke_system *s, const lcp_problem *p, double *y) {
  memset(y, 0, sizeof(double) * (size_t)p->M.n);
  for (int i = 0; i < p->M.n; ++i) {
    s->row_top[i] = lemke_is_free(s, i) ? 0 : -1; /* sign of the largest entry */
  }
  for (int j = 0; j < p->M.n; ++j) {
    const lcp_column c = lemke_system_column(s, j);
    for (int k = 0; k < c.count; ++k) {
      if (c.val[k] > 0 || (c.val[k] != 0 && lemke_is_free(s, j))) {
        s->row_top[(c.row == NULL) ? k : c.row[k]] = 1;
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
    const int at = t->engine->where[var];
    const double v = (var == t->entering) ? 1 : (at < 0) ? 0 : -t->d[at];
    y[i] = ldexp((v > 0 || lemke_is_free(s, i)) ? v : 0, s->col_exp[i]);
  }
}

bool lemke_ray_proves(const lemke_path *t, const lemke_system *s, const lcp_problem *p, double *y) {
  if (p->M.storage != LCP_FACTORED && hopeless_row(s, p, y)) {
    return true;
  }
  read_ray(t, s, y);
  if (lcp_farkas_prove(&p->M, p->q, s->any_free ? s->is_free : NULL, s->force, y)) {
    return true;
  }
  read_ray(t, s, y); /* undo the rounding */
  return false;
}

/* First of the data as they are, whose proof may be made of plain numbers, then with a margin that survives the rounding of
 * y. Where the first finds a feasible point, no y proves anything. */
static const double lifts[] = {0, 0x1p-28};

bool lemke_search_proof(lemke_path *t, lemke_table *table, const lemke_system *s,
                        const lcp_problem *p, double *y) {
  for (int k = 0; k < BASE_COUNT(lifts); ++k) {
    const lemke_end end = lemke_phase_one(t, table, s, (lemke_phase){.lift = lifts[k]}, y);
    for (int i = 0; i < s->n && s->row_exp != NULL && end == LEMKE_RAY; ++i) {
      y[i] = ldexp(y[i], s->row_exp[i]);
    }
    if (end == LEMKE_RAY && lcp_farkas_prove(&p->M, p->q, NULL, s->force, y)) {
      return true;
    }
    if (end == LEMKE_SOLVED || end == LEMKE_LIMIT || end == LEMKE_TIMEOUT) {
      return false;
    }
  }
  return false;
}
