#include "lcp/io/zip.h"

#include "lcp/base/input.h"

#include <limits.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#define ZLIB_CONST /* next_in may point to what is not written */
#include <zlib.h>

enum { END_SIZE = 22, ENTRY_SIZE = 46, LOCAL_SIZE = 30, COMMENT_MAX = 65535 };
enum { STORED = 0, DEFLATED = 8 };
enum { RATIO = 1100 }; /* deflate packs a byte into no less than 1/1032 */

/* Little-endian numbers. */
static size_t number(const unsigned char *at, int bytes) {
  size_t x = 0;
  for (int i = bytes; i-- > 0;) {
    x = x << 8 | at[i];
  }
  return x;
}

static base_status bad(const lcp_zip *z, const char *why, base_error *err) {
  return BASE_FAIL(err, BASE_EINVAL, "%.300s: %s", z->path, why);
}

static base_status read_all(lcp_zip *z, FILE *f, base_error *err) {
  const long end = (fseek(f, 0, SEEK_END) == 0) ? ftell(f) : -1;
  if (end < 0 || end > INT_MAX || fseek(f, 0, SEEK_SET) != 0) {
    return BASE_FAIL(err, BASE_EIO, "%.300s: need a file of at most 2 GiB", z->path);
  }
  z->size = (size_t)end;
  z->data = malloc(z->size + 1);
  if (z->data == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%.300s: no memory for %zu bytes", z->path, z->size);
  }
  return (fread(z->data, 1, z->size, f) == z->size)
             ? BASE_OK
             : BASE_FAIL(err, BASE_EIO, "%.300s: could not be read", z->path);
}

/* The end of the central directory, which a comment may follow; NULL: none. */
static const unsigned char *find_end(const lcp_zip *z) {
  for (size_t back = END_SIZE; back <= z->size && back <= END_SIZE + COMMENT_MAX; back++) {
    const unsigned char *at = z->data + z->size - back;
    if (memcmp(at, "PK\005\006", 4) == 0 && number(at + 20, 2) == back - END_SIZE) {
      return at;
    }
  }
  return NULL;
}

static base_status read_entry(lcp_zip *z, size_t *at, size_t end, base_error *err) {
  lcp_zip_file *f = &z->file[z->n];
  const unsigned char *e = z->data + *at;
  if (*at > end || end - *at < ENTRY_SIZE || memcmp(e, "PK\001\002", 4) != 0) {
    return bad(z, "damaged: its list of files ends early", err);
  }
  const size_t name = number(e + 28, 2);
  const size_t whole = ENTRY_SIZE + name + number(e + 30, 2) + number(e + 32, 2);
  if (end - *at < whole || name == 0 || name >= sizeof f->name) {
    return bad(z, "a file in it has no name, or one that is too long", err);
  }
  memcpy(f->name, e + ENTRY_SIZE, name);
  f->name[name] = '\0';
  f->method = (unsigned)number(e + 10, 2);
  f->crc = (unsigned)number(e + 16, 4);
  f->packed = number(e + 20, 4);
  f->size = number(e + 24, 4);
  f->at = number(e + 42, 4);
  if ((number(e + 8, 2) & 1u) != 0 || (f->method != STORED && f->method != DEFLATED)) {
    return bad(z, "a file in it is encrypted, or packed by another method than deflate", err);
  }
  if (f->packed > z->size || f->size > INT_MAX || f->size / RATIO > f->packed) {
    return bad(z, "a file in it has a size that the archive cannot hold", err);
  }
  *at += whole;
  z->n++;
  return BASE_OK;
}

static base_status read_list(lcp_zip *z, base_error *err) {
  const unsigned char *end = find_end(z);
  if (end == NULL) {
    return bad(z, "not a ZIP archive, or one that ends early", err);
  }
  const size_t count = number(end + 10, 2);
  size_t at = number(end + 16, 4);
  if (count > LCP_ZIP_FILES) {
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: holds %zu files, need at most %d", z->path, count,
                     LCP_ZIP_FILES);
  }
  for (size_t i = 0; i < count; i++) {
    BASE_TRY(read_entry(z, &at, (size_t)(end - z->data), err));
  }
  return BASE_OK;
}

base_status lcp_zip_open(lcp_zip *z, const char *path, base_error *err) {
  FILE *f;
  z->path = path;
  z->data = NULL;
  z->n = 0;
  BASE_TRY(base_in_open(path, &f, err));
  base_status done = read_all(z, f, err);
  (void)fclose(f);
  if (done == BASE_OK) {
    done = read_list(z, err);
  }
  if (done != BASE_OK) {
    lcp_zip_close(z);
  }
  return done;
}

static bool inflate_into(const unsigned char *from, size_t n, unsigned char *to, size_t size) {
  z_stream s = {.next_in = from, .avail_in = (uInt)n, .avail_out = (uInt)size};
  s.next_out = to;
  if (inflateInit2(&s, -MAX_WBITS) != Z_OK) {
    return false;
  }
  const int done = inflate(&s, Z_FINISH);
  const bool whole = done == Z_STREAM_END && s.avail_out == 0;
  (void)inflateEnd(&s);
  return whole;
}

base_status lcp_zip_read(const lcp_zip *z, int i, unsigned char **out, base_error *err) {
  const lcp_zip_file *f = &z->file[i];
  *out = NULL;
  const unsigned char *local = z->data + f->at;
  if (f->at > z->size || z->size - f->at < LOCAL_SIZE || memcmp(local, "PK\003\004", 4) != 0) {
    return bad(z, "damaged: a file is not where its list says", err);
  }
  const size_t head = LOCAL_SIZE + number(local + 26, 2) + number(local + 28, 2);
  if (z->size - f->at < head || z->size - f->at - head < f->packed) {
    return bad(z, "damaged: a file in it ends early", err);
  }
  unsigned char *data = malloc(f->size + 1);
  if (data == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "%.300s: no memory for %zu bytes", z->path, f->size);
  }
  bool good = f->method == DEFLATED || f->packed == f->size;
  if (good && f->method == STORED) {
    memcpy(data, local + head, f->size);
  } else if (good) {
    good = inflate_into(local + head, f->packed, data, f->size);
  }
  if (!good || crc32(0L, data, (uInt)f->size) != f->crc) {
    free(data);
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: damaged: %s does not unpack to what it was",
                     z->path, f->name);
  }
  *out = data;
  return BASE_OK;
}

void lcp_zip_close(lcp_zip *z) {
  free(z->data);
  z->data = NULL;
  z->n = 0;
}
