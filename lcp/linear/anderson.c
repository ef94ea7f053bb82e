#include "lcp/linear/anderson.h"

#include <lapacke.h>
#include <string.h>

static const double rank_tol = 1e-8; /* directions of the mixing that the differences do not tell */
enum {
  WORK = 4 * LIN_ANDERSON_DEPTH + 1
}; /* what dgelsy needs for so few columns, without blocks */

void lin_anderson_layout(lin_anderson *a, int cap, base_arena *m) {
  const size_t n = (size_t)cap;
  a->at = BASE_ARRAY(m, double, n);
  a->step = BASE_ARRAY(m, double, n);
  a->d_at = BASE_ARRAY(m, double, n *LIN_ANDERSON_DEPTH);
  a->d_step = BASE_ARRAY(m, double, n *LIN_ANDERSON_DEPTH);
  a->mix = BASE_ARRAY(m, double, n *LIN_ANDERSON_DEPTH);
  a->rest = BASE_ARRAY(m, double, n);
}

void lin_anderson_begin(lin_anderson *a, int n) {
  a->n = n;
  a->taken = a->kept = 0;
}

/* Takes a point and its step in, and their differences from those of the last time. */
static void take(lin_anderson *a, const double *step, int from, const double *x) {
  const int column = a->kept % LIN_ANDERSON_DEPTH * a->n;
  for (int i = 0; i < a->n && a->taken >= from; i++) {
    a->d_at[column + i] = x[i] - a->at[i];
    a->d_step[column + i] = step[i] - a->step[i];
  }
  memcpy(a->at, x, (size_t)a->n * sizeof *x);
  memcpy(a->step, step, (size_t)a->n * sizeof *step);
  a->kept += a->taken >= from;
  a->taken++;
}

/* LAPACKE asks this where it takes its own memory, and does not here. */
static bool known(size_t n, const double *x) {
  for (size_t i = 0; i < n; i++) {
    if (x[i] != x[i]) {
      return false;
    }
  }
  return true;
}

base_status lin_anderson_next(lin_anderson *a, const double *step, int from, double *x,
                              base_error *err) {
  take(a, step, from, x);
  const int n = a->n, deep = (a->kept < LIN_ANDERSON_DEPTH) ? a->kept : LIN_ANDERSON_DEPTH;
  const int m = (deep < n) ? deep : n;
  for (int j = 0; j < m; j++) {
    memcpy(a->mix + (ptrdiff_t)j * n,
           a->d_step + (ptrdiff_t)((a->kept - 1 - j) % LIN_ANDERSON_DEPTH) * n,
           (size_t)n * sizeof *a->mix);
  }
  memcpy(a->rest, a->step, (size_t)n * sizeof *a->rest);
  lapack_int pivot[LIN_ANDERSON_DEPTH] = {0}, rank = 0;
  double work[WORK];
  if (!(known((size_t)n, a->rest) && known((size_t)n * (size_t)m, a->mix)) ||
      (m > 0 && LAPACKE_dgelsy_work(LAPACK_COL_MAJOR, n, m, 1, a->mix, n, a->rest, n, pivot,
                                    rank_tol, &rank, work, WORK) != 0)) {
    return BASE_FAIL(err, BASE_EEXTERNAL, "a fixed point's differences could not be mixed");
  }
  for (int i = 0; i < n; i++) {
    x[i] += a->step[i];
    for (int j = 0; j < m; j++) {
      const int k = (a->kept - 1 - j) % LIN_ANDERSON_DEPTH * n + i;
      x[i] -= a->rest[j] * (a->d_at[k] + a->d_step[k]);
    }
  }
  return BASE_OK;
}
