/* The engine `basis`: a factored kernel with product-form updates; a column is solved for when it is asked. */
#include "lcp/solvers/lemke/engine.h"

#include <assert.h>
#include <math.h>

enum { REPAIRS = 64 }; /* rounds of repairing a singular first basis */

static lemke_basis *basis_of(lemke_engine *e) {
  return (lemke_basis *)e;
}

static bool refactor(lemke_basis *b) {
  lemke_engine *e = &b->engine;
  if (!lin_basis_factor(&b->basis)) {
    return false;
  }
  memcpy(e->x, e->system->q, sizeof *e->x * (size_t)e->n);
  lin_basis_solve(&b->basis, e->x);
  if (e->generic) {
    memcpy(e->delta, b->delta_rhs, sizeof *e->delta * (size_t)e->n);
    lin_basis_solve(&b->basis, e->delta);
  }
  return true;
}

/* Row with the largest entry in column j that could join the basis to make column j independent. */
static int helper_row(const lemke_basis *b, const unsigned char *in_z, int j) {
  const lcp_column c = lemke_system_column(b->engine.system, j);
  int best = -1;
  double size = 0;
  for (int p = 0; p < c.count; ++p) {
    const int i = (c.row == NULL) ? p : c.row[p];
    if (!lemke_is_free(b->engine.system, i) && !in_z[i] && !b->tried[i] && fabs(c.val[p]) > size) {
      size = fabs(c.val[p]);
      best = i;
    }
  }
  return best;
}

/* Dependent columns are repaired: a bounded z gives way to its w; a free one is helped by a pair (i, z_i) that makes
 * it independent (rows of M_FF alone may be dependent) or, where there is none, stays at zero as a redundant
 * constraint, its w_i = 0 left to the residual test. */
static bool factor_first(lemke_basis *b, unsigned char *in_z) {
  memset(b->tried, 0, (size_t)b->sys.n);
  for (int round = 0; round < REPAIRS; ++round) {
    lin_basis_start(&b->basis, &b->sys, in_z);
    if (refactor(b)) {
      return true;
    }
    const lin_lu *lu = &b->basis.lu;
    for (int k = lu->n - lu->deficient; k < lu->n; ++k) {
      const int j = b->basis.kernel_var[lu->col[k]] - b->sys.n;
      const int help = lemke_is_free(b->engine.system, j) ? helper_row(b, in_z, j) : -1;
      const int change = (help >= 0) ? help : j;
      in_z[change] = help >= 0;
      b->tried[change] = 1;
    }
    if (b->basis.full) {
      return false;
    }
  }
  return false;
}

static bool fill(lemke_engine *e, const lemke_system *s, unsigned char *in_z) {
  lemke_basis *b = basis_of(e);
  e->generic = false;
  if (b->basis.fresh && lemke_engine_holds(e, s, in_z)) {
    return true;
  }
  if (e->system != s || e->edition != s->edition) {
    b->basis.lu.ordering = LIN_BY_COUNT;
  }
  assert(s->colptr != NULL && !s->view);
  e->system = s;
  e->edition = s->edition;
  b->sys = (lin_system){s->rows, s->colptr, s->rowind, s->val, b->cover};
  e->n = s->rows;
  return factor_first(b, in_z);
}

static void open(lemke_engine *e, const double *d) {
  lemke_basis *b = basis_of(e);
  memset(b->work, 0, sizeof *b->work * (size_t)e->n);
  lin_basis_residual(&b->basis, d, b->work, b->sum); /* 0 - B d, the cover being -B d */
  for (int i = 0; i < e->n; ++i) {
    b->cover[i] = (double)b->sum[i];
  }
  if (!e->generic) {
    return;
  }
  lin_basis_residual(&b->basis, e->delta, b->work, b->sum);
  for (int i = 0; i < e->n; ++i) {
    b->delta_rhs[i] = -(double)b->sum[i];
  }
}

static const double *column(lemke_engine *e, int var, double *room) {
  lemke_basis *b = basis_of(e);
  lin_basis_column(&b->basis, var, room);
  lin_basis_solve(&b->basis, room);
  return room;
}

/* The values after the pivot at position p. */
static void step(int n, double *restrict x, int p, const double *restrict d) {
  const double by = x[p] / d[p];
  for (int i = 0; i < n && by != 0; ++i) {
    x[i] -= by * d[i];
  }
  x[p] = by;
}

static bool replace(lemke_engine *e, int p, int entering, const double *d) {
  lemke_basis *b = basis_of(e);
  step(e->n, e->x, p, d);
  if (e->generic) {
    step(e->n, e->delta, p, d);
  }
  lin_basis_replace(&b->basis, p, entering, d);
  return !lin_basis_due(&b->basis) || refactor(b);
}

static void settle(lemke_engine *e, double *r) {
  lin_basis_solve(&basis_of(e)->basis, r);
  for (int i = 0; i < e->n; ++i) {
    e->x[i] += r[i];
  }
}

static const lemke_engine_kind basis_kind = {.word = "basis",
                                             .fill = fill,
                                             .open = open,
                                             .column = column,
                                             .replace = replace,
                                             .settle = settle};

void lemke_basis_layout(lemke_basis *b, int rows, int nnz, base_arena *a) {
  lin_basis_layout(&b->basis, rows, nnz, a);
  b->engine = (lemke_engine){.kind = &basis_kind, .head = b->basis.head, .where = b->basis.where};
  b->engine.x = BASE_ARRAY(a, double, rows);
  b->engine.delta = BASE_ARRAY(a, double, rows);
  b->cover = BASE_ARRAY(a, double, rows);
  b->delta_rhs = BASE_ARRAY(a, double, rows);
  b->work = BASE_ARRAY(a, double, rows);
  b->sum = BASE_ARRAY(a, long double, rows);
  b->tried = BASE_ARRAY(a, unsigned char, rows);
}
