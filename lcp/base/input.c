#ifndef _GNU_SOURCE /* the harness has it on its command line */
#define _GNU_SOURCE /* memfd_create */
#endif
#include "lcp/base/input.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/mman.h>
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

bool base_in_is_stdin(const char *path) {
  return strcmp(path, "-") == 0;
}

/* All that can be read from `from`, written to `to`; errno tells why not. */
static bool copy(int from, int to) {
  char chunk[65536];
  ssize_t got;
  while ((got = read(from, chunk, sizeof chunk)) != 0) {
    if (got < 0 && errno == EINTR) {
      continue;
    }
    for (ssize_t put = 0; put < got;) {
      const ssize_t wrote = write(to, chunk + put, (size_t)(got - put));
      if (wrote < 0) {
        return false;
      }
      put += wrote;
    }
    if (got < 0) {
      return false;
    }
  }
  return true;
}

/* Makes standard input a regular file at its beginning, which can be opened by its descriptor as often as need
 * be: what is none becomes a copy in memory. */
static base_status keep_stdin(base_error *err) {
  struct stat st;
  if (fstat(STDIN_FILENO, &st) == 0 && S_ISREG(st.st_mode) &&
      lseek(STDIN_FILENO, 0, SEEK_CUR) == 0) {
    return BASE_OK;
  }
  const int made = memfd_create("stdin", MFD_CLOEXEC);
  const bool good = made >= 0 && copy(STDIN_FILENO, made) && lseek(made, 0, SEEK_SET) == 0 &&
                    dup2(made, STDIN_FILENO) >= 0;
  const int why = errno;
  if (made >= 0) {
    (void)close(made);
  }
  errno = why;
  return good ? BASE_OK
              : BASE_FAIL(err, BASE_EIO, "-: standard input cannot be read: %s", strerror(why));
}

base_status base_in_open(const char *path, FILE **out, base_error *err) {
  struct stat st;
  *out = NULL;
  if (base_in_is_stdin(path)) {
    BASE_TRY(keep_stdin(err));
  }
  const char *name = base_in_is_stdin(path) ? "/proc/self/fd/0" : path;
  const int fd = open(name, O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY); /* waits for no writer */
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
