#include "lcp/lcp_farkas.h"

#include "lcp/lcp_column.h"
#include "lcp/lcp_mixture.h"

enum { DENOMINATOR_MAX = 256 };

static long double two_sum(long double a, long double b, long double *rest) { /* Knuth 1969 */
  const long double sum = a + b;
  const long double part = sum - a;
  *rest = (a - (sum - part)) + (b - part);
  return sum;
}

static void add(lcp_farkas_sum *s, long double v) {
  long double rest;
  long double gone;
  s->head = two_sum(s->head, v, &rest);
  s->tail = two_sum(s->tail, rest, &gone);
  s->lost += fabsl(gone);
}

/* a b = p + r exactly; far from underflow, where r would be lost. */
static void add_product(lcp_farkas_sum *s, double a, double b) {
  const long double p = (long double)a * (long double)b;
  add(s, p);
  add(s, fmal((long double)a, (long double)b, -p));
}

/* -1, 0, 1, or 2 when undecided. */
static int sign_of(const lcp_farkas_sum *s) {
  const long double v = s->head + s->tail;
  if (!isfinite(v) || !isfinite(s->lost) || (s->lost > 0 && fabsl(v) <= 4 * s->lost)) {
    return 2;
  }
  return (v > 0) - (v < 0);
}

/* Of a factored M: of S alone. */
static int column_sign(const lcp_matrix *M, int j, const double *y) {
  lcp_farkas_sum s = {0, 0, 0};
  const lcp_column c = lcp_column_of(M, j);
  for (int k = 0; k < c.count; k++) {
    add_product(&s, c.val[k], y[lcp_column_row(&c, k)]);
  }
  return sign_of(&s);
}

/* M = J W J' + S: a y that moves no body, J'y = 0, leaves M'y = S'y. One pass over J. */
static bool moves_nothing(const lcp_factored *f, const double *y, lcp_farkas_sum *force) {
  const int n_dof = f->dof_start[f->n_body];
  for (int c = 0; c < n_dof; c++) {
    force[c] = (lcp_farkas_sum){0, 0, 0};
  }
  for (int g = 0; g < f->n_group; g++) {
    double room[LCP_MIXED_MAX] = {0};
    const double *jac = lcp_factored_rows(f, g, room);
    for (int side = 0; side < 2; side++) {
      const int b = f->body[2 * g + side];
      const int dof = (b < 0) ? 0 : f->dof_start[b + 1] - f->dof_start[b];
      for (int i = f->row_start[g]; i < f->row_start[g + 1] && b >= 0; i++, jac += dof) {
        for (int c = 0; c < dof && y[i] != 0; c++) {
          add_product(&force[f->dof_start[b] + c], jac[c], y[i]);
        }
      }
    }
  }
  for (int c = 0; c < n_dof; c++) {
    if (sign_of(&force[c]) != 0) {
      return false;
    }
  }
  return true;
}

static bool holds(const lcp_matrix *M, const double *q, const unsigned char *kind,
                  lcp_farkas_sum *force, const double *y) {
  lcp_farkas_sum value = {0, 0, 0};
  for (int i = 0; i < M->n; i++) {
    const int row = (kind != NULL) ? kind[i] : LCP_FARKAS_SIGNED;
    if (!isfinite(y[i]) || (y[i] < 0 && row == LCP_FARKAS_SIGNED) ||
        (y[i] != 0 && row == LCP_FARKAS_SIDEWAYS)) {
      return false;
    }
    add_product(&value, q[i], y[i]);
  }
  if (sign_of(&value) != -1 ||
      (M->storage == LCP_FACTORED && !moves_nothing(M->factored, y, force))) {
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

bool lcp_farkas_prove(const lcp_matrix *M, const double *q, const unsigned char *kind,
                      lcp_farkas_sum *force, double *y) {
  double top = 0;
  for (int i = 0; i < M->n; i++) {
    top = fmax(top, fabs(y[i]));
  }
  if (!(top > 0) || !isfinite(top)) {
    return false;
  }
  const int k = denominator(y, M->n, top);
  for (int i = 0; i < M->n; i++) {
    y[i] = (k > 0) ? nearbyint(k * (y[i] / top)) : ldexp(y[i], -ilogb(top)); /* no digit lost */
  }
  return holds(M, q, kind, force, y);
}
