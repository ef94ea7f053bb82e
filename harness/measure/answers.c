#include "harness/measure/answers.h"

#include "lcp/base/input.h"

#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static const char magic[8] = {'L', 'C', 'P', 'B', 'A', 'N', 'S', '1'};

typedef struct head {
  int32_t n, word, n_proof;
} head;

static base_status io_failed(const char *path, base_error *err) {
  return BASE_FAIL(err, BASE_EIO, "%s: %s", path, errno != 0 ? strerror(errno) : "cut short");
}

/* ---- writing ----------------------------------------------------------------------------------*/

base_status answers_create(answers *a, const char *path, base_error *err) {
  *a = (answers){0};
  (void)snprintf(a->path, sizeof a->path, "%s", path);
  BASE_TRY(base_out_open(&a->write, path, err));
  errno = 0;
  if (fwrite(magic, sizeof magic, 1, a->write.to) != 1) {
    const base_status failed = io_failed(a->path, err);
    (void)answers_close(a, false, NULL);
    return failed;
  }
  return BASE_OK;
}

static bool write_sparse(FILE *to, const double *z, int n) {
  bool good = true;
  for (int i = 0; good && i < n; i += 8) {
    unsigned char bits = 0;
    for (int k = 0; k < 8 && i + k < n; k++) {
      bits |= (unsigned char)((z[i + k] != 0.0) ? 1u << k : 0u); /* NaN counts as not zero */
    }
    good = fputc(bits, to) != EOF;
  }
  for (int i = 0; good && i < n; i++) {
    good = z[i] == 0.0 || fwrite(&z[i], sizeof z[i], 1, to) == 1;
  }
  return good;
}

base_status answers_put_failure(answers *a, int n, base_status failed, base_error *err) {
  const head h = {n, -(int32_t)failed, 0};
  errno = 0;
  return (fwrite(&h, sizeof h, 1, a->write.to) == 1) ? BASE_OK : io_failed(a->path, err);
}

base_status answers_put(answers *a, int n, const double *z, const lcp_result *claim,
                        base_error *err) {
  const lcp_certificate *c = &claim->certificate;
  const bool proof = c->kind == LCP_CERT_FARKAS && c->vector != NULL;
  const head h = {n, (int32_t)claim->outcome, proof ? n : 0};
  errno = 0;
  bool good = fwrite(&h, sizeof h, 1, a->write.to) == 1 && write_sparse(a->write.to, z, n);
  good =
      good && (!proof || fwrite(c->vector, sizeof *c->vector, (size_t)n, a->write.to) == (size_t)n);
  return good ? BASE_OK : io_failed(a->path, err);
}

base_status answers_close(answers *a, bool keep, base_error *err) {
  if (a->file != NULL) {
    (void)fclose(a->file); /* only read */
  }
  free(a->proof);
  a->file = NULL;
  a->proof = NULL;
  return base_out_close(&a->write, keep, err);
}

/* ---- reading ----------------------------------------------------------------------------------*/

base_status answers_open(answers *a, const char *path, base_error *err) {
  char found[sizeof magic];
  *a = (answers){0};
  (void)snprintf(a->path, sizeof a->path, "%s", path);
  BASE_TRY(base_in_open(path, &a->file, err));
  if (fread(found, sizeof found, 1, a->file) != 1 || memcmp(found, magic, sizeof magic) != 0) {
    (void)answers_close(a, false, NULL);
    return BASE_FAIL(err, BASE_EINVAL, "%s: not a file of stored answers", path);
  }
  return BASE_OK;
}

static bool read_sparse(FILE *from, double *z, int n) {
  int bits = 0;
  for (int i = 0; i < n; i++) {
    bits = (i % 8 == 0) ? fgetc(from) : bits >> 1;
    if (bits == EOF) {
      return false;
    }
    z[i] = (double)(bits & 1); /* marked; replaced below */
  }
  for (int i = 0; i < n; i++) {
    if (z[i] != 0.0 && fread(&z[i], sizeof z[i], 1, from) != 1) {
      return false;
    }
  }
  return true;
}

static base_status read_proof(answers *a, int n, lcp_result *claim, base_error *err) {
  if (n > a->proof_cap) {
    double *grown = realloc(a->proof, (size_t)n * sizeof *grown);
    if (grown == NULL) {
      return BASE_FAIL(err, BASE_ENOMEM, "%s: no memory for a proof of %d numbers", a->path, n);
    }
    a->proof = grown;
    a->proof_cap = n;
  }
  if (fread(a->proof, sizeof *a->proof, (size_t)n, a->file) != (size_t)n) {
    return io_failed(a->path, err);
  }
  claim->certificate = (lcp_certificate){.kind = LCP_CERT_FARKAS, .vector = a->proof};
  return BASE_OK;
}

base_status answers_take(answers *a, int n, double *z, lcp_result *claim, base_error *err) {
  head h;
  errno = 0;
  if (fread(&h, sizeof h, 1, a->file) != 1) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: holds no further answer", a->path);
  }
  if (h.word < 0 && h.word > -(int32_t)BASE_STATUS_COUNT) {
    return BASE_FAIL(err, (base_status)-h.word, "stored: the solver returned no answer");
  }
  if (h.n != n || h.word < 0 || h.word >= (int32_t)LCP_OUTCOME_COUNT ||
      (h.n_proof != 0 && h.n_proof != n)) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: holds an answer of %d unknowns, the problem has %d",
                     a->path, (int)h.n, n);
  }
  *claim = (lcp_result){.outcome = (lcp_outcome)h.word, .variant = ""};
  if (!read_sparse(a->file, z, n)) {
    return io_failed(a->path, err);
  }
  return (h.n_proof > 0) ? read_proof(a, h.n_proof, claim, err) : BASE_OK;
}

base_status answers_finish(answers *a, base_error *err) {
  return (fgetc(a->file) == EOF)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EINVAL, "%s: holds more answers than there are solves", a->path);
}
