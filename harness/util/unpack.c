#include "harness/util/unpack.h"

#include "lcp/base/input.h"

#include <errno.h>
#include <lzma.h>
#include <string.h>
#include <sys/mman.h>

#define UNPACK_MAX 4294967296.0 /* [B] */

bool unpack_is_xz(const char *path) {
  const size_t n = strlen(path);
  return n >= 3 && strcmp(path + n - 3, ".xz") == 0;
}

static base_status damaged(const char *path, lzma_ret why, base_error *err) {
  return (why == LZMA_MEM_ERROR)
             ? BASE_FAIL(err, BASE_ENOMEM, "%.300s: no memory to unpack it", path)
             : BASE_FAIL(err, BASE_EINVAL, "%.300s: %s", path,
                         why == LZMA_FORMAT_ERROR ? "is not packed with xz"
                         : why == LZMA_BUF_ERROR  ? "is packed with xz, and ends early"
                                                  : "is packed with xz, and damaged");
}

/* The stream points into the buffers, so they live and end together. */
typedef struct decoder {
  lzma_stream s;
  unsigned char in[65536], out[65536];
} decoder;

static base_status decode(const char *path, decoder *d, FILE *from, FILE *to, base_error *err) {
  lzma_stream *s = &d->s;
  double size = 0.0;
  lzma_ret done = LZMA_OK;
  while (done == LZMA_OK) {
    if (s->avail_in == 0 && !feof(from)) {
      s->next_in = d->in;
      s->avail_in = fread(d->in, 1, sizeof d->in, from);
      if (ferror(from)) {
        return BASE_FAIL(err, BASE_EIO, "%.300s: could not be read", path);
      }
    }
    s->next_out = d->out;
    s->avail_out = sizeof d->out;
    done = lzma_code(s, feof(from) ? LZMA_FINISH : LZMA_RUN);
    const size_t got = sizeof d->out - s->avail_out;
    size += (double)got;
    if (size > UNPACK_MAX) {
      return BASE_FAIL(err, BASE_EINVAL, "%.300s: is larger than 4 GiB unpacked", path);
    }
    if (fwrite(d->out, 1, got, to) != got) {
      return BASE_FAIL(err, BASE_ENOMEM, "%.300s: no memory to unpack it", path);
    }
  }
  return (done == LZMA_STREAM_END) ? BASE_OK : damaged(path, done, err);
}

static base_status unpack(const char *path, FILE *from, FILE *to, base_error *err) {
  decoder d = {.s = LZMA_STREAM_INIT};
  const lzma_ret made = lzma_stream_decoder(&d.s, (uint64_t)1 << 28, LZMA_CONCATENATED);
  const base_status done =
      (made == LZMA_OK) ? decode(path, &d, from, to, err) : damaged(path, made, err);
  lzma_end(&d.s);
  return done;
}

base_status unpack_text(const char *path, FILE **out, base_error *err) {
  if (!unpack_is_xz(path)) {
    return base_in_text(path, out, err);
  }
  FILE *from;
  *out = NULL;
  BASE_TRY(base_in_open(path, &from, err));
  const int fd = memfd_create("rows", MFD_CLOEXEC);
  FILE *to = (fd >= 0) ? fdopen(fd, "w+b") : NULL;
  const base_status done = (to != NULL)
                               ? unpack(path, from, to, err)
                               : BASE_FAIL(err, BASE_ENOMEM, "%.300s: %s", path, strerror(errno));
  (void)fclose(from);
  if (done != BASE_OK) {
    if (to != NULL) {
      (void)fclose(to);
    }
    return done;
  }
  rewind(to);
  *out = to;
  return BASE_OK;
}
