#include "lcp/base/input.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *kind_of(mode_t mode) {
  return S_ISDIR(mode) ? "is a folder" : S_ISFIFO(mode) ? "is a pipe" : "is a device";
}

static base_status failed(const char *path, int why, base_error *err) {
  const base_status done =
      BASE_FAIL(err, BASE_EIO, "%.300s: cannot be opened: %s", path, strerror(why));
  errno = why;
  return done;
}

base_status base_in_open(const char *path, FILE **out, base_error *err) {
  struct stat st;
  *out = NULL;
  const int fd = open(path, O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY); /* waits for no writer */
  if (fd < 0) {
    return failed(path, errno, err);
  }
  if (fstat(fd, &st) != 0 || !S_ISREG(st.st_mode)) {
    (void)close(fd);
    const base_status done =
        BASE_FAIL(err, BASE_EINVAL, "%.300s: %s; need a regular file", path, kind_of(st.st_mode));
    errno = EINVAL;
    return done;
  }
  *out = fdopen(fd, "rb");
  if (*out == NULL) {
    const int why = errno;
    (void)close(fd);
    return failed(path, why, err);
  }
  return BASE_OK;
}

base_status base_in_text(const char *path, FILE **out, base_error *err) {
  unsigned char mark[3] = {0};
  BASE_TRY(base_in_open(path, out, err));
  const size_t got = fread(mark, 1, sizeof mark, *out);
  if (got >= 2 && ((mark[0] == 0xff && mark[1] == 0xfe) || (mark[0] == 0xfe && mark[1] == 0xff))) {
    (void)fclose(*out);
    *out = NULL;
    errno = EINVAL;
    return BASE_FAIL(err, BASE_EINVAL, "%.300s: is UTF-16; need UTF-8", path);
  }
  if (got != sizeof mark || memcmp(mark, "\xef\xbb\xbf", sizeof mark) != 0) {
    rewind(*out);
  }
  return BASE_OK;
}
