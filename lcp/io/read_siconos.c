/* read_siconos.c - LCPs in the text format of Siconos: n, storage type, rows, columns, "n n", M
 * column by column, q, free remarks. */
#include "lcp/io/lcp_read.h"
#include "lcp/io/lcp_text.h"

#include <stdlib.h>

void lcp_file_problem_free(lcp_file_problem *f) {
  for (int i = 0; i < f->n_owned; i++) {
    free(f->owned[i]);
  }
  *f = (lcp_file_problem){0};
}

static base_status read_values(lcp_text *t, const char *what, double *x, size_t n,
                               base_error *err) {
  for (size_t i = 0; i < n; i++) {
    BASE_TRY(lcp_text_real(t, what, &x[i], err));
  }
  return BASE_OK;
}

static base_status read_dense(lcp_text *t, lcp_file_problem *out, base_error *err) {
  long n, type, rows, cols, again;
  BASE_TRY(lcp_text_int(t, "the size n", 1, 1000000, &n, err));
  BASE_TRY(lcp_text_int(t, "the storage type", 0, 0, &type, err));
  BASE_TRY(lcp_text_int(t, "the number of rows", n, n, &rows, err));
  BASE_TRY(lcp_text_int(t, "the number of columns", n, n, &cols, err));
  BASE_TRY(lcp_text_int(t, "the number of rows of M", n, n, &again, err));
  BASE_TRY(lcp_text_int(t, "the number of columns of M", n, n, &again, err));
  const double count = (double)n * (double)n + (double)n;
  BASE_TRY(lcp_text_holds(t, count, "n", err));
  double *M = malloc((size_t)n * (size_t)n * sizeof *M);
  double *q = malloc((size_t)n * sizeof *q);
  out->owned[0] = M;
  out->owned[1] = q;
  out->n_owned = 2;
  if (M == NULL || q == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for n=%ld", t->path, n);
  }
  BASE_TRY(read_values(t, "an entry of M", M, (size_t)n * (size_t)n, err));
  BASE_TRY(read_values(t, "an entry of q", q, (size_t)n, err));
  out->p = (lcp_problem){.M = {.storage = LCP_DENSE, .n = (int)n, .val = M}, .q = q};
  out->p.traits = lcp_matrix_is_symmetric(&out->p.M) ? LCP_SYMMETRIC : 0u;
  return lcp_problem_check(&out->p, err);
}

base_status lcp_read_siconos(const char *path, lcp_file_problem *out, base_error *err) {
  *out = (lcp_file_problem){0};
  lcp_text t;
  BASE_TRY(lcp_text_open(&t, path, err));
  const base_status s = read_dense(&t, out, err);
  lcp_text_close(&t);
  if (s != BASE_OK) {
    lcp_file_problem_free(out);
  }
  return s;
}
