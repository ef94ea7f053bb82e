/* ppm_table.c - the same pivots for a small problem from z = 0, on the lower half of a symmetric tableau.
 *
 * With F basic, B = M_FF^-1 and N the other rows, T holds -B, B M_FN and M_NN - M_NF B M_FN: what the sweep operator
 * (Goodnight 1979) makes of M, symmetric at all times. Column r is the direction of z_r and the Schur
 * complement at once, so a drive reads it and solves nothing; a pivot is n^2/2 operations. Round-off adds up from
 * pivot to pivot: the last values are corrected by the data and B, and what is then not right to rounding is left to
 * the factored path. */
#include "lcp/base/clones.h"
#include "lcp/lcp_column.h"
#include "lcp/linear/extended.h"
#include "lcp/solvers/data_test.h"
#include "lcp/solvers/ppm/ppm.h"

#include <string.h>

enum {
  LANES = 4,
  PIVOTS_A_ROW = 8
}; /* more pivots a row than that are not the business of a table */

static const double exact = 0x1p-52; /* rho that no correction makes smaller */
static const double right = 5e-15; /* rho of an answer that rounding alone keeps from being exact */
static const double driven =
    1e-14; /* of the terms w_i went through: a larger violation is driven */

static int padded(int n) {
  return (n + LANES - 1) / LANES * LANES;
}

size_t lcp_ppm_table_size(int n) {
  return (size_t)padded(n) * (size_t)n;
}

/* Rows j.. of column j; what stands above them is not read. */
static void fill(ppm *s, const lcp_problem *p) {
  const int n = p->M.n;
  s->stride = padded(n);
  for (int j = 0; j < n; j++) {
    const lcp_column c = lcp_column_of(&p->M, j);
    double *to = s->table + (ptrdiff_t)j * s->stride;
    if (c.row == NULL) {
      memcpy(to + j, c.val + j, (size_t)(n - j) * sizeof *to);
    } else {
      memset(to, 0, (size_t)n * sizeof *to);
      for (int k = 0; k < c.count; k++) {
        to[c.row[k]] = c.val[k];
      }
    }
    for (int i = n; i < s->stride; i++) {
      to[i] = 0;
    }
    s->w[j] = p->q[j];
    s->bound[j] = fabs(p->q[j]);
    s->where[j] = AT_LO;
    s->side[j] = 1;
  }
  s->m = 0;
}

/* All of column r. */
static void read_column(const ppm *s, int n, int r, double *restrict c) {
  const double *at = s->table + r;
  for (int j = 0; j < r; j++, at += s->stride) {
    c[j] = *at;
  }
  memcpy(c + r, at, (size_t)(n - r) * sizeof *c);
  for (int i = n; i < s->stride; i++) {
    c[i] = 0;
  }
}

BASE_CLONES static void eliminate(double *restrict T, int stride, int n, const double *restrict c,
                                  double pivot) {
  for (int j = 0; j < n; j++, T += stride) {
    if (c[j] == 0) {
      continue;
    }
    const double share = c[j] / pivot;
    for (int i = j / LANES * LANES; i < stride; i += LANES) {
      for (int k = 0; k < LANES; k++) {
        T[i + k] -= c[i + k] * share;
      }
    }
  }
}

/* The tableau after row r, whose column is c, has joined F (sign 1) or left it (sign -1). */
static void sweep(ppm *s, int n, int r, const double *c, double sign) {
  const double factor = sign / c[r];
  double *at = s->table + r;
  eliminate(s->table, s->stride, n, c, c[r]);
  for (int j = 0; j < r; j++, at += s->stride) {
    *at = c[j] * factor;
  }
  for (int i = 1; i < n - r; i++) {
    at[i] = c[r + i] * factor;
  }
  *at = -1 / c[r];
}

static void join(ppm *s, int n, int r, const double *c) {
  sweep(s, n, r, c, 1);
  s->where[r] = BASIC;
  s->side[r] = -1;
  s->order[s->m++] = r;
}

/* The basic row in place `at` leaves at zero. */
static void leave(ppm *s, int n, int at, double *c) {
  const int k = s->order[at];
  read_column(s, n, k, c);
  sweep(s, n, k, c, -1);
  s->order[at] = s->order[--s->m];
  s->where[k] = AT_LO;
  s->side[k] = 1;
  s->w[k] = 0;
}

/* w holds z_i where i is basic, w_i elsewhere. The row of the largest violation in the energy metric, or -1. */
static int worst(const ppm *s, int n) {
  int best = -1;
  double top = 0;
  for (int i = 0; i < n; i++) {
    const double v = -s->w[i] * s->share[i];
    if (s->where[i] != BASIC && v > top && -s->w[i] > driven * s->bound[i]) {
      best = i;
      top = v;
    }
  }
  return best;
}

/* The place of the basic row that first meets zero as z_r rises, and the step; ties: the largest pivot. */
static int first_block(const ppm *s, int r, const double *c, double faint, double *step) {
  double top = s->unit[r];
  for (int k = 0; k < s->m; k++) {
    const double size = fabs(c[s->order[k]]) * s->unit[s->order[k]];
    top = (size > top) ? size : top;
  }
  int best = -1;
  double pivot = 0;
  for (int k = 0; k < s->m; k++) {
    const int i = s->order[k];
    const double size = c[i] * s->unit[i];
    if (size > faint * top) {
      const double room = (s->w[i] > 0) ? s->w[i] : 0;
      if (best < 0 || room < *step * c[i] || (room == *step * c[i] && size > pivot)) {
        best = k;
        *step = room / c[i];
        pivot = size;
      }
    }
  }
  return best;
}

/* z_r rises by t: w_N along c, z_F against it. */
static void advance(int n, const double *restrict c, const double *restrict side, double t,
                    double *restrict w, double *restrict bound) {
  for (int i = 0; i < n; i++) {
    const double move = t * c[i];
    w[i] += side[i] * move;
    bound[i] += fabs(move);
  }
}

/* Drives row r until it joins F. False where nothing blocks or the pivots are used up: not for a table. */
static bool drive(ppm *s, int n, int r, const lcp_ppm_share *share, long limit, lcp_work *work) {
  double *c = s->y;
  double risen = 0;
  while (work->pivots < limit) {
    work->pivots++;
    read_column(s, n, r, c);
    double t = HUGE_VAL;
    const int k = first_block(s, r, c, share->faint, &t);
    if (c[r] > share->rank * s->d[r] && -s->w[r] <= t * c[r]) {
      t = -s->w[r] / c[r];
      advance(n, c, s->side, t, s->w, s->bound);
      s->w[r] = risen + t;
      join(s, n, r, c);
      return true;
    }
    if (k < 0) {
      return false;
    }
    advance(n, c, s->side, t, s->w, s->bound);
    risen += t;
    leave(s, n, k, c);
  }
  return false;
}

/* z_F -= B (M z + q)_F, the product in extended precision; z stays on K. */
static void correct(ppm *s, const lcp_problem *p, double *z) {
  const int n = p->M.n;
  lin_extended e = {.n = n, .sum = s->sum};
  for (int i = 0; i < n; i++) {
    s->sum[i] = (long double)p->q[i];
  }
  for (int k = 0; k < s->m; k++) {
    const lcp_column c = lcp_column_of(&p->M, s->order[k]);
    lin_extended_add(&e, (long double)z[s->order[k]], c.val, c.row, c.count);
  }
  lin_extended_flush(&e);
  for (int i = 0; i < n; i++) {
    s->x[i] = (s->where[i] == BASIC) ? (double)s->sum[i] : 0;
    s->y[i] = 0;
  }
  for (int j = 0; j < n; j++) {
    const double *T = s->table + (ptrdiff_t)j * s->stride;
    double own = 0;
    for (int i = j + 1; i < n && s->where[j] == BASIC; i++) {
      own += T[i] * s->x[i];
      s->y[i] += T[i] * s->x[j];
    }
    s->y[j] += own + T[j] * s->x[j];
  }
  for (int k = 0; k < s->m; k++) {
    const int i = s->order[k];
    const double v = z[i] + s->y[i];
    z[i] = (v > 0) ? v : 0;
  }
}

/* Is z right up to a residual of `most`? *rho is then an upper bound: tau_i >= tau0_i, since zref_j >= z_j. */
static bool is_right(ppm *s, const lcp_problem *p, double tol, double most, const double *z,
                     double *rho) {
  *rho = 0;
  lcp_rho_product(p, z, s->w, s->bound);
  for (int i = 0; i < p->M.n; i++) {
    const double miss = (s->where[i] == BASIC || s->w[i] < 0) ? fabs(s->w[i]) : 0;
    const double r = (miss > 0) ? miss / s->bound[i] : 0;
    *rho = (r > *rho) ? r : *rho;
    if (!(miss < HUGE_VAL)) {
      return false;
    }
  }
  return *rho <= most && *rho <= tol &&
         lcp_data_allows(p, tol, lcp_data_size(p, s->share), s->share, z, s->w, s->bound);
}

bool lcp_ppm_table_solve(ppm *s, const lcp_problem *p, const lcp_stop *stop,
                         const lcp_ppm_share *share, double *z, lcp_result *res) {
  const int n = p->M.n;
  const long most = (long)PIVOTS_A_ROW * n, limit = (stop->max_iter < most) ? stop->max_iter : most;
  fill(s, p);
  for (int r = worst(s, n); r >= 0; r = worst(s, n)) {
    if (!drive(s, n, r, share, limit, &res->work)) {
      return false;
    }
  }
  for (int k = 0; k < s->m; k++) { /* the others are zero */
    const int i = s->order[k];
    z[i] = (s->w[i] > 0) ? s->w[i] : 0;
  }
  res->work.matvecs++;
  if (is_right(s, p, stop->tol, exact, z, &res->residual)) {
    return true;
  }
  correct(s, p, z);
  res->work.refinements++;
  res->work.matvecs += 2;
  return is_right(s, p, stop->tol, right, z, &res->residual);
}
