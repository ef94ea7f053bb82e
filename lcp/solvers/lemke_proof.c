/* Proof of infeasibility: y >= 0, M'y <= 0, q'y < 0, decided exactly on the binary numbers of the
 * problem. For M positive semidefinite, or copositive-plus, the z-part of a terminating ray is such
 * a y (Cottle, Pang & Stone 1992, theorem 4.4.11); rounded data often need y with few digits. */
#include "lcp/solvers/lemke.h"

#include <math.h>
#include <string.h>

enum { DENOMINATOR_MAX = 256 };
static const double SNAP = 1e-8; /* y is a multiple of 1/denominator up to this [1] */

/* A sum of products held as head + tail +- doubt; doubt = 0 means exactly. */
typedef struct exact_sum {
  double head, tail, doubt;
} exact_sum;

static double two_sum(double a, double b, double *error) { /* Knuth: a + b = sum + error exactly */
  const double sum = a + b;
  const double part = sum - a;
  *error = (a - (sum - part)) + (b - part);
  return sum;
}

static void add(exact_sum *s, double v) {
  double rest;
  double lost;
  s->head = two_sum(s->head, v, &rest);
  s->tail = two_sum(s->tail, rest, &lost);
  s->doubt += fabs(lost);
}

static void add_product(exact_sum *s, double a, double b) {
  const double p = a * b;
  if (p != 0 && fabs(p) < 0x1p-900) { /* the error term could underflow */
    s->doubt += fabs(p);
    return;
  }
  add(s, p);
  add(s, fma(a, b, -p));
}

/* Sign of the sum, certain: -1, 0, 1; 2 when the doubt is larger than the value. */
static int sign_of(const exact_sum *s) {
  double rest;
  const double v = two_sum(s->head, s->tail, &rest);
  if (!isfinite(v) || (s->doubt > 0 && fabs(v) <= 4 * s->doubt)) {
    return 2;
  }
  return (v > 0) - (v < 0);
}

static int column_sign(const lcp_matrix *M, int j, const double *y) {
  exact_sum s = {0, 0, 0};
  if (M->storage == LCP_DENSE) {
    for (int i = 0; i < M->n; ++i) {
      add_product(&s, M->val[(size_t)j * (size_t)M->n + (size_t)i], y[i]);
    }
  } else {
    for (int p = M->csc.colptr[j]; p < M->csc.colptr[j + 1]; ++p) {
      add_product(&s, M->csc.val[p], y[M->csc.rowind[p]]);
    }
  }
  return sign_of(&s);
}

/* Free rows: z_j has no sign, so (M'y)_j = 0 is asked, and y_j may have any sign. */
static bool proves(const lemke_system *s, const lcp_problem *p, const double *y) {
  exact_sum value = {0, 0, 0};
  for (int i = 0; i < p->M.n; ++i) {
    if (!isfinite(y[i]) || (y[i] < 0 && !s->is_free[i])) {
      return false;
    }
    add_product(&value, p->q[i], y[i]);
  }
  if (sign_of(&value) != -1) {
    return false;
  }
  for (int j = 0; j < p->M.n; ++j) {
    const int sign = column_sign(&p->M, j, y);
    if (sign > 0 || (sign < 0 && s->is_free[j])) {
      return false;
    }
  }
  return true;
}

/* A row with w_i < 0 for every z >= 0. */
static bool hopeless_row(const lemke_system *s, const lcp_problem *p, double *y) {
  memset(y, 0, sizeof(double) * (size_t)p->M.n);
  for (int i = 0; i < p->M.n; ++i) {
    s->row_top[i] = s->is_free[i] ? 0 : -1; /* sign of the largest entry */
  }
  for (int j = 0; j < p->M.n; ++j) {
    for (int k = s->colptr[j]; k < s->colptr[j + 1]; ++k) {
      if (s->val[k] > 0 || s->is_free[j]) {
        s->row_top[s->rowind[k]] = 1;
      }
    }
  }
  for (int i = 0; i < p->M.n; ++i) {
    if (s->row_top[i] < 0 && p->q[i] < 0) {
      y[i] = 1;
      return true;
    }
  }
  return false;
}

/* y <- the nearest vector of small fractions, scaled to integers; false when there is none. */
static bool snap(double *y, int n) {
  double top = 0;
  for (int i = 0; i < n; ++i) {
    top = fmax(top, fabs(y[i]));
  }
  for (int c = 1; c <= DENOMINATOR_MAX; ++c) {
    bool near = true;
    for (int i = 0; i < n && near; ++i) {
      const double v = y[i] / top * c;
      near = fabs(v - nearbyint(v)) <= SNAP * c;
    }
    if (near) {
      for (int i = 0; i < n; ++i) {
        y[i] = nearbyint(y[i] / top * c);
      }
      return true;
    }
  }
  return false;
}

/* The ray: basic values move by -d, the driving variable by 1. */
static void read_ray(const lemke_path *t, const lemke_system *s, double *y) {
  for (int i = 0; i < s->n; ++i) {
    const int var = s->rows + i;
    const int at = t->basis.where[var];
    const double v = (var == t->entering) ? 1 : (at < 0) ? 0 : -t->d[at];
    y[i] = ldexp((v > 0 || s->is_free[i]) ? v : 0, s->col_exp[i]);
  }
}

bool lemke_farkas(const lemke_path *t, const lemke_system *s, const lcp_problem *p, double *y) {
  if (p->M.storage != LCP_FACTORED) { /* entries of J W J' are not given, so nothing is exact */
    if (hopeless_row(s, p, y)) {
      return true;
    }
    read_ray(t, s, y);
    if (proves(s, p, y) || (snap(y, s->n) && proves(s, p, y))) {
      return true;
    }
  }
  read_ray(t, s, y);
  return false;
}
