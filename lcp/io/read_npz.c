/* read_npz.c - problems as numpy writes them: numpy.savez(FILE, M=M, q=q), or in the place of a dense M the parts of a
 * sparse one by the names of scipy.sparse.save_npz: data, indices, indptr, shape, format (csc, csr), or data, row, col,
 * shape, format (coo). lo and hi, both optional, bound z; infinities stand for no bound. */
#include "lcp/base/nearest.h"
#include "lcp/io/lcp_read.h"
#include "lcp/io/npy.h"
#include "lcp/io/triplets.h"
#include "lcp/io/zip.h"
#include "lcp/lcp_bounds.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum part {
  PART_M,
  PART_Q,
  PART_LO,
  PART_HI,
  PART_DATA,
  PART_INDICES,
  PART_INDPTR,
  PART_ROW,
  PART_COL,
  PART_SHAPE,
  PART_FORMAT,
  PARTS
} part;
static const char *const part_name[PARTS] = {"M",      "q",   "lo",  "hi",    "data",  "indices",
                                             "indptr", "row", "col", "shape", "format"};

typedef struct npz {
  lcp_zip zip;
  unsigned char *bytes[PARTS]; /* owned; NULL: not there */
  lcp_npy array[PARTS];
} npz;

static bool has(const npz *z, part p) {
  return z->bytes[p] != NULL;
}

static base_status unknown(const char *path, const char *name, base_error *err) {
  char hint[BASE_NEAREST_HINT];
  base_nearest near = base_nearest_to(name, strlen(name));
  for (int p = 0; p < PARTS; p++) {
    base_nearest_offer(&near, part_name[p]);
  }
  return BASE_FAIL(err, BASE_EINVAL,
                   "%.300s: %s: need M (or the parts of a sparse matrix), q, lo and hi%s", path,
                   name, base_nearest_hint(&near, hint));
}

static base_status take_file(npz *z, int i, base_error *err) {
  char name[LCP_ZIP_NAME];
  (void)snprintf(name, sizeof name, "%s", z->zip.file[i].name);
  const size_t n = strlen(name);
  if (n > 4 && strcmp(name + n - 4, ".npy") == 0) {
    name[n - 4] = '\0';
  }
  int p = 0;
  while (p < PARTS && strcmp(part_name[p], name) != 0) {
    p++;
  }
  if (p == PARTS) {
    return unknown(z->zip.path, name, err);
  }
  if (has(z, (part)p)) {
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: %s stands twice", z->zip.path, name);
  }
  BASE_TRY(lcp_zip_read(&z->zip, i, &z->bytes[p], err));
  return lcp_npy_view(&z->array[p], z->zip.path, part_name[p], z->bytes[p], z->zip.file[i].size,
                      err);
}

static base_status need(const npz *z, part p, base_error *err) {
  return has(z, p) ? BASE_OK
                   : BASE_FAIL(err, BASE_EINVAL, "%.300s: has no %s", z->zip.path, part_name[p]);
}

/* Also a column or a row: n elements. */
static base_status read_vector(const npz *z, part p, int n, lcp_file_problem *out,
                               const double **to, base_error *err) {
  const lcp_npy *a = &z->array[p];
  if (a->n_dim > 2 || a->count != (size_t)n ||
      (a->n_dim == 2 && a->shape[0] != 1 && a->shape[1] != 1)) {
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: %s: has %zu elements, need a vector of %d",
                     z->zip.path, a->name, a->count, n);
  }
  double *x = malloc(((size_t)n + 1) * sizeof *x);
  BASE_TRY(lcp_file_own(out, x, z->zip.path, err));
  for (int i = 0; i < n; i++) {
    BASE_TRY(lcp_npy_real(a, (size_t)i, &x[i], err));
  }
  *to = x;
  return BASE_OK;
}

static base_status read_dense(const npz *z, lcp_file_problem *out, base_error *err) {
  const lcp_npy *a = &z->array[PART_M];
  if (a->n_dim != 2 || a->shape[0] != a->shape[1]) {
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: M: need a square matrix", z->zip.path);
  }
  const size_t n = (size_t)a->shape[0];
  double *M = malloc((n * n + 1) * sizeof *M);
  BASE_TRY(lcp_file_own(out, M, z->zip.path, err));
  for (size_t k = 0; k < n * n; k++) { /* numpy's rows come first */
    BASE_TRY(lcp_npy_real(a, k, &M[a->fortran ? k : k % n * n + k / n], err));
  }
  out->p.M = (lcp_matrix){.storage = LCP_DENSE, .n = (int)n, .val = M};
  return BASE_OK;
}

/* Columns (or, of csr, rows) of compressed entries. */
static base_status read_compressed(const npz *z, bool rows, int n, lcp_triplet *e,
                                   base_error *err) {
  const int nnz = (int)z->array[PART_DATA].count;
  BASE_TRY(need(z, PART_INDICES, err));
  BASE_TRY(need(z, PART_INDPTR, err));
  if (z->array[PART_INDICES].count != (size_t)nnz || z->array[PART_INDPTR].count != (size_t)n + 1) {
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: indices and indptr do not fit data and shape",
                     z->zip.path);
  }
  int from;
  BASE_TRY(lcp_npy_int(&z->array[PART_INDPTR], 0, 0, 0, &from, err));
  for (int j = 0; j < n; j++) {
    int to;
    BASE_TRY(lcp_npy_int(&z->array[PART_INDPTR], (size_t)j + 1, from, nnz, &to, err));
    for (int k = from; k < to; k++) {
      int i;
      BASE_TRY(lcp_npy_int(&z->array[PART_INDICES], (size_t)k, 0, n - 1, &i, err));
      e[k] = rows ? (lcp_triplet){.row = j, .col = i} : (lcp_triplet){.row = i, .col = j};
    }
    from = to;
  }
  return (from == nnz) ? BASE_OK
                       : BASE_FAIL(err, BASE_EINVAL, "%.300s: indptr ends at %d, need %d",
                                   z->zip.path, from, nnz);
}

static base_status read_coordinates(const npz *z, int n, lcp_triplet *e, base_error *err) {
  const size_t nnz = z->array[PART_DATA].count;
  BASE_TRY(need(z, PART_ROW, err));
  BASE_TRY(need(z, PART_COL, err));
  if (z->array[PART_ROW].count != nnz || z->array[PART_COL].count != nnz) {
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: row and col do not fit data", z->zip.path);
  }
  for (size_t k = 0; k < nnz; k++) {
    BASE_TRY(lcp_npy_int(&z->array[PART_ROW], k, 0, n - 1, &e[k].row, err));
    BASE_TRY(lcp_npy_int(&z->array[PART_COL], k, 0, n - 1, &e[k].col, err));
  }
  return BASE_OK;
}

static base_status read_entries(const npz *z, int n, const char *format, lcp_triplet *e,
                                base_error *err) {
  const bool rows = strcmp(format, "csr") == 0;
  if (rows || strcmp(format, "csc") == 0) {
    BASE_TRY(read_compressed(z, rows, n, e, err));
  } else if (strcmp(format, "coo") == 0) {
    BASE_TRY(read_coordinates(z, n, e, err));
  } else {
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: format %s: need csc, csr or coo", z->zip.path,
                     format);
  }
  for (size_t k = 0; k < z->array[PART_DATA].count; k++) {
    BASE_TRY(lcp_npy_real(&z->array[PART_DATA], k, &e[k].value, err));
  }
  return BASE_OK;
}

static base_status read_sparse(const npz *z, lcp_file_problem *out, base_error *err) {
  char format[16];
  int n[2];
  BASE_TRY(need(z, PART_DATA, err));
  BASE_TRY(need(z, PART_SHAPE, err));
  BASE_TRY(need(z, PART_FORMAT, err));
  BASE_TRY(lcp_npy_text(&z->array[PART_FORMAT], format, sizeof format, err));
  if (z->array[PART_SHAPE].count != 2) {
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: shape: need two numbers", z->zip.path);
  }
  for (size_t k = 0; k < 2; k++) { /* q is there: n is no more than the file holds */
    BASE_TRY(lcp_npy_int(&z->array[PART_SHAPE], k, 0, (long)z->array[PART_Q].count, &n[k], err));
  }
  if (n[0] != n[1]) {
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: M is %d x %d: need a square matrix", z->zip.path,
                     n[0], n[1]);
  }
  const size_t nnz = z->array[PART_DATA].count;
  lcp_triplet *e = calloc(nnz + 1, sizeof *e);
  if (e == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%.300s: no memory for %zu entries", z->zip.path, nnz);
  }
  base_status done = read_entries(z, n[0], format, e, err);
  if (done == BASE_OK) {
    done = lcp_from_triplets(z->zip.path, n[0], e, nnz, out, err);
  }
  free(e);
  return done;
}

/* Without bounds the problem is the plain LCP, one orthant. */
static base_status read_bounds(const npz *z, lcp_file_problem *out, base_error *err) {
  const int n = out->p.M.n;
  if (!has(z, PART_LO) && !has(z, PART_HI)) {
    return BASE_OK;
  }
  double *dflt = malloc(((size_t)n + 1) * sizeof *dflt);
  BASE_TRY(lcp_file_own(out, dflt, z->zip.path, err));
  out->p.lo = dflt;
  out->p.hi = dflt;
  for (int i = 0; i < n; i++) {
    dflt[i] = has(z, PART_LO) ? HUGE_VAL : 0.0;
  }
  if (has(z, PART_LO)) {
    BASE_TRY(read_vector(z, PART_LO, n, out, &out->p.lo, err));
  }
  if (has(z, PART_HI)) {
    BASE_TRY(read_vector(z, PART_HI, n, out, &out->p.hi, err));
  }
  lcp_block *block = calloc((size_t)n + 1, sizeof *block);
  BASE_TRY(lcp_file_own(out, block, z->zip.path, err));
  const int count = lcp_bounds_blocks(n, out->p.lo, out->p.hi, block);
  const bool plain = count == 1 && block[0].set == LCP_ORTHANT;
  out->p.n_block = plain ? 0 : count;
  out->p.block = plain ? NULL : block;
  return BASE_OK;
}

static base_status read_problem(npz *z, lcp_file_problem *out, base_error *err) {
  base_error inner = {0};
  for (int i = 0; i < z->zip.n; i++) {
    BASE_TRY(take_file(z, i, err));
  }
  BASE_TRY(need(z, PART_Q, err));
  if (has(z, PART_M) == has(z, PART_DATA)) {
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: need M, or the parts of a sparse matrix",
                     z->zip.path);
  }
  BASE_TRY(has(z, PART_M) ? read_dense(z, out, err) : read_sparse(z, out, err));
  BASE_TRY(read_vector(z, PART_Q, out->p.M.n, out, &out->p.q, err));
  BASE_TRY(read_bounds(z, out, err));
  const base_status done = lcp_problem_check(&out->p, &inner);
  if (done != BASE_OK) {
    return BASE_FAIL(err, done, "%.300s: %s", z->zip.path, inner.text);
  }
  out->p.traits = lcp_matrix_is_symmetric(&out->p.M) ? LCP_SYMMETRIC : 0u;
  return BASE_OK;
}

base_status lcp_read_npz(const char *path, lcp_file_problem *out, base_error *err) {
  npz z = {.zip = {.path = path}};
  *out = (lcp_file_problem){0};
  BASE_TRY(lcp_zip_open(&z.zip, path, err));
  const base_status done = read_problem(&z, out, err);
  for (int p = 0; p < PARTS; p++) {
    free(z.bytes[p]);
  }
  lcp_zip_close(&z.zip);
  if (done != BASE_OK) {
    lcp_file_problem_free(out);
  }
  return done;
}
