/* Lemke's complementary path with lexicographic choice (Lemke 1965; Cottle, Pang & Stone 1992,
 * algorithm 4.4.5 and section 4.9), on a factored basis. */
#include "lcp/base/clock.h"
#include "lcp/base/rng.h"
#include "lcp/solvers/lemke.h"

#include <math.h>
#include <string.h>

enum { TIME_EVERY = 16 };   /* pivots between looks at the clock */
enum { REPAIRS = 64 };      /* rounds of repairing a singular first basis */
enum { GENERIC_FROM = 16 }; /* rows from which ties are first compared by the generic column */
static const double doubtful = 1e-7; /* a pivot this small is computed afresh before use [1] */

void lemke_path_layout(lemke_path *t, int rows, int nnz, int table, base_arena *a) {
  const size_t n = (size_t)rows;
  lin_basis_layout(&t->basis, rows, nnz, a);
  lemke_table_layout(&t->table, table, a);
  t->tabular = false;
  t->x = BASE_ARRAY(a, double, n);
  t->d = BASE_ARRAY(a, double, n);
  t->lex = BASE_ARRAY(a, double, n);
  t->cover = BASE_ARRAY(a, double, n);
  t->delta = BASE_ARRAY(a, double, n);
  t->delta_rhs = BASE_ARRAY(a, double, n);
  t->sum = BASE_ARRAY(a, long double, n);
  t->first = BASE_ARRAY(a, int, n);
  t->tied = BASE_ARRAY(a, int, n);
  t->may_leave = BASE_ARRAY(a, unsigned char, n);
  t->tried = BASE_ARRAY(a, unsigned char, n);
  t->in_z = BASE_ARRAY(a, unsigned char, n);
}

static int complement(int var, int n) {
  return (var < n) ? var + n : var - n;
}

static bool bounded(const lemke_path *t, int pos) {
  const int n = t->sys.n;
  const int var = t->basis.head[pos];
  return var == 2 * n || !t->system->is_free[var % n];
}

/* y <- y - t x */
static void subtract(int n, double t, const double *restrict x, double *restrict y) {
  for (int i = 0; i < n; ++i) {
    y[i] -= t * x[i];
  }
}

/* x <- B^-1 r with one step of refinement. */
static void solve_refined(lemke_path *t, const double *r, double *x) {
  const int n = t->sys.n;
  memcpy(x, r, sizeof(double) * (size_t)n);
  lin_basis_solve(&t->basis, x);
  lin_basis_defect(&t->basis, x, r, t->lex);
  lin_basis_solve(&t->basis, t->lex);
  subtract(n, -1, t->lex, x);
}

static bool refactor(lemke_path *t) {
  if (!lin_basis_factor(&t->basis)) {
    return false;
  }
  for (int i = 0; i < t->sys.n; ++i) {
    t->may_leave[i] = bounded(t, i);
  }
  solve_refined(t, t->system->q, t->x);
  if (t->generic) {
    memcpy(t->delta, t->delta_rhs, sizeof(double) * (size_t)t->sys.n);
    lin_basis_solve(&t->basis, t->delta);
  }
  return true;
}

const double *lemke_path_column(lemke_path *t, int var) {
  if (t->tabular) {
    return t->table.a + (ptrdiff_t)t->table.column[var] * t->table.cap;
  }
  lin_basis_column(&t->basis, var, t->lex);
  lin_basis_solve(&t->basis, t->lex);
  return t->lex;
}

/* Enters `entering` at position p; returns the variable that left. */
static int exchange(lemke_path *t, int p) {
  const int n = t->sys.n;
  const double step = t->x[p] / t->d[p];
  subtract(n, step, t->d, t->x);
  t->x[p] = step;
  if (t->generic) {
    const double shift = t->delta[p] / t->d[p];
    subtract(n, shift, t->d, t->delta);
    t->delta[p] = shift;
  }
  const int left = t->basis.head[p];
  if (t->tabular) {
    lemke_table_replace(t, p, t->entering, t->d);
  } else {
    lin_basis_replace(&t->basis, p, t->entering, t->d);
  }
  t->may_leave[p] = bounded(t, p);
  return left;
}

static int pivot(lemke_path *t, int p) {
  t->pivots++;
  return exchange(t, p);
}

static bool covered(const lemke_path *t, int i) {
  return bounded(t, i) && (!t->tol.local || t->x[i] < -lemke_slack(t, i, 0));
}

/* The covering vector whose solved column is d. */
static void store_cover(lemke_path *t) {
  if (t->tabular) {
    lemke_table_cover(t, t->d);
    return;
  }
  memset(t->lex, 0, sizeof *t->lex * (size_t)t->sys.n);
  lin_basis_residual(&t->basis, t->d, t->lex, t->sum); /* 0 - B (-1) */
  for (int i = 0; i < t->sys.n; ++i) {
    t->cover[i] = (double)t->sum[i];
  }
}

/* Brings z0 in against the most negative basic value; false when there is none. The covering
 * vector is B 1: all ones in the basis the path starts from, or in its negative rows. */
static bool enter_cover(lemke_path *t) {
  const int n = t->sys.n;
  int count = 0;
  const double common = t->tol.tie * lemke_larger(1, lemke_largest(t->x, n));
  const double slack = t->tol.local ? 0 : common;
  double low = -slack;
  bool any = false;
  for (int i = 0; i < n; ++i) {
    t->d[i] = covered(t, i) ? -1 : 0;
    any = any || (t->d[i] != 0 && (t->tol.local || t->x[i] < low));
  }
  if (!any) {
    return false;
  }
  store_cover(t);
  for (int i = 0; i < n; ++i) {
    low = bounded(t, i) ? fmin(low, t->x[i]) : low;
  }
  for (int i = 0; i < n; ++i) {
    if (t->d[i] != 0 && t->x[i] <= low + slack) {
      t->tied[count++] = i;
    }
  }
  t->entering = 2 * n;
  for (int i = 0; i < n; ++i) { /* the smallest of equals: -d is 1 in every row that can leave */
    t->d[i] = -t->d[i];
  }
  const int p = lemke_break_ties(t, count);
  for (int i = 0; i < n; ++i) {
    t->d[i] = -t->d[i];
  }
  t->entering = complement(pivot(t, p), n);
  return true;
}

/* Computes d for the entering variable and the blocking position; a pivot that looks doubtful is
 * recomputed from a new factorisation. False when the basis is singular. */
static bool choose(lemke_path *t, int *p) {
  const int n = t->sys.n;
  if (t->tabular) {
    memcpy(t->d, lemke_path_column(t, t->entering), sizeof *t->d * (size_t)n);
    t->size_d = lemke_largest(t->d, n);
    *p = lemke_ratio_test(t);
    return *p < 0 || t->d[*p] > doubtful * t->size_d;
  }
  for (int again = 0; again < 2; ++again) {
    lin_basis_column(&t->basis, t->entering, t->d);
    lin_basis_solve(&t->basis, t->d);
    t->size_d = lemke_largest(t->d, n);
    *p = lemke_ratio_test(t);
    const bool sure = *p >= 0 && t->d[*p] > doubtful * t->size_d;
    if (sure || t->basis.n_eta == 0) {
      return true;
    }
    if (!refactor(t)) {
      return false;
    }
  }
  return true;
}

/* Mixes a variable into the hash of the nonbasic set (splitmix64 finaliser). */
static uint64_t mixed(int var) {
  base_rng r = base_rng_seeded((uint64_t)var + 1);
  return base_rng_bits(&r);
}

static void note_basis(lemke_path *t) {
  for (int i = 0; i < t->sys.n; ++i) {
    t->in_z[i] = t->basis.where[t->sys.n + i] >= 0;
  }
}

/* The path with exact numbers never meets a basis twice. One that does is lost to round-off: found
 * by comparing with the basis noted at the last power of two (Brent 1980). */
static bool repeats(lemke_path *t, int left) {
  t->hash ^= mixed(left) ^ mixed(t->entering);
  const bool same = t->hash == t->noted;
  if (--t->until_note <= 0) {
    t->noted = t->hash;
    t->period *= 2;
    t->until_note = t->period;
  }
  return same;
}

static lemke_end follow(lemke_path *t) {
  const int n = t->sys.n;
  t->hash = 0;
  t->noted = 1;
  t->period = 1;
  t->until_note = 1;
  for (;;) {
    int p = -1;
    if (t->pivots >= t->pivot_limit) {
      return LEMKE_LIMIT;
    }
    if (t->pivots % TIME_EVERY == 0 && base_seconds() > t->deadline) {
      return LEMKE_TIMEOUT;
    }
    if ((!t->tabular && lin_basis_due(&t->basis) && !refactor(t)) || !choose(t, &p)) {
      return LEMKE_BROKEN;
    }
    if (p < 0) {
      return LEMKE_RAY;
    }
    const int left = pivot(t, p);
    if (left == 2 * n) {
      return LEMKE_SOLVED;
    }
    if (repeats(t, left)) {
      return LEMKE_CYCLE;
    }
    t->entering = complement(left, n);
  }
}

/* delta > 0, the same in every run, without the linear relations that contacts of one body have. */
static void start_generic(lemke_path *t) {
  const int n = t->sys.n;
  base_rng random = base_rng_seeded(1965);
  t->generic = n >= GENERIC_FROM;
  if (!t->generic) {
    return;
  }
  for (int i = 0; i < n; ++i) {
    const double v = base_rng_between(&random, 1, 2);
    t->delta[i] = bounded(t, i) ? v : 0;
    t->lex[i] = 0;
  }
  if (t->tabular) {
    return; /* never solved for again */
  }
  lin_basis_residual(&t->basis, t->delta, t->lex, t->sum);
  for (int i = 0; i < n; ++i) {
    t->delta_rhs[i] = -(double)t->sum[i];
  }
}

/* The basis of in_z is there, factored, with its x: nothing was pivoted since. */
static bool is_factored(const lemke_path *t) {
  const int n = t->sys.n;
  bool same = t->basis.fresh && t->basis.where[2 * n] < 0;
  for (int i = 0; i < n && same; ++i) {
    same = (t->basis.where[n + i] >= 0) == (t->in_z[i] != 0);
  }
  return same;
}

/* Row with the largest entry in column j that could join the basis to make column j independent. */
static int helper_row(const lemke_path *t, int j) {
  int best = -1;
  double size = 0;
  for (int p = t->sys.colptr[j]; p < t->sys.colptr[j + 1]; ++p) {
    const int i = t->sys.rowind[p];
    if (!t->system->is_free[i] && !t->in_z[i] && !t->tried[i] && fabs(t->sys.val[p]) > size) {
      size = fabs(t->sys.val[p]);
      best = i;
    }
  }
  return best;
}

/* Factors the first basis. Dependent columns are repaired: a bounded z gives way to its w; a free
 * one is helped by a pair (i, z_i) that makes it independent (rows of M_FF alone may be dependent)
 * or, where there is none, stays at zero as a redundant constraint, its w_i = 0 left to the
 * residual test. */
static bool factor_first(lemke_path *t) {
  if (t->tol.local && is_factored(t)) {
    return true;
  }
  memset(t->tried, 0, (size_t)t->sys.n);
  t->basis.lu.ordering = LIN_BY_COUNT;
  for (int round = 0; round < REPAIRS; ++round) {
    lin_basis_start(&t->basis, &t->sys, t->in_z);
    if (refactor(t)) {
      return true;
    }
    const lin_lu *lu = &t->basis.lu;
    for (int k = lu->n - lu->deficient; k < lu->n; ++k) {
      const int j = t->basis.kernel_var[lu->col[k]] - t->sys.n;
      const int help = t->system->is_free[j] ? helper_row(t, j) : -1;
      const int change = (help >= 0) ? help : j;
      t->in_z[change] = help >= 0;
      t->tried[change] = 1;
    }
    if (t->basis.full) {
      return false;
    }
  }
  return false;
}

static void bind(lemke_path *t, const lemke_system *s, bool tabular) {
  if (t->system != s || t->tabular || tabular) {
    t->basis.fresh = false; /* what is factored is another system's */
  }
  t->tabular = tabular;
  t->system = s;
  t->sys = (lin_system){s->rows, s->colptr, s->rowind, s->val, t->cover};
}

/* From the basis of in_z, which is there with its x. */
static lemke_end walk(lemke_path *t) {
  const int n = t->sys.n;
  for (int i = 0; i < n; ++i) {
    t->first[i] = t->in_z[i] ? n + i : i;
  }
  start_generic(t);
  const lemke_end end = enter_cover(t) ? follow(t) : LEMKE_SOLVED;
  note_basis(t);
  return end;
}

lemke_end lemke_path_run(lemke_path *t, const lemke_system *s, lemke_tolerance tol) {
  bind(t, s, false);
  t->tol = tol;
  t->generic = false;
  return factor_first(t) ? walk(t) : LEMKE_BROKEN;
}

lemke_end lemke_path_run_table(lemke_path *t, const lemke_system *s, lemke_tolerance tol) {
  bind(t, s, true);
  t->tol = tol;
  note_basis(t);
  for (int i = 0; i < t->sys.n; ++i) {
    t->may_leave[i] = bounded(t, i);
  }
  const lemke_end end = walk(t);
  if (end == LEMKE_SOLVED && t->table.covered) {
    lemke_table_uncover(t);
  }
  return end;
}

lemke_end lemke_path_run_small(lemke_path *t, const lemke_system *s, lemke_tolerance tol) {
  lemke_table_fill(t, s);
  return lemke_path_run_table(t, s, tol);
}

bool lemke_path_take(lemke_path *t, const lemke_system *s, int i) {
  bind(t, s, true);
  const int n = t->sys.n;
  const int at = t->basis.where[i];
  memcpy(t->d, lemke_path_column(t, n + i), sizeof *t->d * (size_t)n);
  const bool sure = fabs(t->d[at]) > doubtful * lemke_largest(t->d, n);
  if (sure) {
    t->generic = false;
    t->entering = n + i;
    (void)exchange(t, at);
  }
  return sure;
}

bool lemke_path_settle(lemke_path *t, const lemke_system *s) {
  bind(t, s, false);
  const int n = t->sys.n;
  t->generic = false;
  if (!is_factored(t)) {
    lin_basis_start(&t->basis, &t->sys, t->in_z);
    if (!refactor(t)) {
      return false;
    }
  }
  for (int pass = 0; pass < 2; ++pass) { /* two more corrections: x is then as good as the data */
    lin_basis_residual(&t->basis, t->x, t->system->q, t->sum);
    for (int i = 0; i < n; ++i) {
      t->lex[i] = (double)t->sum[i];
    }
    lin_basis_solve(&t->basis, t->lex);
    for (int i = 0; i < n; ++i) {
      t->x[i] += t->lex[i];
    }
  }
  return true;
}
