/* The lexicographic ratio test of a path, with ties up to round-off. */
#include "lcp/solvers/lemke.h"

#include <math.h>

static const double lex_noise = 1e-12; /* round-off of a lexicographic column [1] */
static const double keep_share =
    1e-10; /* among ties, pivots below this share of the largest go [1] */

double lemke_largest(const double *x, int n) {
  double top[4] = {0, 0, 0, 0}; /* four chains run side by side */
  int i = 0;
  for (; i + 4 <= n; i += 4) {
    top[0] = lemke_larger(fabs(x[i]), top[0]);
    top[1] = lemke_larger(fabs(x[i + 1]), top[1]);
    top[2] = lemke_larger(fabs(x[i + 2]), top[2]);
    top[3] = lemke_larger(fabs(x[i + 3]), top[3]);
  }
  for (; i < n; ++i) {
    top[0] = lemke_larger(fabs(x[i]), top[0]);
  }
  return lemke_larger(lemke_larger(top[0], top[1]), lemke_larger(top[2], top[3]));
}

/* Keeps those ties whose row of v has the smallest v/d up to round-off; returns how many are left. */
static int keep_smallest(lemke_path *t, const double *v, int count) {
  const double noise = lex_noise * lemke_largest(v, t->sys.n);
  double low = HUGE_VAL;
  int keep = 0;
  for (int k = 0; k < count; ++k) {
    low = -lemke_larger(-low, -(v[t->tied[k]] + noise) / t->d[t->tied[k]]);
  }
  for (int k = 0; k < count; ++k) {
    if (v[t->tied[k]] <= low * t->d[t->tied[k]]) {
      t->tied[keep++] = t->tied[k];
    }
  }
  return keep;
}

/* Drops position `at` from the ties. */
static int keep_others(lemke_path *t, int at, int count) {
  int keep = 0;
  for (int k = 0; k < count; ++k) {
    if (t->tied[k] != at) {
      t->tied[keep++] = t->tied[k];
    }
  }
  return keep;
}

int lemke_break_ties(lemke_path *t, int count) {
  const int n = t->sys.n;
  count = t->generic ? keep_smallest(t, t->delta, count) : count;
  for (int j = 0; j < n && count > 1; ++j) {
    const int var = t->first[j];
    const int at = t->basis.where[var];
    if (at >= 0) { /* a basic column is a unit vector: only its own row has the entry 1/d > 0 */
      count = keep_others(t, at, count);
    } else {
      count = keep_smallest(t, lemke_path_column(t, var), count);
    }
  }
  return t->tied[0];
}

/* In a local path the tie tolerance goes by the size of the terms that the basic variable is made of,
 * as lemke_residual left it: round-off in a body that barely moves is small against its own data, not
 * against those of the whole scene. */
double lemke_slack(const lemke_path *t, int i, double common) {
  const int n = t->sys.n;
  const int var = t->basis.head[i];
  if (!t->tol.local) {
    return common;
  }
  const double z0 = fabs(t->x[i]);
  return t->tol.tie * ((var == 2 * n) ? z0
                       : (var < n)    ? t->system->tau0[var]
                                      : t->system->zref[var - n]);
}

int lemke_ratio_test(lemke_path *t) {
  const int n = t->sys.n;
  const double small = t->tol.pivot * t->size_d;
  const double slack = t->tol.tie * lemke_larger(1, lemke_largest(t->x, n));
  int *tied = t->tied;
  double bound = HUGE_VAL;
  int count = 0;
  for (int i = 0; i < n; ++i) {
    if (t->d[i] > small && t->may_leave[i]) {
      const double room =
          lemke_larger(t->x[i], 0) + (t->tol.local ? lemke_slack(t, i, slack) : slack);
      bound = (room < bound * t->d[i]) ? room / t->d[i] : bound;
      tied[count++] = i;
    }
  }
  double top = 0;
  int keep = 0;
  for (int k = 0; k < count; ++k) {
    const int i = tied[k];
    if (t->x[i] <= bound * t->d[i]) {
      if (t->basis.head[i] == 2 * n) {
        return i;
      }
      top = lemke_larger(t->d[i], top);
      tied[keep++] = i;
    }
  }
  count = keep;
  keep = 0;
  for (int k = 0; k < count; ++k) {
    if (t->d[tied[k]] >= keep_share * top) {
      tied[keep++] = tied[k];
    }
  }
  return (keep == 0) ? -1 : (keep == 1) ? tied[0] : lemke_break_ties(t, keep);
}
