/* The scale-invariant residual rho (RESIDUALS 1) of a scaled point. lcp_stop_test is
 * not used: its bound on tau is zero on rows such as mu r_n - sum r_k = 0, where every term cancels.
 *
 * Of a factored M only S is known entry by entry; of P = J W J' the product g = P z and the diagonal
 * are. There tau uses |P_ii z_i| + |g_i - P_ii z_i| <= sum_j |P_ij||z_j|, so rho comes out larger,
 * never smaller, than with P formed. Rows that this makes look bad have their row of P formed. */
#include "lcp/linear/extended.h"
#include "lcp/solvers/lemke/system.h"

#include <math.h>
#include <string.h>

static const double looks_bad = 5e-15;

/* Diagonal of P: what S does not account for. Into zref for the time being. */
static void product_diagonal(const lemke_system *s) {
  for (int j = 0; j < s->n; ++j) {
    s->zref[j] = s->diagonal[j];
    for (int p = s->colptr[j]; p < s->colptr[j + 1] && s->rowind[p] < s->n; ++p) {
      s->zref[j] -= (s->rowind[p] == j) ? s->val[p] : 0;
    }
  }
}

/* Of a factored M: velocities from the rows beyond n of w, scaled row j of which reads  d u + (W J' z)_j = 0, then
 * what they add to w and tau0. */
static void add_velocities(const lemke_system *s, const double *z) {
  for (int j = s->n; j < s->rows; ++j) {
    s->row_sum[j] = -s->w[j] / (long double)s->val[s->colptr[j + 1] - 1];
  }
  for (int i = 0; i < s->n; ++i) {
    const long double own = (long double)s->zref[i] * (long double)z[i];
    long double g = 0;
    for (int p = s->jptr[i]; p < s->jptr[i + 1]; ++p) {
      g += (long double)s->jval[p] * s->row_sum[s->n + s->jdof[p]];
    }
    s->w[i] += g;
    s->tau0[i] += fabs((double)own) + fabs((double)(g - own));
  }
}

/* sum_i += |M_ij t| over the rows of the problem, which come first. */
static void add_sizes(const lemke_system *s, int j, double t, double *restrict sum) {
  const lemke_column c = lemke_system_column(s, j);
  const double *restrict val = c.val;
  const int *restrict row = c.row;
  const bool mixed = s->rows > s->n;
  for (int p = 0; row != NULL && p < c.count && (!mixed || row[p] < s->n); ++p) {
    sum[row[p]] += fabs(val[p] * t);
  }
  for (int i = 0; i < s->n && c.row == NULL; ++i) { /* a full column needs no index */
    sum[i] += fabs(val[i] * t);
  }
}

/* w = M z + q and tau0. */
static void products(const lemke_system *s, const double *z) {
  for (int i = 0; i < s->rows; ++i) {
    s->w[i] = (long double)s->q[i];
    s->tau0[i] = fabs(s->q[i]);
  }
  lin_extended w = {.n = s->rows, .sum = s->w};
  for (int j = 0; j < s->n; ++j) {
    if (z[j] != 0) {
      const lemke_column c = lemke_system_column(s, j);
      lin_extended_add(&w, (long double)z[j], c.val, c.row, c.count);
      add_sizes(s, j, z[j], s->tau0);
    }
  }
  lin_extended_flush(&w);
  if (s->rows > s->n) {
    product_diagonal(s);
    add_velocities(s, z);
  }
}

/* zref of an unknown without a diagonal; 1 where nothing depends on it. */
static double reference(const lemke_system *s, int j) {
  const lemke_column c = lemke_system_column(s, j);
  double ref = 0;
  bool any = false;
  for (int p = 0; p < c.count; ++p) {
    const int i = (c.row == NULL) ? p : c.row[p];
    any = any || c.val[p] != 0;
    ref = (i < s->n && c.val[p] != 0) ? lemke_larger(s->tau0[i] / fabs(c.val[p]), ref) : ref;
  }
  return any ? ref : 1;
}

/* zref and tau; tau0 is turned into tau. */
static void scales(const lemke_system *s) {
  for (int j = 0; j < s->n; ++j) { /* P_jj zref_j is added below, while zref still holds P_jj */
    const double own = (s->rows > s->n) ? s->zref[j] : 0;
    s->zref[j] = (s->diagonal[j] != 0) ? s->tau0[j] / fabs(s->diagonal[j]) : reference(s, j);
    s->row_sum[j] = (long double)(own * s->zref[j]);
  }
  for (int i = 0; i < s->n; ++i) {
    s->tau0[i] = fabs(s->q[i]) + (double)s->row_sum[i];
  }
  for (int j = 0; j < s->n; ++j) {
    add_sizes(s, j, s->zref[j], s->tau0);
  }
}

static double over(double v, double scale) {
  return (scale > 0) ? v / scale : (v == 0) ? 0 : copysign(HUGE_VAL, v);
}

/* Lists the nonzero z in row_top; returns how many. */
static int list_support(const lemke_system *s, const double *z) {
  int count = 0;
  for (int j = 0; j < s->n; ++j) {
    s->row_top[count] = j;
    count += z[j] != 0;
  }
  return count;
}

/* sum_j |P_ij z_j| over the support, P_ij from row i of J and column j of W J'. *reach: a lower bound of
 * sum_j |M_ij| zref_j, from P_ii and the columns of the support in which S has no entry (it might cancel). */
static double row_size(const lemke_system *s, int i, const double *z, int support, double *reach) {
  long double *back = s->row_sum + s->n; /* row i of J over the diagonals, by velocity */
  double size = 0;
  *reach = (double)s->row_sum[i]; /* P_ii zref_i */
  memset(back, 0, sizeof *back * (size_t)(s->rows - s->n));
  for (int p = s->jptr[i]; p < s->jptr[i + 1]; ++p) {
    const int c = s->n + s->jdof[p];
    back[s->jdof[p]] = (long double)s->jval[p] / (long double)s->val[s->colptr[c + 1] - 1];
  }
  for (int k = 0; k < support; ++k) {
    const int j = s->row_top[k];
    long double entry = 0;
    bool apart = j != i;
    for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
      const int r = s->rowind[p];
      entry += (r >= s->n) ? (long double)s->val[p] * back[r - s->n] : 0;
      apart = apart && r != i;
    }
    *reach += apart ? fabs((double)entry) * s->zref[j] : 0;
    size += fabs((double)(entry * (long double)z[j]));
  }
  return size;
}

/* |min(z / zref, w / tau)|; not a number where w is none. */
static double row_residual(const lemke_system *s, int i, double z, double zref, double tau) {
  const double w = (double)s->w[i];
  const bool is_free = lemke_is_free(s, i);
  if (z == 0 && w >= 0 && !is_free) {
    return 0;
  }
  const double y = over(w, tau);
  return fabs((is_free || !(y > 0)) ? y : lemke_smaller(over(z, zref), y));
}

double lemke_residual(const lemke_system *s, const double *z, double *defect) {
  const double q_unit = s->view ? lemke_power(-s->q_exp) : 1;
  double rho = 0;
  *defect = 0;
  products(s, z);
  scales(s);
  const int support = list_support(s, z);
  for (int i = 0; i < s->n; ++i) {
    double r = row_residual(s, i, z[i], s->zref[i], s->tau0[i]);
    if (r > looks_bad && s->rows > s->n && s->diagonal[i] != 0) {
      /* tau_i >= |P_ii| zref_i = tau0_i >= the true row, S left out */
      double reach;
      const double size = row_size(s, i, z, support, &reach);
      r = fmin(r, row_residual(s, i, z[i], fmax(s->zref[i], size / fabs(s->diagonal[i])),
                               fmax(fmax(s->tau0[i], size), fabs(s->q[i]) + reach)));
    }
    if (!(r < HUGE_VAL)) {
      return HUGE_VAL;
    }
    rho = lemke_larger(r, rho);
    if (r != 0) {
      const double w = q_unit * (double)s->w[i];
      const double x = s->view ? q_unit * lemke_power(-s->col_exp[i]) * z[i] : z[i];
      *defect = lemke_larger(fabs(lemke_is_free(s, i) ? w : lemke_smaller(x, w)), *defect);
    }
  }
  return rho;
}
