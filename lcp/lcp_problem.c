/* lcp_problem.c - is this a problem at all? Shapes, ranges, finiteness. */
#include "lcp/lcp_problem.h"

#include "lcp/lcp_mixture.h"

#include <limits.h>

static base_status check_values(const double *x, size_t n, const char *what, base_error *err) {
  if (n > 0 && x == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: missing", what);
  }
  for (size_t i = 0; i < n; i++) {
    if (!isfinite(x[i])) {
      return BASE_FAIL(err, BASE_EINVAL, "%s[%zu] is %g: need finite numbers", what, i, x[i]);
    }
  }
  return BASE_OK;
}

/* Offsets start at 0 and never decrease. */
static base_status check_offsets(const int *start, int n, const char *what, base_error *err) {
  if (start == NULL || start[0] != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: need offsets that start at 0", what);
  }
  for (int i = 0; i < n; i++) {
    if (start[i + 1] < start[i]) {
      return BASE_FAIL(err, BASE_EINVAL, "%s[%d]: offsets decrease", what, i + 1);
    }
  }
  return BASE_OK;
}

static base_status check_csc(const lcp_csc *m, int n, const char *what, base_error *err) {
  if (m->n_row != n || m->n_col != n) {
    return BASE_FAIL(err, BASE_EINVAL, "%s is %d x %d: need %d x %d", what, m->n_row, m->n_col, n,
                     n);
  }
  BASE_TRY(check_offsets(m->colptr, n, "column pointers", err));
  if (m->colptr[n] > 0 && m->rowind == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: row indices missing", what);
  }
  for (int j = 0; j < n; j++) {
    for (int k = m->colptr[j]; k < m->colptr[j + 1]; k++) {
      const bool ordered = k == m->colptr[j] || m->rowind[k] > m->rowind[k - 1];
      if (m->rowind[k] < 0 || m->rowind[k] >= n || !ordered) {
        return BASE_FAIL(err, BASE_EINVAL,
                         "%s: row index %d in column %d: need increasing indices in 0..%d", what,
                         m->rowind[k], j, n - 1);
      }
    }
  }
  return check_values(m->val, (size_t)m->colptr[n], what, err);
}

bool lcp_csc_is_sorted(const lcp_csc *m) {
  bool good = m->colptr[0] == 0;
  for (int j = 0; j < m->n_col && good; j++) {
    int last = -1;
    for (int k = m->colptr[j]; k < m->colptr[j + 1]; k++) {
      good = good && m->rowind[k] > last;
      last = m->rowind[k];
    }
    good = good && m->colptr[j] <= m->colptr[j + 1] && last < m->n_row;
  }
  return good;
}

static base_status check_bodies(const lcp_factored *f, base_error *err) {
  for (int b = 0; b < f->n_body; b++) {
    const int dofs = f->dof_start[b + 1] - f->dof_start[b];
    if (dofs < 0 || f->weight_start[b + 1] - f->weight_start[b] != dofs * dofs) {
      return BASE_FAIL(err, BASE_EINVAL, "body %d: need a square weight block for its %d dofs", b,
                       dofs);
    }
  }
  BASE_TRY(check_values(f->weight, (size_t)f->weight_start[f->n_body], "W", err));
  for (int b = 0; b < f->n_body; b++) {
    const int n = f->dof_start[b + 1] - f->dof_start[b];
    const double *W = f->weight + f->weight_start[b];
    for (int k = 0; k < n * n; k++) {
      if (W[k] != W[k % n * n + k / n]) {
        return BASE_FAIL(err, BASE_EINVAL, "body %d: weight block is not symmetric", b);
      }
    }
  }
  return BASE_OK;
}

/* Rows that are mixed of few. */
static base_status check_mixture(const lcp_factored *f, int g, int cols, base_error *err) {
  const lcp_mixture *m = lcp_mixture_of(f, g);
  const int rows = f->row_start[g + 1] - f->row_start[g];
  if (m == NULL) {
    return BASE_OK;
  }
  if (m->rows != rows || m->stored < 1 || m->stored > LCP_STORED_MAX || rows > LCP_MIXED_ROWS ||
      rows * cols > LCP_MIXED_MAX) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "group %d: need a mixture of its %d rows, at most %d of 12 numbers, of 1..%d",
                     g, rows, (int)LCP_MIXED_ROWS, (int)LCP_STORED_MAX);
  }
  return check_values(m->c, (size_t)m->rows * (size_t)m->stored, "a mixture", err);
}

static base_status check_group(const lcp_factored *f, int g, base_error *err) {
  const int rows = f->row_start[g + 1] - f->row_start[g];
  int cols = 0;
  for (int side = 0; side < 2; side++) {
    const int b = f->body[2 * g + side];
    if (b < -1 || b >= f->n_body || (side == 1 && b >= 0 && b == f->body[2 * g])) {
      return BASE_FAIL(err, BASE_EINVAL, "group %d touches body %d: need two different of -1..%d",
                       g, b, f->n_body - 1);
    }
    cols += (b >= 0) ? f->dof_start[b + 1] - f->dof_start[b] : 0;
  }
  if (rows < 1 || f->jac_start[g + 1] - f->jac_start[g] != rows * cols) {
    return BASE_FAIL(err, BASE_EINVAL, "group %d: need %d x %d Jacobian entries", g, rows, cols);
  }
  BASE_TRY(check_mixture(f, g, cols, err));
  if (f->stored_start == NULL) {
    return BASE_OK; /* all of J at once */
  }
  return check_values(f->jac + lcp_factored_at(f, g),
                      (size_t)lcp_factored_stored(f, g) * (size_t)cols, "J", err);
}

static base_status check_factored(const lcp_factored *f, int n, base_error *err) {
  if (f == NULL || f->n_body < 0 || f->n_group < 0 || (f->n_group > 0 && f->body == NULL)) {
    return BASE_FAIL(err, BASE_EINVAL, "factored matrix: missing parts or negative counts");
  }
  BASE_TRY(check_offsets(f->dof_start, f->n_body, "dof_start", err));
  BASE_TRY(check_offsets(f->weight_start, f->n_body, "weight_start", err));
  BASE_TRY(check_offsets(f->row_start, f->n_group, "row_start", err));
  BASE_TRY(check_offsets(f->jac_start, f->n_group, "jac_start", err));
  if (f->row_start[f->n_group] != n) {
    return BASE_FAIL(err, BASE_EINVAL, "factored matrix: groups cover rows %d..%d, need 0..%d",
                     f->row_start[0], f->row_start[f->n_group], n);
  }
  BASE_TRY(check_bodies(f, err));
  for (int g = 0; g < f->n_group; g++) {
    BASE_TRY(check_group(f, g, err));
  }
  if (f->mixture != NULL && f->stored_start == NULL) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "factored matrix: mixed rows, but not where they are stored");
  }
  if (f->stored_start == NULL) {
    BASE_TRY(check_values(f->jac, (size_t)f->jac_start[f->n_group], "J", err));
  }
  return (f->shift != NULL) ? check_csc(f->shift, n, "S", err) : BASE_OK;
}

static base_status check_cone(const lcp_block *b, int k, base_error *err) {
  int size = 1;
  if (b->n_part < 0 || b->n_part > LCP_PARTS_MAX) {
    return BASE_FAIL(err, BASE_EINVAL, "cone block %d has %d parts: need 0..%d", k, b->n_part,
                     LCP_PARTS_MAX);
  }
  for (int i = 0; i < b->n_part; i++) {
    size += b->part_dim[i];
    if (b->part_dim[i] < 1 || b->part_dim[i] > 2 || !(b->part_mu[i] >= 0.0) ||
        !isfinite(b->part_mu[i])) {
      return BASE_FAIL(err, BASE_EINVAL,
                       "cone block %d part %d: need 1 or 2 rows and a coefficient >= 0, not %d, %g",
                       k, i, b->part_dim[i], b->part_mu[i]);
    }
  }
  if (size != b->size) {
    return BASE_FAIL(err, BASE_EINVAL, "cone block %d has %d rows: its parts need %d", k, b->size,
                     size);
  }
  return BASE_OK;
}

static base_status check_box(const lcp_problem *p, const lcp_block *b, base_error *err) {
  for (int i = b->start; i < b->start + b->size; i++) {
    if (p->lo == NULL || p->hi == NULL || !(p->lo[i] <= p->hi[i]) || p->lo[i] == HUGE_VAL ||
        p->hi[i] == -HUGE_VAL) {
      return BASE_FAIL(err, BASE_EINVAL, "box row %d: need lo <= hi", i);
    }
  }
  return BASE_OK;
}

static base_status check_blocks(const lcp_problem *p, base_error *err) {
  int next = 0;
  for (int k = 0; p->block != NULL && k < p->n_block; k++) {
    const lcp_block *b = &p->block[k];
    if (b->start != next || b->size < 1 || b->size > p->M.n - next) {
      return BASE_FAIL(err, BASE_EINVAL, "block %d covers rows %d..%d: need to start at %d", k,
                       b->start, b->start + b->size, next);
    }
    next += b->size;
    if (b->set == LCP_CONE) {
      BASE_TRY(check_cone(b, k, err));
    } else if (b->set == LCP_BOX) {
      BASE_TRY(check_box(p, b, err));
    } else if (b->set != LCP_ORTHANT && b->set != LCP_FREE) {
      return BASE_FAIL(err, BASE_EINVAL, "block %d: unknown set %d", k, (int)b->set);
    }
  }
  if (p->block != NULL && next != p->M.n) {
    return BASE_FAIL(err, BASE_EINVAL, "blocks cover %d rows of %d", next, p->M.n);
  }
  return BASE_OK;
}

base_status lcp_problem_check(const lcp_problem *p, base_error *err) {
  const lcp_matrix *M = &p->M;
  if (M->n < 0) {
    return BASE_FAIL(err, BASE_EINVAL, "size n=%d: need n >= 0", M->n);
  }
  if (M->n == 0) {
    return BASE_OK;
  }
  switch (M->storage) {
  case LCP_DENSE:
    if (M->n > 46340) { /* n*n is counted in an int */
      return BASE_FAIL(err, BASE_EINVAL, "size n=%d: too large for dense storage", M->n);
    }
    BASE_TRY(check_values(M->val, (size_t)M->n * (size_t)M->n, "M", err));
    break;
  case LCP_CSC:
    BASE_TRY(check_csc(&M->csc, M->n, "M", err));
    break;
  case LCP_FACTORED:
    BASE_TRY(check_factored(M->factored, M->n, err));
    break;
  default:
    return BASE_FAIL(err, BASE_EINVAL, "M: unknown storage %d", (int)M->storage);
  }
  BASE_TRY(check_values(p->q, (size_t)M->n, "q", err));
  return check_blocks(p, err);
}

bool lcp_problem_is_shaped(const lcp_problem *p) {
  const lcp_csc *m = NULL;
  if (p->M.storage == LCP_CSC) {
    m = &p->M.csc;
  } else if (p->M.storage == LCP_FACTORED) {
    const lcp_factored *f = p->M.factored;
    m = f->shift;
    if (f->row_start[f->n_group] != p->M.n) {
      return false;
    }
  }
  if (p->M.n > 0 && m != NULL &&
      (m->n_row != p->M.n || m->n_col != p->M.n || !lcp_csc_is_sorted(m))) {
    return false;
  }
  int next = 0;
  for (int k = 0; p->block != NULL && k < p->n_block; k++) {
    if (p->block[k].start != next || p->block[k].size < 1) {
      return false;
    }
    next += p->block[k].size;
  }
  return p->block == NULL || next == p->M.n;
}

unsigned lcp_problem_sets(const lcp_problem *p) {
  unsigned sets = (p->block == NULL && p->M.n > 0) ? 1u << LCP_ORTHANT : 0u;
  for (int k = 0; p->block != NULL && k < p->n_block; k++) {
    sets |= 1u << p->block[k].set;
  }
  return sets;
}

int lcp_block_folded(const lcp_block *b) {
  int size = b->size;
  for (int k = 0; b->set == LCP_ORTHANT && k < b->n_part; k++) {
    size -= b->part_dim[k] + 1 - ((b->part_dim[k] > 2) ? 2 : 1);
  }
  return size;
}

/* Of a matrix in factors; a block that is no part of one group does not fold. */
static void count_folded(const lcp_problem *p, lcp_capacity *c) {
  const lcp_factored *f = p->M.factored;
  for (int k = 0, g = 0; k < c->n_block; k++) {
    const lcp_block *b = &p->block[k];
    const int less = b->size - lcp_block_folded(b);
    while (less > 0 && f->row_start[g + 1] <= b->start) {
      g++;
    }
    if (less > 0 && b->start + b->size > f->row_start[g + 1]) {
      c->n_folded = c->n;
      c->n_jac_folded = c->n_jac;
      return;
    }
    if (less > 0) {
      const int rows = f->row_start[g + 1] - f->row_start[g];
      c->n_folded -= less;
      c->n_jac_folded -= less * ((f->jac_start[g + 1] - f->jac_start[g]) / rows);
    }
  }
}

lcp_capacity lcp_problem_capacity(const lcp_problem *p) {
  const lcp_matrix *M = &p->M;
  lcp_capacity c = {.n = M->n, .n_block = (p->block != NULL) ? p->n_block : 0};
  if (M->storage == LCP_DENSE) {
    c.nnz = (M->n <= 46340) ? M->n * M->n : INT_MAX; /* 46340^2 is the last square below 2^31 */
  } else if (M->storage == LCP_CSC) {
    c.nnz = (M->n > 0) ? M->csc.colptr[M->n] : 0;
  } else {
    const lcp_factored *f = M->factored;
    c.nnz = (f->shift != NULL) ? f->shift->colptr[M->n] : 0;
    c.n_body = f->n_body;
    c.n_dof = f->dof_start[f->n_body];
    c.n_jac = f->jac_start[f->n_group];
    c.n_weight = f->weight_start[f->n_body];
  }
  c.n_folded = c.n;
  c.n_jac_folded = c.n_jac;
  if (M->storage == LCP_FACTORED) {
    count_folded(p, &c);
  }
  return c;
}

bool lcp_capacity_holds(const lcp_capacity *c, const lcp_capacity *need) {
  return need->n <= c->n && need->n_block <= c->n_block && need->nnz <= c->nnz &&
         need->n_body <= c->n_body && need->n_dof <= c->n_dof && need->n_jac <= c->n_jac &&
         need->n_weight <= c->n_weight && need->n_folded <= c->n_folded &&
         need->n_jac_folded <= c->n_jac_folded;
}
