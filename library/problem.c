/* problem.c - problems of the C library: copies of plain arrays, checked as they come in. */
#include "lcp/lcp_solver.h"
#include "library/library.h"

#include <stdlib.h>
#include <string.h>

static library_problem *own(lcp_problem *p) {
  return (library_problem *)p;
}

static base_status allocate(library_problem *o, int n, size_t entries, base_error *err) {
  const size_t rows = (size_t)n;
  o->val = base_alloc((entries + 1) * sizeof *o->val);
  o->q = base_alloc(rows * sizeof *o->q);
  o->lo = base_alloc(rows * sizeof *o->lo);
  o->hi = base_alloc(rows * sizeof *o->hi);
  o->block = malloc(rows * sizeof *o->block);
  if (o->val == NULL || o->q == NULL || o->lo == NULL || o->hi == NULL || o->block == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for a problem with n=%d", n);
  }
  for (int i = 0; i < n; i++) {
    o->lo[i] = 0.0;
    o->hi[i] = HUGE_VAL;
  }
  o->p.q = o->q;
  return BASE_OK;
}

static void copy_dense(double *to, const double *from, size_t n, bool row_major) {
  for (size_t j = 0; j < n; j++) {
    for (size_t i = 0; i < n; i++) {
      to[j * n + i] = row_major ? from[i * n + j] : from[j * n + i];
    }
  }
}

static base_status fill_dense(library_problem *o, int n, const double *M, int row_major,
                              const double *q, base_error *err) {
  if (n < 1 || n > 46340) {
    return BASE_FAIL(err, BASE_EINVAL, "size n=%d: need 1 to 46340 of a dense matrix", n);
  }
  if (M == NULL || q == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: missing", M == NULL ? "M" : "q");
  }
  BASE_TRY(allocate(o, n, (size_t)n * (size_t)n, err));
  o->row_major = row_major != 0;
  copy_dense(o->val, M, (size_t)n, o->row_major);
  memcpy(o->q, q, (size_t)n * sizeof *q);
  o->p.M = (lcp_matrix){.storage = LCP_DENSE, .n = n, .val = o->val};
  return lcp_problem_check(&o->p, err);
}

static base_status fill_csc(library_problem *o, int n, const int *colptr, const int *rowind,
                            const double *val, const double *q, base_error *err) {
  if (n < 1 || colptr == NULL || q == NULL) {
    return BASE_FAIL(err, BASE_EINVAL, "%s",
                     n < 1 ? "size: need n >= 1" : "column pointers or q: missing");
  }
  for (int j = 0; j < n; j++) { /* before an entry is read */
    if (colptr[0] != 0 || colptr[j + 1] < colptr[j]) {
      return BASE_FAIL(err, BASE_EINVAL,
                       "column pointers: need offsets from 0 that do not decrease");
    }
  }
  const size_t entries = (size_t)colptr[n];
  if (entries > 0 && (rowind == NULL || val == NULL)) {
    return BASE_FAIL(err, BASE_EINVAL, "row indices or values: missing");
  }
  BASE_TRY(allocate(o, n, entries, err));
  o->colptr = malloc(((size_t)n + 1) * sizeof *o->colptr);
  o->rowind = malloc((entries + 1) * sizeof *o->rowind);
  if (o->colptr == NULL || o->rowind == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %zu entries", entries);
  }
  memcpy(o->colptr, colptr, ((size_t)n + 1) * sizeof *colptr);
  memcpy(o->q, q, (size_t)n * sizeof *q);
  if (entries > 0) {
    memcpy(o->rowind, rowind, entries * sizeof *rowind);
    memcpy(o->val, val, entries * sizeof *val);
  }
  o->p.M = (lcp_matrix){.storage = LCP_CSC, .n = n};
  o->p.M.csc = (lcp_csc){n, n, o->colptr, o->rowind, o->val};
  return lcp_problem_check(&o->p, err);
}

/* o as a handle where `done` is well, else NULL and the line is kept. */
static lcp_problem *handle(library_problem *o, base_status done, const base_error *err) {
  if (done == BASE_OK) {
    return &o->p;
  }
  (void)library_failed(err);
  lcp_problem_free(&o->p);
  return NULL;
}

static library_problem *empty(base_error *err) {
  library_problem *o = calloc(1, sizeof *o);
  if (o == NULL) {
    (void)BASE_FAIL(err, BASE_ENOMEM, "no memory for a problem");
    (void)library_failed(err);
  }
  return o;
}

lcp_problem *lcp_problem_dense(int n, const double *M, int row_major, const double *q) {
  base_error err = {0};
  library_problem *o = empty(&err);
  return (o == NULL) ? NULL : handle(o, fill_dense(o, n, M, row_major, q, &err), &err);
}

lcp_problem *lcp_problem_csc(int n, const int *colptr, const int *rowind, const double *val,
                             const double *q) {
  base_error err = {0};
  library_problem *o = empty(&err);
  return (o == NULL) ? NULL : handle(o, fill_csc(o, n, colptr, rowind, val, q, &err), &err);
}

/* ---- sets --------------------------------------------------------------------------------- */

static lcp_set set_of_row(double lo, double hi) {
  if (lo == 0.0 && hi == HUGE_VAL) {
    return LCP_ORTHANT;
  }
  return (lo == -HUGE_VAL && hi == HUGE_VAL) ? LCP_FREE : LCP_BOX;
}

/* Blocks of `o` with these bounds and cones: neighbours of one set are one block. */
static int make_blocks(lcp_block *block, int n, const double *lo, const double *hi,
                       const lcp_block *cone, int n_cone) {
  int count = 0, next = 0;
  for (int i = 0; i < n;) {
    if (next < n_cone && cone[next].start == i) {
      block[count++] = cone[next];
      i += cone[next++].size;
      continue;
    }
    const lcp_set set = set_of_row(lo[i], hi[i]);
    lcp_block *last = (count > 0) ? &block[count - 1] : NULL;
    if (last != NULL && last->set == set && set != LCP_CONE) {
      last->size++;
    } else {
      block[count++] = (lcp_block){.start = i, .size = 1, .set = set};
    }
    i++;
  }
  return count;
}

static void take_sets(library_problem *o) {
  o->p.lo = o->lo;
  o->p.hi = o->hi;
  o->p.n_block = make_blocks(o->block, o->p.M.n, o->lo, o->hi, o->cone, o->n_cone);
  const bool plain = o->p.n_block == 1 && o->block[0].set == LCP_ORTHANT;
  o->p.block = plain ? NULL : o->block;
  o->p.n_block = plain ? 0 : o->p.n_block;
}

int lcp_problem_set_bounds(lcp_problem *p, const double *lo, const double *hi) {
  library_problem *o = own(p);
  base_error err;
  for (int i = 0; i < p->M.n; i++) {
    const double a = (lo != NULL) ? lo[i] : 0.0, b = (hi != NULL) ? hi[i] : HUGE_VAL;
    if (!(a <= b) || a == HUGE_VAL || b == -HUGE_VAL) {
      (void)BASE_FAIL(&err, BASE_EINVAL, "row %d has bounds %g and %g: need lo <= hi", i, a, b);
      return library_failed(&err);
    }
  }
  for (int i = 0; i < p->M.n; i++) {
    o->lo[i] = (lo != NULL) ? lo[i] : 0.0;
    o->hi[i] = (hi != NULL) ? hi[i] : HUGE_VAL;
  }
  take_sets(o);
  return LCP_OK;
}

static base_status make_cones(lcp_block *cone, int n, int count, const int *start, const int *size,
                              const double *mu, base_error *err) {
  int next = 0;
  for (int k = 0; k < count; k++) {
    if (size[k] < 1 || size[k] > 3 || start[k] < next || start[k] > n - size[k]) {
      return BASE_FAIL(err, BASE_EINVAL,
                       "cone %d has %d rows from %d: need 1 to 3 of 0..%d behind those before", k,
                       size[k], start[k], n - 1);
    }
    if (!(mu[k] >= 0.0) || !isfinite(mu[k])) {
      return BASE_FAIL(err, BASE_EINVAL, "cone %d has mu %g: need mu >= 0", k, mu[k]);
    }
    cone[k] = (lcp_block){.start = start[k], .size = size[k], .set = LCP_CONE};
    if (size[k] > 1) {
      cone[k].n_part = 1;
      cone[k].part_dim[0] = size[k] - 1;
      cone[k].part_mu[0] = mu[k];
    }
    next = start[k] + size[k];
  }
  return BASE_OK;
}

int lcp_problem_set_cones(lcp_problem *p, int count, const int *start, const int *size,
                          const double *mu) {
  library_problem *o = own(p);
  base_error err;
  if (count < 0 || count > p->M.n || (count > 0 && (start == NULL || size == NULL || mu == NULL))) {
    (void)BASE_FAIL(&err, BASE_EINVAL, "%d cones: need 0 to %d, with start, size and mu", count,
                    p->M.n);
    return library_failed(&err);
  }
  lcp_block *cone = malloc(((size_t)count + 1) * sizeof *cone);
  if (cone == NULL) {
    (void)BASE_FAIL(&err, BASE_ENOMEM, "no memory for %d cones", count);
    return library_failed(&err);
  }
  if (make_cones(cone, p->M.n, count, start, size, mu, &err) != BASE_OK) {
    free(cone);
    return library_failed(&err);
  }
  free(o->cone);
  o->cone = cone;
  o->n_cone = count;
  take_sets(o);
  return LCP_OK;
}

/* ---- numbers ------------------------------------------------------------------------------ */

static int all_finite(const char *what, const double *x, size_t n) {
  base_error err;
  if (x == NULL) {
    (void)BASE_FAIL(&err, BASE_EINVAL, "%s: missing", what);
    return library_failed(&err);
  }
  for (size_t i = 0; i < n; i++) {
    if (!isfinite(x[i])) {
      (void)BASE_FAIL(&err, BASE_EINVAL, "%s[%zu] is %g: need finite numbers", what, i, x[i]);
      return library_failed(&err);
    }
  }
  return LCP_OK;
}

int lcp_problem_set_q(lcp_problem *p, const double *q) {
  const int code = all_finite("q", q, (size_t)p->M.n);
  if (code == LCP_OK) {
    memcpy(own(p)->q, q, (size_t)p->M.n * sizeof *q);
  }
  return code;
}

int lcp_problem_set_values(lcp_problem *p, const double *val) {
  library_problem *o = own(p);
  const size_t n = (size_t)p->M.n;
  const bool dense = p->M.storage == LCP_DENSE;
  const size_t entries = dense ? n * n : (size_t)o->colptr[n];
  const int code = all_finite("M", val, entries);
  if (code == LCP_OK && dense) {
    copy_dense(o->val, val, n, o->row_major);
  } else if (code == LCP_OK) {
    memcpy(o->val, val, entries * sizeof *val);
  }
  return code;
}

int lcp_problem_declare(lcp_problem *p, const char *trait) {
  const unsigned bit = lcp_trait_find(trait);
  if (bit == 0) {
    base_error err;
    (void)BASE_FAIL(&err, BASE_EINVAL, "trait '%.80s': unknown", trait);
    return library_failed(&err);
  }
  p->traits |= bit;
  return LCP_OK;
}

int lcp_problem_size(const lcp_problem *p) {
  return p->M.n;
}

int lcp_residual(const lcp_problem *p, const double *z, double *w) {
  lcp_matrix_apply(&p->M, z, p->q, w, NULL); /* dense and sparse need no scratch */
  return LCP_OK;
}

void lcp_problem_free(lcp_problem *p) {
  library_problem *o = own(p);
  if (o != NULL) {
    free(o->colptr);
    free(o->rowind);
    free(o->val);
    free(o->q);
    free(o->lo);
    free(o->hi);
    free(o->block);
    free(o->cone);
    free(o);
  }
}
