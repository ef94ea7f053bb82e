#include "lcp/io/zip_write.h"

#include <assert.h>
#include <limits.h>
#include <string.h>
#define ZLIB_CONST
#include <zlib.h>

enum { VERSION = 20, DAY_ZERO = 1 << 5 | 1 }; /* 2.0; 1980-01-01 */

/* A little-endian number of 2 or 4 bytes. */
static void number(lcp_zip_out *z, size_t x, int bytes) {
  for (int i = 0; i < bytes; i++) {
    (void)fputc((int)(x >> 8 * i & 0xff), z->to);
  }
  z->at += (size_t)bytes;
}

static void bytes(lcp_zip_out *z, const void *from, size_t n) {
  z->at += (n > 0) ? fwrite(from, 1, n, z->to) : 0;
}

/* What the header of a file and its entry in the list have in common. */
static void describe(lcp_zip_out *z, const lcp_zip_file *f) {
  number(z, VERSION, 2);
  number(z, 0, 2); /* flags */
  number(z, f->method, 2);
  number(z, 0, 2); /* midnight */
  number(z, DAY_ZERO, 2);
  number(z, f->crc, 4);
  number(z, f->packed, 4);
  number(z, f->size, 4);
  number(z, strlen(f->name), 2);
  number(z, 0, 2); /* no extra field */
}

/* In pieces: zlib counts by unsigned int. */
static unsigned long checksum(unsigned long crc, const unsigned char *at, size_t n) {
  for (size_t piece; n > 0; at += piece, n -= piece) {
    piece = (n < INT_MAX) ? n : INT_MAX;
    crc = crc32(crc, at, (uInt)piece);
  }
  return crc;
}

void lcp_zip_put(lcp_zip_out *z, const char *name, const void *head, size_t n_head,
                 const void *data, size_t n_data) {
  assert(z->n < LCP_ZIP_FILES && strlen(name) < LCP_ZIP_NAME);
  lcp_zip_file *f = &z->file[z->n++];
  const size_t size = n_head + n_data;
  z->too_large = z->too_large || n_data > INT_MAX || size > INT_MAX || z->at > INT_MAX - size;
  if (z->too_large) {
    return;
  }
  *f = (lcp_zip_file){.size = size, .packed = size, .at = z->at};
  (void)snprintf(f->name, sizeof f->name, "%s", name);
  f->crc = (unsigned)checksum(checksum(crc32(0, NULL, 0), head, n_head), data, n_data);
  bytes(z, "PK\003\004", 4);
  describe(z, f);
  bytes(z, name, strlen(name));
  bytes(z, head, n_head);
  bytes(z, data, n_data);
}

base_status lcp_zip_end(lcp_zip_out *z, base_error *err) {
  if (z->too_large) {
    return BASE_FAIL(err, BASE_EUNSUPPORTED, "%.300s: larger than 2 GiB", z->path);
  }
  const size_t list = z->at;
  for (int i = 0; i < z->n; i++) {
    const lcp_zip_file *f = &z->file[i];
    bytes(z, "PK\001\002", 4);
    number(z, VERSION, 2);
    describe(z, f);
    number(z, 0, 2); /* no comment */
    number(z, 0, 2); /* the first disk */
    number(z, 0, 2); /* attributes */
    number(z, 0, 4);
    number(z, f->at, 4);
    bytes(z, f->name, strlen(f->name));
  }
  const size_t end = z->at;
  bytes(z, "PK\005\006", 4);
  number(z, 0, 4); /* the first disk, twice */
  number(z, (size_t)z->n, 2);
  number(z, (size_t)z->n, 2);
  number(z, end - list, 4);
  number(z, list, 4);
  number(z, 0, 2); /* no comment */
  return BASE_OK;
}
