#include "lcp/solvers/lemke/path.h"

#include "lcp/base/clock.h"
#include "lcp/base/rng.h"

#include <assert.h>
#include <math.h>

enum { TIME_EVERY = 16 };   /* pivots between looks at the clock */
enum { GENERIC_FROM = 16 }; /* rows from which ties are first compared by the generic column */
static const double lex_noise = 1e-12; /* round-off of a lexicographic column [1] */
static const double dependent =
    1e-7; /* a pivot this small of its column makes no first basis [1] */

void lemke_path_layout(lemke_path *t, int rows, base_arena *a) {
  const size_t n = (size_t)rows;
  t->room = BASE_ARRAY(a, double, n);
  t->lex = BASE_ARRAY(a, double, n);
  t->sum = BASE_ARRAY(a, long double, n);
  t->first = BASE_ARRAY(a, int, n);
  t->tied = BASE_ARRAY(a, int, n);
  t->in_z = BASE_ARRAY(a, unsigned char, n);
}

bool lemke_path_late(lemke_path *t) {
  const double now = base_seconds();
  if (t->deadline < 0) {
    t->deadline = now + t->max_seconds;
  }
  return now >= t->deadline;
}

static int complement(int var, int n) {
  return (var < n) ? var + n : var - n;
}

/* Is the variable in this position bounded below by zero? */
static bool bounded(const lemke_path *t, int pos) {
  const int n = t->engine->n;
  const int var = t->engine->head[pos];
  return !t->system->any_free || var == 2 * n || !t->system->is_free[var % n];
}

/* ---- ties ------------------------------------------------------------------------------------- */

/* Keeps those ties whose row of v has the smallest v/d up to round-off; returns how many are left. */
static int keep_smallest(lemke_path *t, const double *v, const double *d, int count) {
  const double noise = lex_noise * lemke_largest(v, t->engine->n);
  double low = HUGE_VAL;
  int keep = 0;
  for (int k = 0; k < count; ++k) {
    low = -lemke_larger(-low, -(v[t->tied[k]] + noise) / d[t->tied[k]]);
  }
  for (int k = 0; k < count; ++k) {
    if (v[t->tied[k]] <= low * d[t->tied[k]]) {
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

/* Drops from tied[0..count) all but the lexicographically smallest row of [delta, B^-1 B_first] / d, which it
 * returns: any matrix with lexicographically positive rows ends the path (Cottle, Pang & Stone 1992, 4.9). The
 * generic column delta, used on larger problems, decides almost every tie in one comparison. */
static int break_ties(lemke_path *t, const double *d, int count) {
  lemke_engine *e = t->engine;
  count = e->generic ? keep_smallest(t, e->delta, d, count) : count;
  for (int j = 0; j < e->n && count > 1; ++j) {
    const int var = t->first[j];
    const int at = e->where[var];
    if (at >= 0) { /* a basic column is a unit vector: only its own row has the entry 1/d > 0 */
      count = keep_others(t, at, count);
    } else {
      count = keep_smallest(t, e->kind->column(e, var, t->lex), d, count);
    }
  }
  return t->tied[0];
}

/* ---- ratio test ------------------------------------------------------------------------------- */

/* How far below zero a basic value counts as zero; the bound of Harris (1973) makes ratios ties that agree up to
 * this. In a local path it goes by the size of the terms that the basic variable is made of, as lemke_residual
 * left it: round-off in a body that barely moves is small against its own data, not against those of the whole
 * scene. */
static double slack_of(const lemke_path *t, int pos, double common) {
  const int n = t->engine->n;
  const int var = t->engine->head[pos];
  if (!t->tol.local) {
    return common;
  }
  return t->tol.tie * ((var == 2 * n) ? fabs(t->engine->x[pos])
                       : (var < n)    ? t->system->tau0[var]
                                      : t->system->zref[var - n]);
}

/* max |x_i|, and max |d_i| in *size_d, in one pass of two chains each. */
static double size_up(const lemke_path *t, double *size_d) {
  const double *d = t->d;
  const double *x = t->engine->x;
  const int n = t->engine->n;
  double top_d[2] = {0, 0};
  double top_x[2] = {0, 0};
  int i = 0;
  for (; i + 2 <= n; i += 2) {
    top_d[0] = lemke_larger(fabs(d[i]), top_d[0]);
    top_d[1] = lemke_larger(fabs(d[i + 1]), top_d[1]);
    top_x[0] = lemke_larger(fabs(x[i]), top_x[0]);
    top_x[1] = lemke_larger(fabs(x[i + 1]), top_x[1]);
  }
  if (i < n) {
    top_d[0] = lemke_larger(fabs(d[i]), top_d[0]);
    top_x[0] = lemke_larger(fabs(x[i]), top_x[0]);
  }
  *size_d = lemke_larger(top_d[0], top_d[1]);
  return lemke_larger(top_x[0], top_x[1]);
}

/* Lists in `tied` the positions whose ratio is the smallest one up to round-off; z0 alone where it is one of them. */
static int list_ties(lemke_path *t) {
  const lemke_engine *e = t->engine;
  const int n = e->n;
  const double *d = t->d;
  const double *x = e->x;
  double size_d = 0;
  const double slack = t->tol.tie * lemke_larger(1, size_up(t, &size_d));
  const double small = t->tol.pivot * size_d;
  const bool plain = !t->system->any_free && !t->tol.local;
  int *restrict tied = t->tied;
  double bound = HUGE_VAL;
  int count = 0;
  for (int i = 0; i < n; ++i) {
    if (d[i] > small && (plain || bounded(t, i))) {
      const double room = lemke_larger(x[i], 0) + (plain ? slack : slack_of(t, i, slack));
      bound = (room < bound * d[i]) ? room / d[i] : bound;
      tied[count++] = i;
    }
  }
  int keep = 0;
  for (int k = 0; k < count; ++k) {
    const int i = tied[k];
    if (x[i] <= bound * d[i]) {
      if (e->head[i] == 2 * n) {
        tied[0] = i;
        return 1;
      }
      tied[keep++] = i;
    }
  }
  return keep;
}

/* Position of the basic variable that blocks the entering one, or -1 for a ray. */
static int ratio_test(lemke_path *t) {
  const int count = list_ties(t);
  return (count == 0) ? -1 : (count == 1) ? t->tied[0] : break_ties(t, t->d, count);
}

/* ---- the path --------------------------------------------------------------------------------- */

/* Mixes a variable into the hash of the nonbasic set (splitmix64 finaliser). */
static uint64_t mixed(int var) {
  base_rng r = base_rng_seeded((uint64_t)var + 1);
  return base_rng_bits(&r);
}

/* The path with exact numbers never meets a basis twice. One that does is lost to round-off: found by comparing with
 * the basis noted at the last power of two (Brent 1980), once there were as many pivots as rows. */
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
  lemke_engine *e = t->engine;
  const int n = e->n;
  t->hash = 0;
  t->noted = 1;
  t->period = 1;
  t->until_note = 1;
  for (int step = 1;; ++step) {
    if (t->pivots >= t->pivot_limit) {
      return LEMKE_LIMIT;
    }
    if (step % TIME_EVERY == 0 && lemke_path_late(t)) {
      return LEMKE_TIMEOUT;
    }
    t->d = e->kind->column(e, t->entering, t->room);
    const int p = ratio_test(t);
    if (p < 0) {
      return LEMKE_RAY;
    }
    const int left = e->head[p];
    const bool held = e->kind->replace(e, p, t->entering, t->d);
    t->pivots++;
    if (left == 2 * n) {
      return LEMKE_SOLVED;
    }
    if (!held) {
      return LEMKE_BROKEN;
    }
    if (step > n && repeats(t, left)) {
      return LEMKE_CYCLE;
    }
    t->entering = complement(left, n);
  }
}

/* delta > 0, the same in every run, without the linear relations that contacts of one body have. */
static void start_generic(lemke_path *t) {
  lemke_engine *e = t->engine;
  base_rng random = base_rng_seeded(1965);
  e->generic = e->n >= GENERIC_FROM;
  for (int i = 0; i < e->n && e->generic; ++i) {
    const double v = base_rng_between(&random, 1, 2);
    e->delta[i] = bounded(t, i) ? v : 0;
  }
}

/* The smallest of equals in the column of z0, -d of which is 1 in every row that can leave. */
static int break_first_tie(lemke_path *t, int count) {
  const int n = t->engine->n;
  for (int i = 0; i < n; ++i) {
    t->room[i] = -t->room[i];
  }
  const int p = break_ties(t, t->room, count);
  for (int i = 0; i < n; ++i) {
    t->room[i] = -t->room[i];
  }
  return p;
}

/* Brings z0 in against the most negative basic value; false when there is none. The covering vector is B 1: all
 * ones in the basis the path starts from, or in its negative rows. */
static bool enter_cover(lemke_path *t, bool *held) {
  lemke_engine *e = t->engine;
  const int n = e->n;
  const double common = t->tol.tie * lemke_larger(1, lemke_largest(e->x, n));
  const double slack = t->tol.local ? 0 : common;
  double low = -slack;
  bool any = false;
  for (int i = 0; i < n; ++i) {
    const bool covered = bounded(t, i) && (!t->tol.local || e->x[i] < -slack_of(t, i, common));
    t->room[i] = covered ? -1 : 0;
    any = any || (covered && e->x[i] < low);
    low = (e->x[i] < low && bounded(t, i)) ? e->x[i] : low;
  }
  if (!any) {
    return false;
  }
  e->kind->open(e, t->room);
  int count = 0;
  for (int i = 0; i < n; ++i) {
    if (t->room[i] != 0 && e->x[i] <= low + slack) {
      t->tied[count++] = i;
    }
  }
  const int p = (count == 1) ? t->tied[0] : break_first_tie(t, count);
  const int left = e->head[p];
  *held = e->kind->replace(e, p, 2 * n, t->room);
  t->pivots++;
  t->entering = complement(left, n);
  return true;
}

/* From the basis that the engine holds, with its values. */
static lemke_end walk(lemke_path *t) {
  const lemke_engine *e = t->engine;
  const int n = e->n;
  bool held = true;
  for (int i = 0; i < n; ++i) {
    t->first[i] = t->in_z[i] ? n + i : i;
  }
  start_generic(t);
  const lemke_end end = !enter_cover(t, &held) ? LEMKE_SOLVED : held ? follow(t) : LEMKE_BROKEN;
  for (int i = 0; i < n; ++i) {
    t->in_z[i] = e->where[n + i] >= 0;
  }
  return end;
}

lemke_end lemke_path_go_on(lemke_path *t, lemke_engine *e, const lemke_system *s,
                           lemke_tolerance tol) {
  t->engine = e;
  t->system = s;
  t->tol = tol;
  for (int i = 0; i < e->n; ++i) {
    t->in_z[i] = e->where[e->n + i] >= 0;
  }
  return walk(t);
}

lemke_end lemke_path_run(lemke_path *t, lemke_engine *e, const lemke_system *s,
                         lemke_tolerance tol) {
  t->engine = e;
  t->system = s;
  t->tol = tol;
  return e->kind->fill(e, s, t->in_z) ? walk(t) : LEMKE_BROKEN;
}

bool lemke_path_take(lemke_path *t, lemke_engine *e, int i) {
  const int at = e->where[i];
  const double *d = e->kind->column(e, e->n + i, t->room);
  assert(at >= 0);
  e->generic = false;
  return fabs(d[at]) > dependent * lemke_largest(d, e->n) && e->kind->replace(e, at, e->n + i, d);
}

void lemke_path_refine(lemke_path *t, lemke_engine *e, const lemke_system *s) {
  lemke_system_defect(s, e->head, e->x, t->sum, t->lex);
  e->kind->settle(e, t->lex);
}

bool lemke_path_settle(lemke_path *t, lemke_engine *e, const lemke_system *s, int passes) {
  t->engine = e;
  t->system = s;
  const bool held = e->kind->fill(e, s, t->in_z);
  for (int pass = 0; pass < passes && held; ++pass) {
    lemke_path_refine(t, e, s);
  }
  return held;
}
