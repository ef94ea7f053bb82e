#include "lcp/lcp_certificate.h"

#include "lcp/base/output.h"
#include "lcp/io/lcp_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const kinds[] = {
    [LCP_CERT_NONE] = "none",
    [LCP_CERT_BASIS] = "basis",
    [LCP_CERT_FARKAS] = "farkas",
    [LCP_CERT_RAY] = "ray",
};

base_status lcp_certificate_write(const char *path, int n, const lcp_certificate *c,
                                  const double *z, base_error *err) {
  const bool basis = c->kind == LCP_CERT_BASIS;
  if (c->kind == LCP_CERT_NONE || (basis ? c->basis == NULL : c->vector == NULL)) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: the solver handed over no certificate", path);
  }
  base_out f;
  BASE_TRY(base_out_open(&f, path, err));
  (void)fprintf(f.to, "lcpbench certificate 1\nkind %s\nn %d\n", kinds[c->kind], n);
  for (int i = 0; i < n; i++) {
    if (basis) {
      (void)fprintf(f.to, "%d %d %.17g\n", i, c->basis[i] != 0, z[i]);
    } else {
      (void)fprintf(f.to, "%d %.17g\n", i, c->vector[i]);
    }
  }
  return base_out_close(&f, true, err);
}

/* The next word must be `want`. */
static base_status expect(lcp_text *t, const char *want, base_error *err) {
  char word[64];
  lcp_text_peek(t, word);
  if (strcmp(word, want) != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "%s:%ld: '%s': need '%s'", t->path, t->line, word, want);
  }
  t->at = strstr(t->at, word) + strlen(word);
  return BASE_OK;
}

static base_status read_kind(lcp_text *t, lcp_certificate_kind *kind, base_error *err) {
  char word[64];
  BASE_TRY(expect(t, "lcpbench", err));
  BASE_TRY(expect(t, "certificate", err));
  BASE_TRY(expect(t, "1", err));
  lcp_text_skip_line(t);
  BASE_TRY(expect(t, "kind", err));
  lcp_text_peek(t, word);
  for (int k = LCP_CERT_BASIS; k <= LCP_CERT_RAY; k++) {
    if (strcmp(word, kinds[k]) == 0) {
      *kind = (lcp_certificate_kind)k;
      lcp_text_skip_line(t);
      return BASE_OK;
    }
  }
  return BASE_FAIL(err, BASE_EINVAL, "%s:%ld: kind '%s': need basis, farkas or ray", t->path,
                   t->line, word);
}

static base_status read_rows(lcp_text *t, lcp_certificate_file *out, base_error *err) {
  for (int i = 0; i < out->n; i++) {
    long index;
    long basic;
    BASE_TRY(lcp_text_int(t, "the row number in order", i, i, &index, err));
    if (out->basis != NULL) {
      BASE_TRY(lcp_text_int(t, "basic, 0 or 1", 0, 1, &basic, err));
      out->basis[i] = (unsigned char)basic;
    }
    BASE_TRY(lcp_text_real(t, "an entry", &out->vector[i], err));
  }
  return BASE_OK;
}

static base_status read_all(lcp_text *t, lcp_certificate_file *out, base_error *err) {
  long n;
  BASE_TRY(read_kind(t, &out->kind, err));
  BASE_TRY(expect(t, "n", err));
  BASE_TRY(lcp_text_int(t, "the number of rows", 0, 100000000, &n, err));
  const bool basis = out->kind == LCP_CERT_BASIS;
  BASE_TRY(lcp_text_holds(t, (basis ? 3.0 : 2.0) * (double)n, "n", err));
  out->n = (int)n;
  out->vector = calloc((size_t)n + 1, sizeof *out->vector);
  out->basis = basis ? calloc((size_t)n + 1, sizeof *out->basis) : NULL;
  if (out->vector == NULL || (basis && out->basis == NULL)) {
    return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for %ld rows", t->path, n);
  }
  return read_rows(t, out, err);
}

base_status lcp_certificate_read(const char *path, lcp_certificate_file *out, base_error *err) {
  *out = (lcp_certificate_file){0};
  lcp_text t;
  BASE_TRY(lcp_text_open(&t, path, err));
  const base_status status = read_all(&t, out, err);
  lcp_text_close(&t);
  if (status != BASE_OK) {
    lcp_certificate_free(out);
  }
  return status;
}

void lcp_certificate_free(lcp_certificate_file *f) {
  free(f->basis);
  free(f->vector);
  *f = (lcp_certificate_file){0};
}
