/* The scale-invariant residual rho (cases/README.md section 1) of a scaled point. lcp_stop_test is
 * not used: its bound on tau is zero on rows such as mu r_n - sum r_k = 0, where every term cancels.
 *
 * Of a factored M only S is known entry by entry; of P = J W J' the product g = P z and the diagonal
 * are. There tau uses |P_ii z_i| + |g_i - P_ii z_i| <= sum_j |P_ij||z_j|, so rho comes out larger,
 * never smaller, than with P formed. Rows that this makes look bad have their row of P formed. */
#include "lcp/solvers/lemke.h"

#include <math.h>

static const double looks_bad = 5e-15;

/* Diagonal of P: what S does not account for. Into zref for the time being. */
static void product_diagonal(const lemke_system *s) {
  for (int j = 0; j < s->n; ++j) {
    s->zref[j] = (s->rows > s->n) ? s->diagonal[j] : 0;
    for (int p = s->colptr[j]; p < s->colptr[j + 1] && s->rows > s->n; ++p) {
      s->zref[j] -= (s->rowind[p] == j) ? s->val[p] : 0;
    }
  }
}

/* w = M z + q and tau0. */
static void products(const lemke_system *s, const double *z) {
  for (int i = 0; i < s->rows; ++i) {
    s->w[i] = (long double)s->q[i];
    s->tau0[i] = fabs(s->q[i]);
  }
  for (int j = 0; j < s->n; ++j) {
    for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
      const long double term = (long double)s->val[p] * (long double)z[j];
      s->w[s->rowind[p]] += term;
      s->tau0[s->rowind[p]] += fabs((double)term);
    }
  }
  if (s->rows == s->n) {
    return;
  }
  product_diagonal(s);
  for (int i = 0; i < s->n; ++i) {
    s->tau0[i] += fabs(s->zref[i] * z[i]);
  }
  for (int i = 0; i < s->n; ++i) { /* g alone, to bound the rest of the row */
    s->row_sum[i] = 0;
  }
  for (int j = s->n; j < s->rows; ++j) { /* velocity: scaled row j reads  d u + (W J' z)_j = 0 */
    const int last = s->colptr[j + 1] - 1;
    const long double u = -s->w[j] / (long double)s->val[last];
    for (int p = s->colptr[j]; p < last; ++p) {
      s->row_sum[s->rowind[p]] += (long double)s->val[p] * u;
    }
  }
  for (int i = 0; i < s->n; ++i) {
    s->w[i] += s->row_sum[i];
    s->tau0[i] += fabs((double)(s->row_sum[i] - (long double)s->zref[i] * (long double)z[i]));
  }
}

/* zref and tau; tau0 is turned into tau. */
static void scales(const lemke_system *s) {
  for (int j = 0; j < s->n; ++j) { /* P_jj zref_j is added below, while zref still holds P_jj */
    const double own = (s->rows > s->n) ? s->zref[j] : 0;
    double ref = (s->diagonal[j] != 0) ? s->tau0[j] / fabs(s->diagonal[j]) : 0;
    for (int p = s->colptr[j]; p < s->colptr[j + 1] && s->diagonal[j] == 0; ++p) {
      ref = (s->rowind[p] < s->n) ? fmax(ref, s->tau0[s->rowind[p]] / fabs(s->val[p])) : ref;
    }
    s->zref[j] = (s->colptr[j] == s->colptr[j + 1]) ? 1 : ref;
    s->row_sum[j] = (long double)(own * ref);
  }
  for (int i = 0; i < s->n; ++i) {
    s->tau0[i] = fabs(s->q[i]) + (double)s->row_sum[i];
  }
  for (int j = 0; j < s->n; ++j) {
    for (int p = s->colptr[j]; p < s->colptr[j + 1]; ++p) {
      s->tau0[s->rowind[p]] += fabs(s->val[p]) * s->zref[j];
    }
  }
}

static double over(double v, double scale) {
  return (scale > 0) ? v / scale : (v == 0) ? 0 : copysign(HUGE_VAL, v);
}

/* sum_j |P_ij z_j| by forming row i of P as column i, scaled back: P is symmetric as given. */
static double row_size(const lemke_system *s, int i, const double *z) {
  double size = 0;
  for (int j = 0; j < s->n; ++j) {
    s->row_sum[j] = 0;
  }
  for (int p = s->colptr[i]; p < s->colptr[i + 1]; ++p) {
    const int u = s->rowind[p];
    const int last = s->colptr[u + 1] - 1;
    for (int k = s->colptr[u]; u >= s->n && k < last; ++k) {
      s->row_sum[s->rowind[k]] -=
          (long double)s->val[p] / (long double)s->val[last] * (long double)s->val[k];
    }
  }
  for (int j = 0; j < s->n; ++j) {
    if (z[j] != 0) {
      const int e = s->row_exp[i] + s->col_exp[j] - s->row_exp[j] - s->col_exp[i];
      size += fabs(ldexp((double)s->row_sum[j] * z[j], e));
    }
  }
  return size;
}

static double row_residual(const lemke_system *s, int i, double z, double zref, double tau) {
  const double x = over(z, zref);
  const double y = over((double)s->w[i], tau);
  return s->is_free[i] ? fabs(y) : fabs(fmin(x, y));
}

double lemke_residual(const lemke_system *s, const double *z, double *defect) {
  double rho = 0;
  *defect = 0;
  products(s, z);
  scales(s);
  for (int i = 0; i < s->n; ++i) {
    double r = row_residual(s, i, z[i], s->zref[i], s->tau0[i]);
    if (r > looks_bad && s->rows > s->n && s->diagonal[i] != 0) {
      /* tau_i >= |P_ii| zref_i = tau0_i >= the true row, S left out */
      const double size = row_size(s, i, z);
      r = fmin(r, row_residual(s, i, z[i], fmax(s->zref[i], size / fabs(s->diagonal[i])),
                               fmax(s->tau0[i], size)));
    }
    if (!(r < HUGE_VAL)) {
      return HUGE_VAL;
    }
    rho = fmax(rho, r);
    const double w = (double)s->w[i];
    *defect = fmax(*defect, s->is_free[i] ? fabs(w) : fabs(fmin(z[i], w)));
  }
  return rho;
}
