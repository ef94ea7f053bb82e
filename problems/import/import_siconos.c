/* Friction problems in the text format of Siconos (FIELD E): rows a contact, contacts, then for a
 * local problem W, q, mu; for a global one M, H, q, b, mu; mu_r behind mu with rolling. A matrix is
 * dense (0), block-sparse (1) or CSparse' printout (2). Whether a problem is global shows in the
 * size of its first matrix. */
#include "lcp/io/lcp_text.h"
#include "problems/families/triplets.h"
#include "problems/import/friction_problem.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIZE_MAX_ROWS = 20000000 };

static base_status read_reals(lcp_text *t, const char *what, size_t n, double **out,
                              base_error *err) {
  BASE_TRY(lcp_text_holds(t, (double)n, what, err));
  *out = malloc((n + 1) * sizeof **out);
  if (*out == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for %zu numbers", t->path, n);
  }
  for (size_t i = 0; i < n; i++) {
    BASE_TRY(lcp_text_real(t, what, &(*out)[i], err));
  }
  return BASE_OK;
}

/* ---- dense ---------------------------------------------------------------------------------- */

static base_status read_dense(lcp_text *t, triplets *e, int n_row, int n_col, base_error *err) {
  long again;
  BASE_TRY(lcp_text_int(t, "the number of rows", n_row, n_row, &again, err));
  BASE_TRY(lcp_text_int(t, "the number of columns", n_col, n_col, &again, err));
  const double count = (double)n_row * n_col;
  BASE_TRY(lcp_text_holds(t, count, "the matrix", err));
  BASE_TRY(triplets_open(e, n_row, n_col, (int)count, err));
  for (int j = 0; j < n_col; j++) {
    for (int i = 0; i < n_row; i++) {
      double x;
      BASE_TRY(lcp_text_real(t, "an entry of the matrix", &x, err));
      triplets_add(e, i, j, x);
    }
  }
  return BASE_OK;
}

/* ---- block-sparse --------------------------------------------------------------------------- */

typedef struct block_index {
  long n_block, n_block_row, n_block_col, filled1, filled2;
  int *row_end, *col_end, *start, *column; /* cumulative sizes; compressed block rows */
} block_index;

static void free_index(block_index *b) {
  free(b->row_end);
  free(b->col_end);
  free(b->start);
  free(b->column);
}

/* `n` integers in [lo, hi], not decreasing where asked. */
static base_status read_ints(lcp_text *t, const char *what, long n, long lo, long hi, bool ordered,
                             int **out, base_error *err) {
  BASE_TRY(lcp_text_holds(t, (double)n, what, err));
  *out = malloc(((size_t)n + 1) * sizeof **out);
  if (*out == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for %ld numbers", t->path, n);
  }
  for (long i = 0; i < n; i++) {
    long x;
    BASE_TRY(lcp_text_int(t, what, lo, hi, &x, err));
    (*out)[i] = (int)x;
    lo = ordered ? x : lo;
  }
  return BASE_OK;
}

static base_status read_index(lcp_text *t, block_index *b, int n_row, int n_col, base_error *err) {
  BASE_TRY(lcp_text_int(t, "the number of blocks", 0, 1L << 30, &b->n_block, err));
  BASE_TRY(lcp_text_int(t, "the number of block rows", 1, n_row, &b->n_block_row, err));
  BASE_TRY(lcp_text_int(t, "the number of block columns", 1, n_col, &b->n_block_col, err));
  BASE_TRY(
      read_ints(t, "the end of a block row", b->n_block_row, 1, n_row, true, &b->row_end, err));
  BASE_TRY(
      read_ints(t, "the end of a block column", b->n_block_col, 1, n_col, true, &b->col_end, err));
  if (b->row_end[b->n_block_row - 1] != n_row || b->col_end[b->n_block_col - 1] != n_col) {
    return BASE_FAIL(err, BASE_EINVAL, "%s:%ld: block rows and columns end before the matrix does",
                     t->path, t->line);
  }
  BASE_TRY(lcp_text_int(t, "the length of the row index", 1, b->n_block_row + 1, &b->filled1, err));
  BASE_TRY(
      lcp_text_int(t, "the number of stored blocks", b->n_block, b->n_block, &b->filled2, err));
  BASE_TRY(
      read_ints(t, "the start of a block row", b->filled1, 0, b->n_block, true, &b->start, err));
  if (b->start[0] != 0 || b->start[b->filled1 - 1] != b->n_block) {
    return BASE_FAIL(err, BASE_EINVAL, "%s:%ld: the row index must run from 0 to %ld", t->path,
                     t->line, b->n_block);
  }
  return read_ints(t, "a block's column", b->n_block, 0, b->n_block_col - 1, false, &b->column,
                   err);
}

static double count_entries(const block_index *b) {
  double count = 0.0;
  for (long r = 0; r + 1 < b->filled1; r++) {
    const int rows = b->row_end[r] - (r > 0 ? b->row_end[r - 1] : 0);
    for (int k = b->start[r]; k < b->start[r + 1]; k++) {
      const int c = b->column[k];
      count += (double)rows * (b->col_end[c] - (c > 0 ? b->col_end[c - 1] : 0));
    }
  }
  return count;
}

static base_status read_block(lcp_text *t, const block_index *b, long r, int k, triplets *e,
                              base_error *err) {
  const int c = b->column[k];
  const int row0 = (r > 0) ? b->row_end[r - 1] : 0, col0 = (c > 0) ? b->col_end[c - 1] : 0;
  long number;
  BASE_TRY(lcp_text_int(t, "the number of a block", k, k, &number, err));
  for (int j = col0; j < b->col_end[c]; j++) {
    for (int i = row0; i < b->row_end[r]; i++) {
      double x;
      BASE_TRY(lcp_text_real(t, "an entry of a block", &x, err));
      triplets_add(e, i, j, x);
    }
  }
  return BASE_OK;
}

static base_status read_blocks(lcp_text *t, triplets *e, int n_row, int n_col, base_error *err) {
  block_index b = {0};
  base_status s = read_index(t, &b, n_row, n_col, err);
  if (s == BASE_OK) {
    const double count = count_entries(&b);
    s = lcp_text_holds(t, count, "the blocks", err);
    if (s == BASE_OK) {
      s = triplets_open(e, n_row, n_col, (int)count, err);
    }
  }
  for (long r = 0; s == BASE_OK && r + 1 < b.filled1; r++) {
    for (int k = b.start[r]; s == BASE_OK && k < b.start[r + 1]; k++) {
      s = read_block(t, &b, r, k, e, err);
    }
  }
  free_index(&b);
  return s;
}

/* ---- CSparse' printout ---------------------------------------------------------------------- */

static base_status expect(lcp_text *t, const char *word, base_error *err) {
  char got[64];
  lcp_text_peek(t, got);
  if (strcmp(got, word) != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%s:%ld: need '%s', has '%s'", t->path, t->line, word, got);
  }
  t->at = strstr(t->at, word) + strlen(word);
  return BASE_OK;
}

/* "i j : x" */
static base_status read_triplet_lines(lcp_text *t, triplets *e, int nnz, base_error *err) {
  for (int k = 0; k < nnz; k++) {
    long i, j;
    double x;
    BASE_TRY(lcp_text_int(t, "a row", 0, e->n_row - 1, &i, err));
    BASE_TRY(lcp_text_int(t, "a column", 0, e->n_col - 1, &j, err));
    BASE_TRY(expect(t, ":", err));
    BASE_TRY(lcp_text_real(t, "an entry", &x, err));
    triplets_add(e, (int)i, (int)j, x);
  }
  return BASE_OK;
}

/* "col j : locations a to b", then "i : x" for each of them. */
static base_status read_column_lines(lcp_text *t, triplets *e, int nnz, base_error *err) {
  long seen = 0;
  for (int j = 0; j < e->n_col; j++) {
    long number, first, last;
    BASE_TRY(expect(t, "col", err));
    BASE_TRY(lcp_text_int(t, "a column", j, j, &number, err));
    BASE_TRY(expect(t, ":", err));
    BASE_TRY(expect(t, "locations", err));
    BASE_TRY(lcp_text_int(t, "the first location", seen, seen, &first, err));
    BASE_TRY(expect(t, "to", err));
    BASE_TRY(lcp_text_int(t, "the last location", seen - 1, nnz - 1, &last, err));
    for (; seen <= last; seen++) {
      long i;
      double x;
      BASE_TRY(lcp_text_int(t, "a row", 0, e->n_row - 1, &i, err));
      BASE_TRY(expect(t, ":", err));
      BASE_TRY(lcp_text_real(t, "an entry", &x, err));
      triplets_add(e, (int)i, j, x);
    }
  }
  return BASE_OK;
}

static base_status read_csparse(lcp_text *t, triplets *e, int n_row, int n_col, base_error *err) {
  long origin;
  int rows = 0, cols = 0, nzmax = 0, nnz = -1;
  BASE_TRY(lcp_text_int(t, "the kind of sparse matrix", 0, 3, &origin, err));
  lcp_text_skip_line(t);
  if (strncmp(t->at, "CSparse", 7) != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%s:%ld: need the line of CSparse", t->path, t->line);
  }
  lcp_text_skip_line(t);
  const bool triplet = strncmp(t->at, "triplet: ", 9) == 0;
  const int got = /* NOLINTNEXTLINE(cert-err34-c): every count is checked below */
      sscanf(t->at + (triplet ? 9 : 0), "%d-by-%d, nzmax: %d nnz: %d", &rows, &cols, &nzmax, &nnz);
  if (got != 4 || rows != n_row || cols != n_col || nnz < 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%s:%ld: need '%d-by-%d, nzmax: N nnz: N'", t->path, t->line,
                     n_row, n_col);
  }
  lcp_text_skip_line(t);
  BASE_TRY(lcp_text_holds(t, 2.0 * nnz, "nnz", err));
  BASE_TRY(triplets_open(e, n_row, n_col, nnz, err));
  return triplet ? read_triplet_lines(t, e, nnz, err) : read_column_lines(t, e, nnz, err);
}

/* ---- the file ------------------------------------------------------------------------------- */

static base_status read_matrix(lcp_text *t, const char *what, lcp_csc *out, base_error *err) {
  long type, n_row, n_col;
  triplets e = {0};
  BASE_TRY(lcp_text_int(t, "the storage type", 0, 2, &type, err));
  BASE_TRY(lcp_text_int(t, what, 1, SIZE_MAX_ROWS, &n_row, err));
  BASE_TRY(lcp_text_int(t, what, 1, SIZE_MAX_ROWS, &n_col, err));
  /* any storage needs at least one character a column or row in the file */
  BASE_TRY(lcp_text_holds(t, (double)(n_row > n_col ? n_row : n_col) / 2.0, what, err));
  base_status s = (type == 0)   ? read_dense(t, &e, (int)n_row, (int)n_col, err)
                  : (type == 1) ? read_blocks(t, &e, (int)n_row, (int)n_col, err)
                                : read_csparse(t, &e, (int)n_row, (int)n_col, err);
  if (s == BASE_OK) {
    s = triplets_to_csc(&e, out, err);
  }
  triplets_free(&e);
  return s;
}

static base_status read_problem(lcp_text *t, friction_problem *p, base_error *err) {
  long rows, nc;
  BASE_TRY(lcp_text_int(t, "the rows a contact", 2, 5, &rows, err));
  BASE_TRY(lcp_text_int(t, "the number of contacts", 1, SIZE_MAX_ROWS / 5, &nc, err));
  p->rows = (int)rows;
  p->n_contact = (int)nc;
  const size_t n = (size_t)rows * (size_t)nc;
  lcp_csc first = {0};
  const base_status s = read_matrix(t, "the size of the matrix", &first, err);
  p->global = (s == BASE_OK) && (size_t)first.n_col != n;
  *(p->global ? &p->M : &p->W) = first;
  BASE_TRY(s);
  if (p->global) {
    BASE_TRY(read_matrix(t, "the size of H", &p->H, err));
    BASE_TRY(read_reals(t, "an entry of q", (size_t)p->M.n_col, &p->f, err));
    BASE_TRY(read_reals(t, "an entry of b", n, &p->w, err));
  } else {
    BASE_TRY(read_reals(t, "an entry of q", n, &p->q, err));
  }
  BASE_TRY(read_reals(t, "an entry of mu", (size_t)nc, &p->mu, err));
  if (rows == 5) {
    BASE_TRY(read_reals(t, "an entry of mu_r", (size_t)nc, &p->mu_r, err));
  }
  return BASE_OK;
}

base_status friction_read_siconos(const char *path, friction_problem *out, base_error *err) {
  lcp_text t;
  base_error inner = {0};
  memset(out, 0, sizeof *out);
  BASE_TRY(lcp_text_open(&t, path, err));
  base_status s = read_problem(&t, out, err);
  lcp_text_close(&t);
  if (s == BASE_OK) {
    s = friction_check(out, &inner);
    if (s != BASE_OK) {
      (void)BASE_FAIL(err, s, "%s: %s", path, inner.text);
    }
  }
  if (s != BASE_OK) {
    friction_free(out);
  }
  return s;
}
