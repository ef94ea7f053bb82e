/* ppm_rounded.c - the end of ppm where doubles cannot hold what is asked of w.
 *
 * Two impulses of 5e6 N s whose difference stops 1 kg are on a grid of 1e-9 N s: there may be no vector of doubles that leaves
 * the light body less than 1e-9 m/s, and bases that differ by such velocities cannot be told apart by w in doubles either.
 * So z becomes a sum z + e of doubles, e what rounding takes from z, and the last pivots are chosen by w in long
 * double (iterative refinement in extra precision, demmel2006). What is asked of that w is what
 * data_test.h asks; the z that is returned is z + e to the last bit. */
#include "lcp/solvers/data_test.h"
#include "lcp/solvers/ppm/ppm.h"

#include <float.h>
#include <string.h>

enum { STEPS = 3, PIVOTS_A_ROW = 8 };

/* w at z + e. */
static void look(const ppm *s, const lcp_problem *p, const double *z, lcp_work *work) {
  lcp_ppm_extended(s, p, z, s->e);
  for (int i = 0; i < p->M.n; i++) {
    s->w[i] = (double)s->sum[i];
  }
  work->matvecs++;
}

/* The same sum, z its rounding. */
static void round_sum(const ppm *s, int n, double *z) {
  for (int i = 0; i < n; i++) {
    const double sum = z[i] + s->e[i], of_e = sum - z[i];
    s->e[i] = (z[i] - (sum - of_e)) + (s->e[i] - of_e);
    z[i] = sum;
  }
}

/* To w_F = 0 along e_F -= M_FF^-1 w_F, dropping from F what meets a bound on the way; w is that of the end. */
static void correct(ppm *s, const lcp_problem *p, double *z, lcp_work *work) {
  for (int whole = 0; whole < STEPS;) {
    round_sum(s, p->M.n, z);
    look(s, p, z, work);
    for (int k = 0; k < s->m; k++) {
      s->y[k] = -s->w[s->order[k]];
    }
    lin_chol_forward(s->L, s->m, s->y);
    lin_chol_backward(s->L, s->m, s->y);
    work->backsolves += 2;
    double t = 1;
    const int k = lcp_ppm_first_block(s, z, 0, 1, &t);
    const double step = (k >= 0 && t < 1) ? t : 1;
    for (int j = 0; j < s->m; j++) {
      s->e[s->order[j]] += step * s->y[j];
    }
    if (step < 1) {
      lcp_ppm_leave(s, z, k, s->y[k] < 0 ? AT_LO : AT_HI);
      work->pivots++;
    } else {
      whole++;
    }
  }
  round_sum(s, p->M.n, z);
  look(s, p, z, work);
}

/* What row i misses by, in the metric of unit. */
static double miss(const ppm *s, int i) {
  if (s->where[i] != BASIC && s->lo[i] == s->hi[i]) {
    return 0;
  }
  const double v = (s->where[i] == BASIC) ? fabs(s->w[i]) : lcp_ppm_violation(s, i);
  return v * s->share[i];
}

/* The row that misses most, and in *most what. */
static int worst(const ppm *s, int n, double *most) {
  int best = -1;
  *most = 0;
  for (int i = 0; i < n; i++) {
    const double v = miss(s, i);
    if (!(v <= *most)) {
      best = i;
      *most = v;
    }
  }
  return best;
}

/* Is what rounding hides of w small against the data, as data_test.h asks? */
static bool is_known(const ppm *s, const lcp_problem *p, double size) {
  for (int i = 0; i < p->M.n; i++) {
    if (!(DBL_EPSILON * s->share[i] * s->bound[i] <= 1e-6 * size)) {
      return false;
    }
  }
  return true;
}

/* Pivots and corrections until no row misses by more than limit; false: there is no such end. */
static bool settles(ppm *s, const lcp_problem *p, double limit, double *z, lcp_work *work) {
  const long last = work->pivots + PIVOTS_A_ROW * (long)p->M.n;
  for (;;) {
    double most;
    correct(s, p, z, work);
    const int r = worst(s, p->M.n, &most);
    if (most <= limit) {
      return true;
    }
    if (s->where[r] == BASIC || work->pivots >= last ||
        lcp_ppm_drive(s, p, z, s->e, r, last, work) == LCP_PPM_UNBLOCKED) {
      return false;
    }
  }
}

bool lcp_ppm_rounded(ppm *s, const lcp_problem *p, const lcp_stop *stop, double *z,
                     lcp_result *res) {
  const size_t bytes = (size_t)p->M.n * sizeof *z;
  const double size = lcp_data_size(p, s->share), limit = lcp_data_limit(stop->tol, size);
  lcp_ppm_evaluate(s, p, z);
  if (!is_known(s, p, size)) {
    return false;
  }
  memcpy(s->ray, z, bytes);
  res->work.refinements++;
  bool met = settles(s, p, limit, z, &res->work);
  if (met) {
    lcp_ppm_evaluate(s, p, z);
    met = is_known(s, p, size) && lcp_loop_met(&s->loop, stop->tol, p, z, res);
  }
  if (!met) {
    memcpy(z, s->ray, bytes);
  }
  return met;
}
