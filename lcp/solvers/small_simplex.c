#include "lcp/solvers/small_simplex.h"

#include <math.h>

typedef long double real;

static const real zero_share = LCP_SMALL_ZERO;

void lcp_small_simplex_start(lcp_small_simplex *x, int n, real M[][LCP_SMALL_N], const real *q,
                             const int *var, int columns) {
  x->n = n;
  x->columns = columns;
  x->width = columns + n;
  x->size = 0;
  for (int c = 0; c <= x->width; c++) {
    x->cost[c] = 0;
  }
  for (int i = 0; i < x->n; i++) {
    const real sign = (q[i] < 0) ? -1 : 1;
    for (int c = 0; c < columns; c++) {
      const int v = var[c];
      const real entry = (v < x->n) ? (real)(v == i) : -M[i][v - x->n];
      x->t[i][c] = sign * entry;
    }
    for (int c = columns; c < x->width; c++) {
      x->t[i][c] = (c - columns == i) ? 1 : 0;
    }
    x->t[i][x->width] = sign * q[i];
    x->size += fabsl(q[i]);
    x->basic[i] = columns + i;
    for (int c = 0; c <= x->width; c++) {
      x->cost[c] -= (c < columns || c == x->width) ? x->t[i][c] : 0;
    }
  }
}

static void pivot(lcp_small_simplex *x, int r, int c) {
  const real d = x->t[r][c];
  for (int k = 0; k <= x->width; k++) {
    x->t[r][k] /= d;
  }
  for (int i = 0; i < x->n; i++) {
    const real f = x->t[i][c];
    for (int k = 0; i != r && f != 0 && k <= x->width; k++) {
      x->t[i][k] -= f * x->t[r][k];
    }
  }
  const real f = x->cost[c];
  for (int k = 0; k <= x->width; k++) {
    x->cost[k] -= f * x->t[r][k];
  }
  x->basic[r] = c;
}

/* Smallest ratio in column c; ties by the lowest basic variable. -1: none. */
static int leaving(const lcp_small_simplex *x, int c) {
  int r = -1;
  for (int i = 0; i < x->n; i++) {
    if (!(x->t[i][c] > zero_share)) {
      continue;
    }
    const real a = (r < 0) ? 0 : x->t[i][x->width] * x->t[r][c];
    const real b = (r < 0) ? 0 : x->t[r][x->width] * x->t[i][c];
    if (r < 0 || a < b || (a == b && x->basic[i] < x->basic[r])) {
      r = i;
    }
  }
  return r;
}

bool lcp_small_simplex_feasible(lcp_small_simplex *x) {
  for (;;) {
    int c = 0;
    while (c < x->columns && !(x->cost[c] < -zero_share)) {
      c++;
    }
    const int r = (c < x->columns) ? leaving(x, c) : -1;
    if (r < 0) {
      return fabsl(x->cost[x->width]) <= 16 * zero_share * x->size;
    }
    pivot(x, r, c);
  }
}
