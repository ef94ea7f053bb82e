#include "problems/families/generate.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>

#define AT(M, n, i, j) ((M)[(size_t)(j) * (size_t)(n) + (size_t)(i)])

static base_status need_size(int n, int lo, int hi, base_error *err) {
  if (n < lo || n > hi) {
    return BASE_FAIL(err, BASE_EINVAL, "n = %d: need %d to %d", n, lo, hi);
  }
  return BASE_OK;
}

enum { DENSE_MAX = 20000 };

/* z and w of a known problem, q as it is. */
static base_status answer_arrays(known_lcp *k, base_error *err) {
  const int n = k->p.M.n;
  k->z = KNOWN_ARRAY(k, double, n);
  k->w = KNOWN_ARRAY(k, double, n);
  k->answer = KNOWN_UNIQUE;
  return (k->z != NULL && k->w != NULL)
             ? BASE_OK
             : BASE_FAIL(err, BASE_ENOMEM, "n = %d: no memory for the solution", n);
}

base_status generate_murty(known_lcp *k, int n, bool upper, bool hat, base_error *err) {
  double *M, *q;
  BASE_TRY(need_size(n, 1, hat ? 50 : DENSE_MAX, err));
  BASE_TRY(known_dense(k, n, &M, &q, err));
  BASE_TRY(answer_arrays(k, err));
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      AT(M, n, i, j) = (i == j) ? 1.0 : ((i > j) != upper) ? 2.0 : 0.0;
    }
  }
  double sum = 0.0;
  for (int i = 0; i < n; i++) {
    sum += ldexp(1.0, n - i);
    q[i] = hat ? -sum : -1.0;
  }
  const int at = upper ? n - 1 : 0;
  k->z[at] = hat ? ldexp(1.0, n) : 1.0; /* upper hat: q_n = -(2^(n+1) - 2), set below */
  if (upper && hat) {
    return BASE_FAIL(err, BASE_EINVAL, "murty: hat goes with the lower matrix");
  }
  for (int i = 0; i < n; i++) {
    k->w[i] = (i == at) ? 0.0 : 2.0 * k->z[at] + q[i];
  }
  k->p.traits = LCP_P_MATRIX | LCP_PSD | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  if (n <= 62) {
    k->lemke_pivots = upper ? 0 : 1L << n;
    k->least_index_pivots = upper ? (1L << n) - 1 : 0;
  }
  return BASE_OK;
}

base_status generate_fathi(known_lcp *k, int n, base_error *err) {
  double *M, *q;
  BASE_TRY(need_size(n, 1, DENSE_MAX, err));
  BASE_TRY(known_dense(k, n, &M, &q, err));
  BASE_TRY(answer_arrays(k, err));
  for (int j = 0; j < n; j++) {
    for (int i = 0; i < n; i++) {
      const int least = (i < j) ? i : j;
      AT(M, n, i, j) = (i == j) ? 4.0 * i + 1.0 : 4.0 * least + 2.0;
    }
    q[j] = -1.0;
    k->w[j] = (j == 0) ? 0.0 : 1.0;
  }
  k->z[0] = 1.0;
  k->p.traits =
      LCP_SYMMETRIC | LCP_PSD | LCP_PD | LCP_P_MATRIX | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  k->lemke_pivots = (n <= 62) ? 1L << n : 0;
  return BASE_OK;
}

base_status generate_csizmadia(known_lcp *k, int n, base_error *err) {
  double *M, *q;
  BASE_TRY(need_size(n, 1, DENSE_MAX, err));
  BASE_TRY(known_dense(k, n, &M, &q, err));
  BASE_TRY(answer_arrays(k, err));
  double before = 0.0; /* sum of z_j, j < i */
  for (int i = 0; i < n; i++) {
    for (int j = 0; j <= i; j++) {
      AT(M, n, i, j) = (i == j) ? 1.0 : -1.0;
    }
    k->z[i] = (i % 2 == 0) ? 1.0 : 0.0;
    k->w[i] = 1.0 - k->z[i];
    q[i] = k->w[i] - (k->z[i] - before);
    before += k->z[i];
  }
  k->p.traits = LCP_P_MATRIX;
  return BASE_OK;
}

base_status generate_circulant(known_lcp *k, int n, double a, double b, base_error *err) {
  double *M, *q;
  BASE_TRY(need_size(n, 3, DENSE_MAX, err));
  if (!(1.0 + a + b > 0.0)) {
    return BASE_FAIL(err, BASE_EINVAL, "circulant: 1 + a + b = %g, need > 0", 1.0 + a + b);
  }
  BASE_TRY(known_dense(k, n, &M, &q, err));
  BASE_TRY(answer_arrays(k, err));
  for (int i = 0; i < n; i++) {
    AT(M, n, i, i) = 1.0;
    AT(M, n, i, (i + n - 1) % n) = a;
    AT(M, n, i, (i + n - 2) % n) = b;
    q[i] = -1.0;
    k->z[i] = 1.0 / (1.0 + a + b);
  }
  k->answer = KNOWN_SOLVABLE; /* unique where M is a P-matrix, which is not decided here */
  if (fabs(a) + fabs(b) < 1.0) {
    k->answer = KNOWN_UNIQUE; /* rows and columns diagonally dominant: positive definite */
    k->p.traits = LCP_PD | LCP_PSD | LCP_P_MATRIX | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  }
  return BASE_OK;
}

/* Pattern and values of a symmetric tridiagonal matrix by columns. */
static base_status tridiagonal(known_lcp *k, int n, const double *diag, const double *off,
                               double **q, base_error *err) {
  int *colptr, *rowind;
  double *val;
  BASE_TRY(known_sparse(k, n, 3 * n - 2, &colptr, &rowind, &val, q, err));
  int at = 0;
  for (int j = 0; j < n; j++) {
    for (int i = j - 1; i <= j + 1; i++) {
      if (i < 0 || i >= n) {
        continue;
      }
      rowind[at] = i;
      val[at++] = (i == j) ? diag[j] : off[(i < j) ? i : j];
    }
    colptr[j + 1] = at;
  }
  return BASE_OK;
}

enum { SPARSE_MAX = 10000000 };

base_status generate_tridiagonal(known_lcp *k, int n, double diag, double off, int period,
                                 base_error *err) {
  BASE_TRY(need_size(n, 1, SPARSE_MAX, err));
  if (period < 2 || !(diag >= 2.0 * fabs(off)) || !(diag > 0.0)) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "tridiagonal: diag = %g, off = %g, period = %d: need diag >= 2 |off|, diag > "
                     "0, period >= 2",
                     diag, off, period);
  }
  double *d = KNOWN_ARRAY(k, double, n), *o = KNOWN_ARRAY(k, double, n), *q;
  if (d == NULL || o == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "n = %d: no memory", n);
  }
  for (int i = 0; i < n; i++) {
    d[i] = diag;
    o[i] = off;
  }
  BASE_TRY(tridiagonal(k, n, d, o, &q, err));
  BASE_TRY(answer_arrays(k, err));
  for (int i = 1; i <= n; i++) {
    k->z[i - 1] = (i % period != 0) ? 1.0 + i % 5 : 0.0;
    k->w[i - 1] = (i % period != 0) ? 0.0 : 1.0 + i % 4;
  }
  for (int i = 0; i < n; i++) {
    const double left = (i > 0) ? k->z[i - 1] : 0.0, right = (i < n - 1) ? k->z[i + 1] : 0.0;
    q[i] = k->w[i] - (diag * k->z[i] + off * (left + right));
  }
  k->p.traits =
      LCP_SYMMETRIC | LCP_PSD | LCP_PD | LCP_P_MATRIX | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  return BASE_OK;
}

base_status generate_stack(known_lcp *k, int n, const double *mass, double gh, base_error *err) {
  BASE_TRY(need_size(n, 1, SPARSE_MAX, err));
  double *d = KNOWN_ARRAY(k, double, n), *o = KNOWN_ARRAY(k, double, n), *q;
  if (d == NULL || o == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "n = %d: no memory", n);
  }
  bool equal = true;
  for (int i = 0; i < n; i++) {
    if (!(mass[i] > 0.0) || !isfinite(mass[i])) {
      return BASE_FAIL(err, BASE_EINVAL, "stack: mass %d = %g, need > 0", i + 1, mass[i]);
    }
    d[i] = 1.0 / mass[i] + (i > 0 ? 1.0 / mass[i - 1] : 0.0);
    o[i] = -1.0 / mass[i]; /* couples contact i+1 (under mass i+1) with the next */
    equal = equal && mass[i] == mass[0];
  }
  BASE_TRY(tridiagonal(k, n, d, o, &q, err));
  BASE_TRY(answer_arrays(k, err));
  q[0] = -gh;
  double above = 0.0;
  for (int i = n - 1; i >= 0; i--) {
    above += mass[i];
    k->z[i] = gh * above;
  }
  /* Gauss-Seidel on a column: cos^2(pi/2n) for equal masses, m2/(m1+m2) for two */
  const double c = cos(3.14159265358979323846 / (2.0 * n));
  k->sweep_rate = (equal) ? c * c : (n == 2) ? mass[1] / (mass[0] + mass[1]) : 0.0;
  k->p.traits =
      LCP_SYMMETRIC | LCP_PSD | LCP_PD | LCP_P_MATRIX | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  return BASE_OK;
}

/* ---- linear congruential data --------------------------------------------------------------- */

/* s <- (1103515245 s + 12345) mod 2^31, r = floor(s / 65536); first use after one update. */
static int next_lcg(uint32_t *s) {
  *s = (uint32_t)((1103515245ull * *s + 12345ull) & 0x7fffffffull);
  return (int)(*s >> 16);
}

/* M = A'A + I for A[n*n] row by row, of small integers: every sum is exact, in any order. */
static void gram_plus_identity(int n, const double *A, double *M) {
  cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, n, n, 1.0, A, n, 0.0, M, n);
  for (int j = 0; j < n; j++) {
    AT(M, n, j, j) += 1.0;
    for (int i = j + 1; i < n; i++) {
      AT(M, n, j, i) = AT(M, n, i, j);
    }
  }
}

static base_status lcg_matrix(known_lcp *k, int n, uint32_t *s, int modulus, double **M, double **q,
                              base_error *err) {
  BASE_TRY(need_size(n, 1, 2000, err));
  BASE_TRY(known_dense(k, n, M, q, err));
  double *A = malloc((size_t)n * (size_t)n * sizeof *A);
  if (A == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "n = %d: no memory", n);
  }
  for (size_t i = 0; i < (size_t)n * (size_t)n; i++) {
    const int middle = modulus / 2;
    A[i] = next_lcg(s) % modulus - middle;
  }
  gram_plus_identity(n, A, *M);
  free(A);
  return BASE_OK;
}

base_status generate_lcg_spd(known_lcp *k, int n, uint32_t seed, base_error *err) {
  uint32_t s = seed;
  double *M, *q;
  BASE_TRY(lcg_matrix(k, n, &s, 7, &M, &q, err));
  for (int i = 0; i < n; i++) {
    q[i] = next_lcg(&s) % 21 - 13;
  }
  k->answer = KNOWN_UNIQUE;
  k->p.traits =
      LCP_SYMMETRIC | LCP_PSD | LCP_PD | LCP_P_MATRIX | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  return BASE_OK;
}

base_status generate_lcg_p(known_lcp *k, int n, uint32_t seed, base_error *err) {
  uint32_t s = seed;
  double *M, *q;
  BASE_TRY(lcg_matrix(k, n, &s, 3, &M, &q, err));
  for (int i = 0; i < n; i++) {
    for (int j = i + 1; j < n; j++) {
      const double skew = next_lcg(&s) % 11 - 5;
      AT(M, n, i, j) += skew;
      AT(M, n, j, i) -= skew;
    }
  }
  for (int i = 0; i < n; i++) {
    q[i] = next_lcg(&s) % 21 - 13;
  }
  k->answer = KNOWN_UNIQUE;
  k->p.traits = LCP_PSD | LCP_PD | LCP_P_MATRIX | LCP_COPOSITIVE | LCP_COPOSITIVE_PLUS;
  return BASE_OK;
}

/* ---- subset sum ----------------------------------------------------------------------------- */

/* A subset of a[n] with sum b as z in {0,1}, by dynamic programming over sums; false if none.
 * first[t]: 1 + the item by which sum t was first reached. */
static bool find_subset(int n, const int *a, int b, int *first, double *z) {
  for (int i = 0; i < n; i++) {
    for (int t = b; t >= a[i]; t--) {
      const bool reached = (t == a[i]) || first[t - a[i]] != 0;
      if (first[t] == 0 && reached) {
        first[t] = i + 1;
      }
    }
  }
  if (b > 0 && first[b] == 0) {
    return false;
  }
  for (int t = b; t > 0; t -= a[first[t] - 1]) {
    z[first[t] - 1] = 1.0;
  }
  return true;
}

enum { SUM_MAX = 10000000 };

base_status generate_subset_sum(known_lcp *k, int n, const int *a, int b, base_error *err) {
  double *M, *q;
  BASE_TRY(need_size(n, 1, 2000, err));
  if (b < 0 || b > SUM_MAX) {
    return BASE_FAIL(err, BASE_EINVAL, "subset_sum: b = %d, need 0 to %d", b, SUM_MAX);
  }
  const int size = n + 2;
  BASE_TRY(known_dense(k, size, &M, &q, err));
  BASE_TRY(answer_arrays(k, err));
  for (int i = 0; i < n; i++) {
    if (a[i] < 1) {
      return BASE_FAIL(err, BASE_EINVAL, "subset_sum: a_%d = %d, need >= 1", i + 1, a[i]);
    }
    AT(M, size, i, i) = -1.0;
    AT(M, size, n, i) = a[i];
    AT(M, size, n + 1, i) = -(double)a[i];
    q[i] = 1.0;
  }
  q[n] = -(double)b;
  q[n + 1] = b;
  int *first = calloc((size_t)b + 1, sizeof *first);
  if (first == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "subset_sum: no memory for sums to %d", b);
  }
  const bool found = find_subset(n, a, b, first, k->z);
  free(first);
  k->answer = found ? KNOWN_SOLVABLE : KNOWN_UNSOLVABLE;
  for (int i = 0; i < n; i++) {
    k->w[i] = 1.0 - k->z[i];
  }
  if (!found) {
    k->z = NULL; /* the arrays stay owned */
    k->w = NULL;
  }
  k->p.traits = LCP_ZERO_DIAGONAL;
  return BASE_OK;
}
