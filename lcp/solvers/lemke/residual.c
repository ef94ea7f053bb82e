/* The scale-invariant residual rho (RESIDUALS 1) of a scaled point, of terms and references of lcp_rho.h. What is
 * here is the product M z + q in extended precision, and the bounds of a factored M. lcp_stop_test is
 * not used: its bound on tau is zero on rows such as mu r_n - sum r_k = 0, where every term cancels.
 *
 * Of a factored M only S is known entry by entry; of P = J W J' the product g = P z and the diagonal
 * are. There tau uses |P_ii z_i| + |g_i - P_ii z_i| <= sum_j |P_ij||z_j|, so rho comes out larger,
 * never smaller, than with P formed. Rows that this makes look bad have their row of P formed. */
#include "lcp/lcp_rho.h"
#include "lcp/linear/extended.h"
#include "lcp/solvers/lemke/system.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double looks_bad = 5e-15;

/* Rows of a dense M up to which the product is formed in double first: a residual of a few roundings is found no matter in
 * which precision, and a larger one is measured again. */
enum { FEW = 16 };
static const double few_roundings = 4 * DBL_EPSILON;

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

/* Column j without its velocities: the rows of the problem come first. */
static lcp_column own_rows(const lemke_system *s, int j) {
  lcp_column c = lemke_system_column(s, j);
  if (s->rows > s->n) {
    int count = 0;
    while (count < c.count && lcp_column_row(&c, count) < s->n) {
      count++;
    }
    c.count = count;
  }
  return c;
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
      const lcp_column c = lemke_system_column(s, j);
      lin_extended_add(&w, (long double)z[j], c.val, c.row, c.count);
      lcp_column_add_size((s->rows > s->n) ? own_rows(s, j) : c, z[j], s->tau0);
    }
  }
  lin_extended_flush(&w);
  if (s->rows > s->n) {
    product_diagonal(s);
    add_velocities(s, z);
  }
}

/* zref and tau; tau0 is turned into tau. */
static void scales(const lemke_system *s) {
  for (int j = 0; j < s->n; ++j) { /* P_jj zref_j is added below, while zref still holds P_jj */
    const double own = (s->rows > s->n) ? s->zref[j] : 0;
    s->zref[j] = lcp_rho_reference(s->diagonal[j], s->tau0[j], own_rows(s, j), s->tau0);
    s->row_sum[j] = (long double)(own * s->zref[j]);
  }
  for (int i = 0; i < s->n; ++i) {
    s->tau0[i] = fabs(s->q[i]) + (double)s->row_sum[i];
  }
  for (int j = 0; j < s->n; ++j) {
    lcp_column_add_size(own_rows(s, j), s->zref[j], s->tau0);
  }
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

/* |min(z', w')| of row i. */
static double missed(const lemke_system *s, int i, double z, double q_unit) {
  const double w = q_unit * (double)s->w[i];
  const double x = s->view ? q_unit * lemke_power(-s->col_exp[i]) * z : z;
  return fabs(lemke_is_free(s, i) ? w : lemke_smaller(x, w));
}

/* An upper bound of rho after products(): tau_i >= tau0_i, because zref_j >= |z_j|, and min(x, y) <= y where z_i > 0.
 * It needs no scale, and is enough where the answer is right to round-off. HUGE_VAL where z_i < 0 is to be measured. */
static double bound(const lemke_system *s, const double *z, double q_unit, double *defect) {
  double rho = 0;
  *defect = 0;
  for (int i = 0; i < s->n; ++i) {
    const double w = (double)s->w[i];
    const bool taut = z[i] > 0 || lemke_is_free(s, i);
    if (w == 0 || (!taut && w > 0 && z[i] == 0)) {
      continue;
    }
    if (!(taut || z[i] == 0) || !(fabs(w) < HUGE_VAL)) {
      return HUGE_VAL;
    }
    rho = lemke_larger(fabs(w) / s->tau0[i], rho);
    *defect = lemke_larger(missed(s, i, z[i], q_unit), *defect);
  }
  return rho;
}

static double row_residual(const lemke_system *s, int i, double z, double zref, double tau) {
  const lcp_set set = lemke_is_free(s, i) ? LCP_FREE : LCP_ORTHANT;
  return lcp_rho_row(set, z, (double)s->w[i], 0, HUGE_VAL, zref, tau);
}

/* products() of a few full columns, in double. */
static void few_products(const lemke_system *s, const double *z) {
  const int n = s->n;
  double w[FEW];
  double size[FEW];
  for (int i = 0; i < n; ++i) {
    w[i] = s->q[i];
    size[i] = fabs(s->q[i]);
  }
  for (int j = 0; j < n; ++j) {
    const double *restrict column = s->val + (ptrdiff_t)j * n;
    for (int i = 0; i < n && z[j] != 0; ++i) {
      const double term = column[i] * z[j];
      w[i] += term;
      size[i] += fabs(term);
    }
  }
  for (int i = 0; i < n; ++i) {
    s->w[i] = (long double)w[i];
    s->tau0[i] = size[i];
  }
}

double lemke_residual(const lemke_system *s, const double *z, double *defect) {
  const double q_unit = s->view ? lemke_power(-s->q_exp) : 1;
  if (s->rowind == NULL && s->rows == s->n && s->n <= FEW) {
    few_products(s, z);
    const double rho = bound(s, z, q_unit, defect);
    if (rho <= few_roundings) {
      return rho;
    }
  }
  products(s, z);
  double rho = bound(s, z, q_unit, defect);
  if (rho <= looks_bad) {
    return rho;
  }
  rho = 0;
  *defect = 0;
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
      *defect = lemke_larger(missed(s, i, z[i], q_unit), *defect);
    }
  }
  return rho;
}
