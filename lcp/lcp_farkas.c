#include "lcp/lcp_farkas.h"

enum { DENOMINATOR_MAX = 256 };

/* A sum held as head + tail +- lost. */
typedef struct exact_sum {
  long double head, tail, lost;
} exact_sum;

static long double two_sum(long double a, long double b, long double *rest) { /* Knuth 1969 */
  const long double sum = a + b;
  const long double part = sum - a;
  *rest = (a - (sum - part)) + (b - part);
  return sum;
}

static void add(exact_sum *s, long double v) {
  long double rest;
  long double gone;
  s->head = two_sum(s->head, v, &rest);
  s->tail = two_sum(s->tail, rest, &gone);
  s->lost += fabsl(gone);
}

/* a b = p + r exactly; far from underflow, where r would be lost. */
static void add_product(exact_sum *s, double a, double b) {
  const long double p = (long double)a * (long double)b;
  add(s, p);
  add(s, fmal((long double)a, (long double)b, -p));
}

/* -1, 0, 1, or 2 when undecided. */
static int sign_of(const exact_sum *s) {
  const long double v = s->head + s->tail;
  if (!isfinite(v) || !isfinite(s->lost) || (s->lost > 0 && fabsl(v) <= 4 * s->lost)) {
    return 2;
  }
  return (v > 0) - (v < 0);
}

static int column_sign(const lcp_matrix *M, int j, const double *y) {
  exact_sum s = {0, 0, 0};
  if (M->storage == LCP_DENSE) {
    for (int i = 0; i < M->n; i++) {
      add_product(&s, M->val[(ptrdiff_t)j * M->n + i], y[i]);
    }
  } else {
    for (int k = M->csc.colptr[j]; k < M->csc.colptr[j + 1]; k++) {
      add_product(&s, M->csc.val[k], y[M->csc.rowind[k]]);
    }
  }
  return sign_of(&s);
}

static bool holds(const lcp_matrix *M, const double *q, const unsigned char *kind,
                  const double *y) {
  exact_sum value = {0, 0, 0};
  for (int i = 0; i < M->n; i++) {
    const bool is_free = kind != NULL && kind[i] != 0;
    if (!isfinite(y[i]) || (y[i] < 0 && !is_free)) {
      return false;
    }
    add_product(&value, q[i], y[i]);
  }
  if (sign_of(&value) != -1) {
    return false;
  }
  for (int j = 0; j < M->n; j++) {
    const int sign = column_sign(M, j, y);
    if (sign > 0 || (sign < 0 && kind != NULL && kind[j] != 0)) {
      return false;
    }
  }
  return true;
}

/* Smallest k <= 256 with k y_i / max|y| integer to 1e-9 for all i; 0: none. */
static int denominator(const double *y, int n, double top) {
  for (int k = 1; k <= DENOMINATOR_MAX; k++) {
    bool fits = true;
    for (int i = 0; i < n && fits; i++) {
      const double v = k * (y[i] / top);
      fits = fabs(v - nearbyint(v)) <= 1e-9 * k;
    }
    if (fits) {
      return k;
    }
  }
  return 0;
}

bool lcp_farkas_prove(const lcp_matrix *M, const double *q, const unsigned char *kind, double *y) {
  double top = 0;
  for (int i = 0; i < M->n; i++) {
    top = fmax(top, fabs(y[i]));
  }
  if (!(top > 0) || !isfinite(top) || M->storage == LCP_FACTORED) {
    return false;
  }
  const int k = denominator(y, M->n, top);
  for (int i = 0; i < M->n; i++) {
    y[i] = (k > 0) ? nearbyint(k * (y[i] / top)) : ldexp(y[i], -ilogb(top)); /* no digit lost */
  }
  return holds(M, q, kind, y);
}
