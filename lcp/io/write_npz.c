/* write_npz.c - problems as read_npz.c reads them and numpy.load does: M dense, or the parts of a scipy.sparse.csc_array; q;
 * lo and hi where not all unknowns are plain. */
#include "lcp/base/output.h"
#include "lcp/io/lcp_read.h"
#include "lcp/io/zip_write.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

_Static_assert(sizeof(int) == 4, "the elements of indices and indptr are int32");

enum { HEAD = 128 }; /* of an array, a multiple of 64 as numpy writes it */

/* Array `name` of elements of a type of numpy, with the given shape ("(3,)"). */
static void put(lcp_zip_out *z, const char *name, const char *type, const char *shape, bool fortran,
                const void *data, size_t n_data) {
  char head[HEAD], file[LCP_ZIP_NAME], words[HEAD];
  const int n = snprintf(words, sizeof words, "{'descr': '%s', 'fortran_order': %s, 'shape': %s, }",
                         type, fortran ? "True" : "False", shape);
  memset(head, ' ', sizeof head);
  memcpy(head, "\x93NUMPY\x01\x00", 8);
  head[8] = HEAD - 10;
  head[9] = 0;
  memcpy(head + 10, words, (size_t)n);
  head[HEAD - 1] = '\n';
  (void)snprintf(file, sizeof file, "%s.npy", name);
  lcp_zip_put(z, file, head, sizeof head, data, n_data);
}

static void put_reals(lcp_zip_out *z, const char *name, const double *x, int n) {
  char shape[32];
  (void)snprintf(shape, sizeof shape, "(%d,)", n);
  put(z, name, "<f8", shape, false, x, (size_t)n * sizeof *x);
}

static void put_ints(lcp_zip_out *z, const char *name, const int *x, int n) {
  char shape[32];
  (void)snprintf(shape, sizeof shape, "(%d,)", n);
  put(z, name, "<i4", shape, false, x, (size_t)n * sizeof *x);
}

static base_status put_matrix(lcp_zip_out *z, const lcp_matrix *M, base_error *err) {
  if (M->storage == LCP_DENSE) {
    char shape[32];
    (void)snprintf(shape, sizeof shape, "(%d, %d)", M->n, M->n);
    put(z, "M", "<f8", shape, true, M->val, (size_t)M->n * (size_t)M->n * sizeof *M->val);
    return BASE_OK;
  }
  lcp_csc m;
  BASE_TRY(lcp_matrix_to_csc(M, &m, err));
  const int nnz = m.colptr[m.n_col];
  put_reals(z, "data", m.val, nnz);
  put_ints(z, "indices", m.rowind, nnz);
  put_ints(z, "indptr", m.colptr, m.n_col + 1);
  put_ints(z, "shape", (const int[2]){m.n_row, m.n_col}, 2);
  put(z, "format", "|S3", "()", false, "csc", 3);
  lcp_csc_free(&m);
  return BASE_OK;
}

/* Bounds of unknown i, which is in block b. */
static void bounds(const lcp_problem *p, const lcp_block *b, int i, double *lo, double *hi) {
  *lo = (b->set == LCP_BOX) ? p->lo[i] : (b->set == LCP_FREE) ? -HUGE_VAL : 0.0;
  *hi = (b->set == LCP_BOX) ? p->hi[i] : HUGE_VAL;
}

static base_status put_bounds(lcp_zip_out *z, const lcp_problem *p, base_error *err) {
  const int n = p->M.n;
  double *lo = malloc(2 * ((size_t)n + 1) * sizeof *lo);
  if (lo == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%.300s: no memory for %d bounds", z->path, n);
  }
  double *hi = lo + n;
  for (int k = 0; k < p->n_block; k++) {
    const lcp_block *b = &p->block[k];
    for (int i = b->start; i < b->start + b->size; i++) {
      bounds(p, b, i, &lo[i], &hi[i]);
    }
  }
  put_reals(z, "lo", lo, n);
  put_reals(z, "hi", hi, n);
  free(lo);
  return BASE_OK;
}

static base_status write_arrays(lcp_zip_out *z, const lcp_problem *p, base_error *err) {
  BASE_TRY(put_matrix(z, &p->M, err));
  put_reals(z, "q", p->q, p->M.n);
  if (lcp_problem_sets(p) != 1u << LCP_ORTHANT) {
    BASE_TRY(put_bounds(z, p, err));
  }
  return lcp_zip_end(z, err);
}

base_status lcp_write_npz(const char *path, const lcp_problem *p, base_error *err) {
  base_out file;
  if ((lcp_problem_sets(p) & 1u << LCP_CONE) != 0) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%.300s: .npz holds no cones", path);
  }
  BASE_TRY(base_out_open(&file, path, err));
  lcp_zip_out z = {.path = path, .to = file.to};
  return base_out_finish(&file, write_arrays(&z, p, err), err);
}
