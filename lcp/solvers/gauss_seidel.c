#include "lcp/solvers/gauss_seidel.h"

#include "lcp/solvers/sets.h"

enum { KEPT_ROWS = 1 << 17 }; /* rows up to which blocks are kept: 38 MB */

static size_t kept_rows(const lcp_capacity *cap) {
  return (size_t)((cap->n_block == 0) ? 0 : (cap->n < KEPT_ROWS) ? cap->n : KEPT_ROWS);
}

void lcp_gs_layout(lcp_gs *s, const lcp_capacity *cap, base_arena *a) {
  lcp_sweep_layout(&s->sweep, cap, a);
  s->lo = BASE_ARRAY(a, double, cap->n);
  s->hi = BASE_ARRAY(a, double, cap->n);
  s->whole = BASE_ARRAY(a, unsigned char, cap->n_block);
  const size_t m = (cap->n < LEMKE_BLOCK_MAX) ? (size_t)cap->n : (size_t)LEMKE_BLOCK_MAX;
  s->Mbb = BASE_ARRAY(a, double, m *m);
  s->kept = BASE_ARRAY(a, double, kept_rows(cap) * (size_t)LEMKE_KEPT_MAX);
  s->inverse = BASE_ARRAY(a, double, kept_rows(cap) * (size_t)LEMKE_KEPT_MAX);
  s->basis = BASE_ARRAY(a, lemke_kept, cap->n_block);
  s->qb = BASE_ARRAY(a, double, m);
  s->xb = BASE_ARRAY(a, double, m);
  lemke_block_layout(&s->lemke, (int)m, a);
}

/* Which blocks must be solved as a whole; refuses what neither form is defined on. */
static base_status choose(lcp_gs *s, const lcp_problem *p, base_error *err) {
  s->by_block = false;
  for (int b = 0; p->block != NULL && b < p->n_block; b++) {
    const lcp_block *k = &p->block[b];
    s->whole[b] = 0;
    for (int i = k->start; i < k->start + k->size; i++) {
      s->whole[b] |= (unsigned char)(s->sweep.d[i] == 0.0 && !lcp_set_still(p, s->sweep.d[i], i));
    }
    if (s->whole[b] && (k->set != LCP_ORTHANT || k->size < 2 || k->size > LEMKE_BLOCK_MAX)) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED,
                       "zero diagonal in block %d: need an orthant block of 2 to %d rows", b,
                       (int)LEMKE_BLOCK_MAX);
    }
    s->by_block = s->by_block || s->whole[b];
  }
  for (int i = 0; i < p->M.n; i++) {
    const bool zero = s->sweep.d[i] == 0.0 && !lcp_set_still(p, s->sweep.d[i], i);
    if (s->sweep.d[i] < 0.0 || (p->block == NULL && zero)) {
      return BASE_FAIL(err, BASE_EUNSUPPORTED,
                       "diagonal %d is %g: need > 0 (or contact blocks where it is 0)", i,
                       s->sweep.d[i]);
    }
  }
  return BASE_OK;
}

static bool is_kept(const lcp_block *b) {
  return b->size <= LEMKE_KEPT_MAX && b->start + b->size <= KEPT_ROWS;
}

/* M_bb of a block: kept from sweep to sweep, or, where that would take much memory, read anew. */
static double *block_of(lcp_gs *s, const lcp_block *b) {
  return is_kept(b) ? s->kept + (size_t)b->start * LEMKE_KEPT_MAX : s->Mbb;
}

base_status lcp_gs_prepare(lcp_gs *s, const lcp_problem *p, base_error *err) {
  BASE_TRY(lcp_sweep_prepare(&s->sweep, p, err));
  lcp_set_intervals(p, s->lo, s->hi);
  BASE_TRY(choose(s, p, err));
  for (int b = 0; s->by_block && b < p->n_block; b++) {
    const lcp_block *k = &p->block[b];
    if (s->whole[b] && is_kept(k)) {
      lcp_sweep_block(&s->sweep, p, k->start, k->size, block_of(s, k));
      s->basis[b] = (lemke_kept){.support = 0};
    }
  }
  return BASE_OK;
}

void lcp_gs_start(lcp_gs *s, const lcp_problem *p, double *z, lcp_work *work) {
  for (int i = 0; i < p->M.n; i++) {
    z[i] = lcp_set_clip(z[i], s->lo[i], s->hi[i]);
  }
  lcp_sweep_refresh(&s->sweep, p, z, work);
}

static void points(lcp_gs *s, const lcp_problem *p, double omega, int first, int end, double *z) {
  for (int i = first; i < end; i++) {
    const double w = lcp_sweep_row(&s->sweep, p, i);
    const double x = (s->sweep.d[i] > 0.0)
                         ? lcp_set_clip(z[i] - omega * (w / s->sweep.d[i]), s->lo[i], s->hi[i])
                         : lcp_set_end(z[i], w, s->lo[i], s->hi[i]);
    if (x != z[i]) {
      lcp_sweep_add(&s->sweep, p, i, x - z[i]);
      z[i] = x;
    }
  }
}

/* The block's LCP into xb: in the basis that z has, or by Lemke's path. False: it ends on a ray. */
static bool solve_block(lcp_gs *s, const lcp_problem *p, const lcp_block *b, const double *M,
                        const double *zb) {
  const bool stays =
      M != s->Mbb &&
      lemke_block_stays(&s->basis[b - p->block], s->inverse + (size_t)b->start * LEMKE_KEPT_MAX,
                        b->size, M, s->qb, zb, s->xb);
  return stays || lemke_block_solve(&s->lemke, b->size, M, s->qb, s->xb);
}

static void block(lcp_gs *s, const lcp_problem *p, double omega, const lcp_block *b, double *z,
                  lcp_result *res) {
  const int m = b->size;
  double *zb = z + b->start, *M = block_of(s, b);
  if (M == s->Mbb) {
    lcp_sweep_block(&s->sweep, p, b->start, m, M);
  }
  for (int i = 0; i < m; i++) {
    s->qb[i] = lcp_sweep_row(&s->sweep, p, b->start + i);
    for (int j = 0; j < m; j++) {
      s->qb[i] -= M[i + j * m] * zb[j];
    }
  }
  if (!solve_block(s, p, b, M, zb)) {
    res->work.fallbacks++;
    return;
  }
  for (int i = 0; i < m; i++) {
    const double x = (omega == 1.0) ? s->xb[i] : fmax(0.0, zb[i] + omega * (s->xb[i] - zb[i]));
    if (x != zb[i]) {
      lcp_sweep_add(&s->sweep, p, b->start + i, x - zb[i]);
      zb[i] = x;
    }
  }
}

void lcp_gs_sweep(lcp_gs *s, const lcp_problem *p, double omega, double *z, lcp_result *res) {
  if (!s->by_block) {
    points(s, p, omega, 0, p->M.n, z);
    return;
  }
  for (int b = 0; b < p->n_block; b++) {
    const lcp_block *k = &p->block[b];
    if (s->whole[b]) {
      block(s, p, omega, k, z, res);
    } else {
      points(s, p, omega, k->start, k->start + k->size, z);
    }
  }
}
