#include "harness/util/sha256.h"

#include "lcp/base/input.h"

#include <stdio.h>
#include <string.h>

static const uint32_t round_constant[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

static uint32_t rotate(uint32_t x, int n) {
  return (x >> n) | (x << (32 - n));
}

static void compress(sha256 *s) {
  uint32_t w[64];
  for (int i = 0; i < 16; i++) {
    const unsigned char *b = s->block + 4 * (size_t)i;
    w[i] = (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3];
  }
  for (int i = 16; i < 64; i++) {
    const uint32_t a = rotate(w[i - 15], 7) ^ rotate(w[i - 15], 18) ^ (w[i - 15] >> 3);
    const uint32_t b = rotate(w[i - 2], 17) ^ rotate(w[i - 2], 19) ^ (w[i - 2] >> 10);
    w[i] = w[i - 16] + a + w[i - 7] + b;
  }
  uint32_t v[8];
  memcpy(v, s->state, sizeof v);
  for (int i = 0; i < 64; i++) {
    const uint32_t e = rotate(v[4], 6) ^ rotate(v[4], 11) ^ rotate(v[4], 25);
    const uint32_t choose = (v[4] & v[5]) ^ (~v[4] & v[6]);
    const uint32_t t1 = v[7] + e + choose + round_constant[i] + w[i];
    const uint32_t a = rotate(v[0], 2) ^ rotate(v[0], 13) ^ rotate(v[0], 22);
    const uint32_t majority = (v[0] & v[1]) ^ (v[0] & v[2]) ^ (v[1] & v[2]);
    memmove(v + 1, v, 7 * sizeof *v);
    v[4] += t1;
    v[0] = t1 + a + majority;
  }
  for (int i = 0; i < 8; i++) {
    s->state[i] += v[i];
  }
}

void sha256_begin(sha256 *s) {
  *s = (sha256){.state = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c,
                          0x1f83d9ab, 0x5be0cd19}};
}

void sha256_add(sha256 *s, const void *data, size_t n) {
  const unsigned char *at = data;
  s->length += n;
  while (n > 0) {
    const size_t room = sizeof s->block - s->filled;
    const size_t take = (n < room) ? n : room;
    memcpy(s->block + s->filled, at, take);
    s->filled += take;
    at += take;
    n -= take;
    if (s->filled == sizeof s->block) {
      compress(s);
      s->filled = 0;
    }
  }
}

void sha256_text(sha256 *s, const char *text) {
  sha256_add(s, text, strlen(text) + 1);
}

void sha256_end(sha256 *s, char hex[SHA256_HEX]) {
  const uint64_t bits = 8 * s->length;
  const unsigned char one = 0x80;
  const unsigned char zero = 0;
  sha256_add(s, &one, 1);
  while (s->filled != 56) {
    sha256_add(s, &zero, 1);
  }
  unsigned char tail[8];
  for (int i = 0; i < 8; i++) {
    tail[i] = (unsigned char)(bits >> (56 - 8 * i));
  }
  sha256_add(s, tail, sizeof tail);
  for (int i = 0; i < 8; i++) {
    (void)snprintf(hex + 8 * (size_t)i, 9, "%08x", s->state[i]);
  }
}

base_status sha256_file(const char *path, char hex[SHA256_HEX], base_error *err) {
  FILE *from;
  BASE_TRY(base_in_open(path, &from, err));
  sha256 s;
  sha256_begin(&s);
  unsigned char chunk[65536];
  size_t got;
  while ((got = fread(chunk, 1, sizeof chunk, from)) > 0) {
    sha256_add(&s, chunk, got);
  }
  const bool bad = ferror(from) != 0;
  (void)fclose(from);
  sha256_end(&s, hex);
  return bad ? BASE_FAIL(err, BASE_EIO, "%s: could not be read", path) : BASE_OK;
}
