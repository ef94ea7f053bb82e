/* lcp/io/npy.h - one array of numpy (NEP 1: format .npy, versions 1 to 3), viewed in the bytes it is stored in. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>

enum { LCP_NPY_DIMENSIONS = 2 };

typedef struct lcp_npy {
  const char *path, *name; /* for messages; borrowed */
  char kind;               /* f, i, u: numbers; S, U: text */
  int width;               /* of an element [bytes] */
  bool fortran;            /* columns first */
  int n_dim;
  long shape[LCP_NPY_DIMENSIONS];
  size_t count; /* elements */
  const unsigned char *data;
} lcp_npy;

/* BASE_EINVAL: no array, one of another type (little-endian real, integer or text is read), of more than two
 * dimensions, or of another size than its header says. */
base_status lcp_npy_view(lcp_npy *a, const char *path, const char *name, const unsigned char *bytes,
                         size_t size, base_error *err);

/* Element k as a number. BASE_EINVAL: text, or an integer outside of lo..hi. */
base_status lcp_npy_real(const lcp_npy *a, size_t k, double *x, base_error *err);
base_status lcp_npy_int(const lcp_npy *a, size_t k, long lo, long hi, int *x, base_error *err);

/* A text of ASCII letters, without its padding. BASE_EINVAL: it is none, or it is too long. */
base_status lcp_npy_text(const lcp_npy *a, char *buf, size_t cap, base_error *err);
