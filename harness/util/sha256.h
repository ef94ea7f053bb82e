/* harness/util/sha256.h - SHA-256 (FIPS 180-4) for content keys and manifests. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct sha256 {
  uint32_t state[8];
  uint64_t length; /* [B] */
  unsigned char block[64];
  size_t filled;
} sha256;

enum { SHA256_HEX = 65 };

void sha256_begin(sha256 *s);
void sha256_add(sha256 *s, const void *data, size_t n);
void sha256_text(sha256 *s, const char *text); /* with its terminating zero, so fields cannot run
                                                  into each other */
void sha256_end(sha256 *s, char hex[SHA256_HEX]);
base_status sha256_file(const char *path, char hex[SHA256_HEX], base_error *err);
