#include "lcp/solvers/lemke/phase_one.h"

#include <math.h>

static const double zero =
    1e-11; /* entries of the tableau below this, of columns of size 1, are round-off */

static bool may_be_positive(const lemke_phase *phase, int var) {
  return phase->allowed == NULL || phase->allowed[var] != 0;
}

/* Brings allowed variables in for those that must be zero, where a row has an entry to do it with. What is left then
 * is a row of zeros. */
static void drive_out(lemke_engine *e, const lin_tableau *b, const lemke_phase *phase) {
  for (int i = 0; i < e->n; ++i) {
    const int at = may_be_positive(phase, i) ? -1 : e->where[i];
    int best = -1;
    double size = zero;
    for (int c = 0; c < e->n && at >= 0; ++c) {
      const double v = fabs(lin_tableau_entries(b, c)[at]);
      if (may_be_positive(phase, b->var[c]) && v > size) {
        size = v;
        best = b->var[c];
      }
    }
    if (best >= 0) {
      (void)e->kind->replace(e, at, best, e->kind->column(e, best, NULL));
    }
  }
}

/* z0 comes in with a one in every row that may not be negative, against the most negative value; false where there is
 * none. */
static bool enter_z0(lemke_path *t, lemke_engine *e, const lemke_phase *phase) {
  int low = -1;
  for (int i = 0; i < e->n; ++i) {
    t->room[i] = may_be_positive(phase, e->head[i]) ? -1 : 0;
    if (t->room[i] != 0 && e->x[i] < 0 && (low < 0 || e->x[i] < e->x[low])) {
      low = i;
    }
  }
  if (low >= 0) {
    e->kind->open(e, t->room);
    (void)e->kind->replace(e, low, 2 * e->n, t->room);
  }
  return low >= 0;
}

/* The nonbasic variable of lowest number whose growth lets z0, in position p, fall; -1: none. */
static int entering(const lemke_engine *e, const lin_tableau *b, const lemke_phase *phase, int p) {
  int best = -1;
  for (int c = 0; c <= e->n; ++c) {
    const int var = b->var[c];
    if (var != 2 * e->n && may_be_positive(phase, var) && (best < 0 || var < best) &&
        lin_tableau_entries(b, c)[p] > zero) {
      best = var;
    }
  }
  return best;
}

/* Position with the smallest ratio; of equal ones that of z0, or of the variable of lowest number. */
static int leaving(const lemke_engine *e, const lemke_phase *phase, const double *d) {
  int best = -1;
  for (int i = 0; i < e->n; ++i) {
    const bool z0 = e->head[i] == 2 * e->n;
    if (!(d[i] > zero) || (!z0 && !may_be_positive(phase, e->head[i]))) {
      continue;
    }
    const double gap = (best < 0) ? -1 : e->x[i] * d[best] - e->x[best] * d[i];
    const bool first = z0 || (best >= 0 && e->head[best] != 2 * e->n && e->head[i] < e->head[best]);
    best = (gap < 0 || (gap == 0 && first)) ? i : best;
  }
  return best;
}

/* The row of z0 reads  z0 + sum a_c v_c = x > 0  with no a_c above zero: y_i = -a of w_i. */
static void read_proof(const lemke_engine *e, const lin_tableau *b, double *y) {
  const int p = e->where[2 * e->n];
  for (int i = 0; i < e->n; ++i) {
    const int c = b->column[i];
    y[i] = (c < 0) ? 0 : lemke_larger(-lin_tableau_entries(b, c)[p], 0);
  }
}

lemke_end lemke_phase_one(lemke_path *t, lemke_table *table, const lemke_system *s,
                          lemke_phase phase, double *y) {
  lemke_engine *e = &table->engine;
  const lin_tableau *b = &table->tableau;
  memset(t->in_z, 0, (size_t)s->rows);
  e->generic = false;
  lemke_engine_forget(e);
  if (!e->kind->fill(e, s, t->in_z)) {
    return LEMKE_BROKEN;
  }
  for (int c = 0; c < e->n && phase.lift != 0; ++c) {
    for (int i = 0; i < e->n; ++i) {
      lin_tableau_entries(b, c)[i] -= phase.lift;
    }
  }
  lemke_engine_forget(e); /* what is pivoted now is no basis of a path */
  drive_out(e, b, &phase);
  if (!enter_z0(t, e, &phase)) {
    return LEMKE_SOLVED;
  }
  for (;;) {
    const int p = e->where[2 * e->n];
    const int var = entering(e, b, &phase, p);
    if (var < 0) {
      read_proof(e, b, y);
      return (e->x[p] > zero) ? LEMKE_RAY : LEMKE_SOLVED;
    }
    const double *d = e->kind->column(e, var, NULL);
    const int r = leaving(e, &phase, d);
    if (t->pivots >= t->pivot_limit || r < 0) {
      return (r < 0) ? LEMKE_BROKEN : LEMKE_LIMIT;
    }
    if (lemke_path_late(t)) {
      return LEMKE_TIMEOUT;
    }
    (void)e->kind->replace(e, r, var, d);
    t->pivots++;
    if (r == p) {
      return LEMKE_SOLVED;
    }
  }
}
