#include "lcp/io/npy.h"

#include <errno.h>
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEAD_MAX = 1024 }; /* of the arrays that are read; the format has no limit */

static base_status bad(const lcp_npy *a, const char *why, base_error *err) {
  return BASE_FAIL(err, BASE_EINVAL, "%.300s: %s: %s", a->path, a->name, why);
}

/* What stands behind 'key': in the header, a Python dict; NULL: no such key. */
static const char *value_of(const char *head, const char *key) {
  char quoted[24];
  (void)snprintf(quoted, sizeof quoted, "'%s'", key);
  const char *at = strstr(head, quoted);
  at = (at != NULL) ? at + strlen(quoted) : NULL;
  while (at != NULL && (*at == ' ' || *at == ':')) {
    at++;
  }
  return at;
}

/* '<f8': order of bytes, kind, width. */
static base_status take_type(lcp_npy *a, const char *text, base_error *err) {
  char type[16] = "";
  if (text == NULL || (text[0] != '\'' && text[0] != '"')) {
    return bad(a, "is an array of records; need numbers", err);
  }
  (void)snprintf(type, sizeof type, "%.*s", (int)strcspn(text + 1, "'\""), text + 1);
  const char order = type[0];
  a->kind = type[1];
  char *end = type;
  a->width = (order != '\0' && a->kind != '\0') ? (int)strtol(type + 2, &end, 10) : 0;
  const bool whole = a->width == 4 || a->width == 8;
  const bool small = a->width == 1 || a->width == 2;
  const bool fits = (a->kind == 'f')                     ? whole
                    : (a->kind == 'i' || a->kind == 'u') ? whole || small
                    : (a->kind == 'S' || a->kind == 'U') ? a->width >= 1 && a->width <= 64
                                                         : false;
  if (*end != '\0' || !fits || (order != '<' && order != '|')) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "%.300s: %s: elements of type '%s', need little-endian f4, f8, i or u",
                     a->path, a->name, type);
  }
  a->width *= (a->kind == 'U') ? 4 : 1;
  return BASE_OK;
}

/* "(3, 4)", "(3,)" or "()". */
static base_status take_shape(lcp_npy *a, const char *text, base_error *err) {
  if (text == NULL || *text != '(') {
    return bad(a, "its header has no shape", err);
  }
  text++;
  a->count = 1;
  for (a->n_dim = 0; *text != ')';) {
    char *end;
    errno = 0;
    const long n = strtol(text, &end, 10);
    if (end == text || errno != 0 || n < 0 || n > INT_MAX || a->n_dim == LCP_NPY_DIMENSIONS) {
      return bad(a, "need an array of at most two dimensions", err);
    }
    a->shape[a->n_dim++] = n;
    a->count *= (size_t)n; /* below 2^62 */
    text = end + strspn(end, ", ");
  }
  return BASE_OK;
}

base_status lcp_npy_view(lcp_npy *a, const char *path, const char *name, const unsigned char *bytes,
                         size_t size, base_error *err) {
  char head[HEAD_MAX];
  *a = (lcp_npy){.path = path, .name = name};
  if (size < 12 || memcmp(bytes, "\x93NUMPY", 6) != 0 || bytes[6] < 1 || bytes[6] > 3) {
    return bad(a, "not an array of numpy", err);
  }
  const size_t at = (bytes[6] == 1) ? 10 : 12;
  const size_t len = bytes[8] + 256u * bytes[9] + ((bytes[6] == 1) ? 0 : 65536u * bytes[10]);
  if (len >= sizeof head || size - at < len || (at == 12 && bytes[11] != 0)) {
    return bad(a, "its header is too long, or ends early", err);
  }
  memcpy(head, bytes + at, len);
  head[len] = '\0';
  BASE_TRY(take_type(a, value_of(head, "descr"), err));
  const char *order = value_of(head, "fortran_order");
  if (order == NULL || (strncmp(order, "True", 4) != 0 && strncmp(order, "False", 5) != 0)) {
    return bad(a, "its header has no fortran_order", err);
  }
  a->fortran = order[0] == 'T';
  BASE_TRY(take_shape(a, value_of(head, "shape"), err));
  a->data = bytes + at + len;
  const size_t left = size - at - len;
  return (a->count <= left && a->count * (size_t)a->width == left)
             ? BASE_OK
             : bad(a, "holds another number of elements than its shape", err);
}

/* An integer of one to eight bytes; false: beyond 2^63. */
static bool whole_of(const lcp_npy *a, size_t k, int64_t *x) {
  const unsigned char *at = a->data + k * (size_t)a->width;
  uint64_t bits = 0;
  for (int i = a->width; i-- > 0;) {
    bits = bits << 8 | at[i];
  }
  const int shift = 64 - 8 * a->width;
  if (a->kind == 'u') {
    *x = (int64_t)(bits & INT64_MAX);
    return bits <= INT64_MAX;
  }
  bits <<= shift;
  memcpy(x, &bits, sizeof *x);
  *x /= (int64_t)1 << shift; /* exact: the low bits are zero */
  return true;
}

base_status lcp_npy_real(const lcp_npy *a, size_t k, double *x, base_error *err) {
  const unsigned char *at = a->data + k * (size_t)a->width;
  int64_t i;
  if (a->kind == 'f' && a->width == 8) {
    memcpy(x, at, sizeof *x);
  } else if (a->kind == 'f') {
    float f;
    memcpy(&f, at, sizeof f);
    *x = (double)f;
  } else if ((a->kind == 'i' || a->kind == 'u') && whole_of(a, k, &i)) {
    *x = (double)i;
  } else {
    return bad(a, "need numbers", err);
  }
  return BASE_OK;
}

base_status lcp_npy_int(const lcp_npy *a, size_t k, long lo, long hi, int *x, base_error *err) {
  int64_t i = 0;
  if ((a->kind != 'i' && a->kind != 'u') || !whole_of(a, k, &i) || i < lo || i > hi) {
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: %s[%zu]: need an integer in %ld..%ld", a->path,
                     a->name, k, lo, hi);
  }
  *x = (int)i;
  return BASE_OK;
}

base_status lcp_npy_text(const lcp_npy *a, char *buf, size_t cap, base_error *err) {
  const int step = (a->kind == 'U') ? 4 : 1;
  const size_t n = (size_t)(a->width / step);
  if ((a->kind != 'S' && a->kind != 'U') || a->count != 1 || n >= cap) {
    return bad(a, "need one short text", err);
  }
  for (size_t i = 0; i < n; i++) {
    buf[i] = (char)a->data[i * (size_t)step];
  }
  buf[n] = '\0';
  return BASE_OK;
}
