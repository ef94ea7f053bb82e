/* read_mtx.c - Matrix Market files (Boisvert, Pozo & Remington 1996): real or integer, coordinate or
 * array, general, symmetric or skew-symmetric. Duplicate coordinate entries are refused. */
#include "lcp/base/output.h"
#include "lcp/io/lcp_read.h"
#include "lcp/io/lcp_text.h"
#include "lcp/io/triplets.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { EMPTY_ROWS = 1000000 }; /* a sparse file may name so many rows without filling them */

typedef struct header {
  bool array;
  int mirror; /* 0 general, 1 symmetric, -1 skew */
  long rows, cols, entries;
} header;

static base_status word(lcp_text *t, const char *const *allowed, int *index, base_error *err) {
  char w[64];
  lcp_text_peek(t, w);
  for (int i = 0; allowed[i] != NULL; i++) {
    if (strcasecmp(w, allowed[i]) == 0) {
      *index = i;
      t->at = strstr(t->at, w) + strlen(w);
      return BASE_OK;
    }
  }
  return BASE_FAIL(err, BASE_EINVAL, "%s:%ld: '%s' in the Matrix Market header: need %s%s%s",
                   t->path, t->line, w, allowed[0], allowed[1] != NULL ? " or " : "",
                   allowed[1] != NULL ? allowed[1] : "");
}

static base_status read_header(lcp_text *t, header *h, base_error *err) {
  static const char *const banner[] = {"%%MatrixMarket", NULL}, *const object[] = {"matrix", NULL},
                           *const format[] = {"coordinate", "array", NULL},
                           *const field[] = {"real", "integer", NULL},
                           *const symmetry[] = {"general", "symmetric", "skew-symmetric", NULL};
  int i;
  BASE_TRY(word(t, banner, &i, err));
  BASE_TRY(word(t, object, &i, err));
  BASE_TRY(word(t, format, &i, err));
  h->array = i == 1;
  BASE_TRY(word(t, field, &i, err));
  BASE_TRY(word(t, symmetry, &i, err));
  h->mirror = (i == 2) ? -1 : i;
  char w[64];
  for (lcp_text_skip_line(t), lcp_text_peek(t, w); w[0] == '%'; lcp_text_peek(t, w)) {
    t->at = strchr(t->at, '%');
    lcp_text_skip_line(t);
  }
  BASE_TRY(lcp_text_int(t, "the number of rows", 0, 100000000, &h->rows, err));
  BASE_TRY(lcp_text_int(t, "the number of columns", 0, 100000000, &h->cols, err));
  if (h->array) {
    h->entries = 0;
    const double all = (double)h->rows * (double)h->cols;
    const double diagonal = (double)h->mirror * (double)h->rows; /* + symmetric, - skew */
    return lcp_text_holds(t, (h->mirror == 0) ? all : (all + diagonal) / 2, "size", err);
  }
  BASE_TRY(lcp_text_int(t, "the number of entries", 0, 1000000000, &h->entries, err));
  if (h->rows > EMPTY_ROWS || h->cols > EMPTY_ROWS) { /* offsets of so many rows need a reason */
    BASE_TRY(lcp_text_holds(t, (double)h->rows + (double)h->cols, "size", err));
  }
  return lcp_text_holds(t, 3.0 * (double)h->entries, "size", err);
}

static base_status read_triplets(lcp_text *t, const header *h, lcp_triplet *e, size_t *count,
                                 base_error *err) {
  size_t n = 0;
  for (long k = 0; k < h->entries; k++) {
    long i, j;
    double x;
    BASE_TRY(lcp_text_int(t, "a row index", 1, h->rows, &i, err));
    BASE_TRY(lcp_text_int(t, "a column index", 1, h->cols, &j, err));
    BASE_TRY(lcp_text_real(t, "an entry", &x, err));
    e[n++] = (lcp_triplet){(int)i - 1, (int)j - 1, x};
    if (h->mirror != 0 && i != j) {
      e[n++] = (lcp_triplet){(int)j - 1, (int)i - 1, h->mirror * x};
    }
  }
  *count = n;
  return BASE_OK;
}

static base_status coordinate_matrix(lcp_text *t, const header *h, lcp_file_problem *out,
                                     base_error *err) {
  lcp_triplet *e = malloc((2 * (size_t)h->entries + 1) * sizeof *e);
  size_t nnz = 0;
  base_status s = (e != NULL) ? read_triplets(t, h, e, &nnz, err)
                              : BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for %ld entries",
                                          t->path, h->entries);
  if (s == BASE_OK) {
    s = lcp_from_triplets(t->path, (int)h->rows, e, nnz, out, err);
  }
  free(e);
  return s;
}

/* Array files list columns; symmetric ones only the lower triangle (skew: below the diagonal). */
static base_status array_values(lcp_text *t, const header *h, double *x, base_error *err) {
  for (long j = 0; j < h->cols; j++) {
    const long first = (h->mirror == 0) ? 0 : (h->mirror > 0 ? j : j + 1);
    for (long i = first; i < h->rows; i++) {
      double value;
      BASE_TRY(lcp_text_real(t, "an entry", &value, err));
      x[j * h->rows + i] = value;
      if (h->mirror != 0 && i != j) {
        x[i * h->rows + j] = h->mirror * value;
      }
    }
  }
  return BASE_OK;
}

static base_status array_matrix(lcp_text *t, const header *h, lcp_file_problem *out,
                                base_error *err) {
  double *M = calloc((size_t)h->rows * (size_t)h->cols + 1, sizeof *M);
  BASE_TRY(lcp_file_own(out, M, t->path, err));
  BASE_TRY(array_values(t, h, M, err));
  out->p.M = (lcp_matrix){.storage = LCP_DENSE, .n = (int)h->rows, .val = M};
  return BASE_OK;
}

/* More numbers than announced are as wrong as fewer. */
static base_status at_end(const lcp_text *t, base_error *err) {
  char w[64];
  lcp_text_peek(t, w);
  return (w[0] == '\0') ? BASE_OK
                        : BASE_FAIL(err, BASE_EINVAL, "%s:%ld: '%s' after the last entry", t->path,
                                    t->line, w);
}

static base_status read_matrix(lcp_text *t, lcp_file_problem *out, base_error *err) {
  header h;
  BASE_TRY(read_header(t, &h, err));
  if (h.rows != h.cols) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: M is %ld x %ld: need a square matrix", t->path, h.rows,
                     h.cols);
  }
  BASE_TRY(h.array ? array_matrix(t, &h, out, err) : coordinate_matrix(t, &h, out, err));
  out->p.traits = lcp_matrix_is_symmetric(&out->p.M) ? LCP_SYMMETRIC : 0u;
  return at_end(t, err);
}

static base_status vector_values(lcp_text *t, const header *h, double *x, base_error *err) {
  if (h->array) {
    return array_values(t, h, x, err);
  }
  for (long i = 0; i < h->rows; i++) {
    x[i] = (double)NAN; /* not given so far */
  }
  for (long k = 0; k < h->entries; k++) {
    long i, j;
    BASE_TRY(lcp_text_int(t, "a row index", 1, h->rows, &i, err));
    BASE_TRY(lcp_text_int(t, "a column index", 1, 1, &j, err));
    if (!isnan(x[i - 1])) {
      return BASE_FAIL(err, BASE_EINVAL, "%s: entry %ld stands twice", t->path, i);
    }
    BASE_TRY(lcp_text_real(t, "an entry", &x[i - 1], err));
  }
  for (long i = 0; i < h->rows; i++) {
    x[i] = isnan(x[i]) ? 0.0 : x[i];
  }
  return BASE_OK;
}

base_status lcp_read_mtx_vector(const char *path, int n, double *x, base_error *err) {
  lcp_text t;
  header h;
  BASE_TRY(lcp_text_open(&t, path, err));
  base_status s = read_header(&t, &h, err);
  if (s == BASE_OK && (h.rows != n || h.cols != 1 || h.mirror != 0)) {
    s = BASE_FAIL(err, BASE_EINVAL, "%s: is %ld x %ld: need a vector of %d", path, h.rows, h.cols,
                  n);
  }
  if (s == BASE_OK) {
    s = vector_values(&t, &h, x, err);
  }
  if (s == BASE_OK) {
    s = at_end(&t, err);
  }
  lcp_text_close(&t);
  return s;
}

base_status lcp_write_mtx_vector(const char *path, int n, const double *x, base_error *err) {
  base_out f;
  BASE_TRY(base_out_open(&f, path, err));
  (void)fprintf(f.to, "%%%%MatrixMarket matrix array real general\n%d 1\n", n);
  for (int i = 0; i < n; i++) {
    (void)fprintf(f.to, "%.17g\n", x[i]);
  }
  return base_out_close(&f, true, err);
}

static base_status read_q(const char *path, lcp_file_problem *out, base_error *err) {
  double *q = malloc(((size_t)out->p.M.n + 1) * sizeof *q);
  if (q == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for %d numbers", path, out->p.M.n);
  }
  out->owned[out->n_owned++] = q;
  out->p.q = q;
  BASE_TRY(lcp_read_mtx_vector(path, out->p.M.n, q, err));
  return lcp_problem_check(&out->p, err);
}

base_status lcp_read_mtx(const char *m_path, const char *q_path, lcp_file_problem *out,
                         base_error *err) {
  *out = (lcp_file_problem){0};
  lcp_text t;
  BASE_TRY(lcp_text_open(&t, m_path, err));
  base_status s = read_matrix(&t, out, err);
  lcp_text_close(&t);
  if (s == BASE_OK) {
    s = read_q(q_path, out, err);
  }
  if (s != BASE_OK) {
    lcp_file_problem_free(out);
  }
  return s;
}
