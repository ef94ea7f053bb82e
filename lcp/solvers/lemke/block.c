#include "lcp/solvers/lemke/block.h"

#include <limits.h>
#include <math.h>

static const lemke_tolerance tolerance = {1e-11, 1e-12, false};

void lemke_block_layout(lemke_block *k, int rows, base_arena *a) {
  *k = (lemke_block){.path = {.deadline = HUGE_VAL}};
  lemke_path_layout(&k->path, rows, a);
  lemke_table_layout(&k->table, rows, a);
  k->power = BASE_ARRAY(a, int, rows);
}

/* Rows without a diagonal: the largest entry that joins them to a row with one, scaled there, becomes 1. */
static int power_of_zero(const lemke_block *k, int m, const double *M, int i) {
  int top = INT_MIN;
  for (int j = 0; j < m; ++j) {
    const double v = fmax(fabs(M[i + j * m]), fabs(M[j + i * m]));
    if (M[j + j * m] > 0 && v > 0) {
      const int e = lemke_exponent(v) + k->power[j];
      top = (e > top) ? e : top;
    }
  }
  return (top == INT_MIN) ? 0 : -top;
}

/* False where the numbers are too far apart for the tableau. */
static bool scale(lemke_block *k, int m, const double *M) {
  bool good = true;
  for (int i = 0; i < m; ++i) {
    k->power[i] = (M[i + i * m] > 0) ? -lemke_exponent(M[i + i * m]) / 2 : 0;
  }
  for (int i = 0; i < m; ++i) {
    if (!(M[i + i * m] > 0)) {
      k->power[i] = power_of_zero(k, m, M, i);
      good = good && k->power[i] >= -500 && k->power[i] <= 500;
    }
  }
  return good;
}

bool lemke_block_solve(lemke_block *k, int m, const double *M, const double *q, double *z) {
  lemke_engine *e = &k->table.engine;
  lemke_system *s = &k->system;
  if (!scale(k, m, M) || !lemke_system_over(s, m, M, q, k->power, k->power)) {
    return false;
  }
  memset(k->path.in_z, 0, (size_t)m);
  k->path.pivots = 0;
  k->path.pivot_limit = 100L * m;
  if (lemke_path_run(&k->path, e, s, tolerance) != LEMKE_SOLVED) {
    return false;
  }
  for (int i = 0; i < m; ++i) {
    const int at = e->where[m + i];
    z[i] = (at < 0) ? 0 : ldexp(lemke_larger(e->x[at], 0), s->q_exp + k->power[i]);
  }
  return true;
}
