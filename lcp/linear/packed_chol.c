#include "lcp/linear/packed_chol.h"

#include <math.h>

/* Four partial sums: the order is fixed, so the result is the same in every build. */
static double dot(const double *a, const double *b, int n) {
  double s0 = 0;
  double s1 = 0;
  double s2 = 0;
  double s3 = 0;
  int k = 0;
  for (; k + 4 <= n; k += 4) {
    s0 += a[k] * b[k];
    s1 += a[k + 1] * b[k + 1];
    s2 += a[k + 2] * b[k + 2];
    s3 += a[k + 3] * b[k + 3];
  }
  for (; k < n; k++) {
    s0 += a[k] * b[k];
  }
  return (s0 + s1) + (s2 + s3);
}

void lin_chol_forward(const double *L, int m, double *x) {
  int first = 0;
  while (first < m && x[first] == 0) {
    first++; /* a sparse column starts late */
  }
  for (int k = first; k < m; k++) {
    const double *row = L + lin_chol_row(k);
    x[k] = (x[k] - dot(row + first, x + first, k - first)) / row[k];
  }
}

void lin_chol_backward(const double *L, int m, double *x) {
  for (int k = m - 1; k >= 0; k--) {
    const double *row = L + lin_chol_row(k);
    const double xk = x[k] / row[k];
    x[k] = xk;
    if (xk != 0) {
      for (int j = 0; j < k; j++) {
        x[j] -= row[j] * xk;
      }
    }
  }
}

void lin_chol_append(double *L, int m, const double *x, double root) {
  double *row = L + lin_chol_row(m);
  for (int k = 0; k < m; k++) {
    row[k] = x[k];
  }
  row[m] = root;
}

/* Dropping row p leaves a lower Hessenberg matrix; rotation j mixes columns j and j+1 so that the
 * entry right of the diagonal vanishes. Rows are moved up by one as they are rotated. */
void lin_chol_remove(double *L, int m, int p, double *cs) {
  double *c = cs;
  double *s = cs + m;
  for (int k = p + 1; k < m; k++) {
    const double *old = L + lin_chol_row(k);
    double *row = L + lin_chol_row(k - 1);
    for (int j = 0; j < p; j++) {
      row[j] = old[j];
    }
    double carry = old[p];
    for (int j = p; j < k - 1; j++) {
      const double next = old[j + 1];
      row[j] = c[j] * carry + s[j] * next;
      carry = c[j] * next - s[j] * carry;
    }
    const double last = old[k];
    const double r = hypot(carry, last);
    c[k - 1] = carry / r;
    s[k - 1] = last / r;
    row[k - 1] = r;
  }
}
