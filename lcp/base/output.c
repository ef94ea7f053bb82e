#ifndef _GNU_SOURCE /* the harness has it on its command line */
#define _GNU_SOURCE /* O_TMPFILE */
#endif
#include "lcp/base/output.h"

#include "lcp/base/clock.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { HOPS = 40, TRIES = 100 }; /* symlinks in a row, as the kernel has it; temporary names */

bool base_out_is_stdout(const char *path) {
  return strcmp(path, "-") == 0 || strcmp(path, "/dev/stdout") == 0 ||
         strcmp(path, "/dev/fd/1") == 0 || strcmp(path, "/proc/self/fd/1") == 0;
}

static base_status refuse(const char *path, const char *why, base_error *err) {
  return BASE_FAIL(err, BASE_EIO, "%.300s: %s", path, why);
}

static base_status failed(const char *path, int why, base_error *err) {
  return BASE_FAIL(err, BASE_EIO, "%.300s: could not be written%s%s", path, why != 0 ? ": " : "",
                   why != 0 ? strerror(why) : "");
}

/* Length of the folder part with its slash; 0: the name stands alone. */
static size_t folder_length(const char *path) {
  const char *slash = strrchr(path, '/');
  return (slash != NULL) ? (size_t)(slash - path) + 1 : 0;
}

/* Does the link stand for an open file, as those of /proc/self/fd do? */
static bool is_descriptor(const struct stat *link) {
  struct stat proc;
  return stat("/proc", &proc) == 0 && proc.st_dev == link->st_dev;
}

/* Symlinks in the last part of o->path become what they point to, which need not be there. */
static base_status follow(base_out *o, bool *descriptor, base_error *err) {
  struct stat st;
  *descriptor = false;
  for (int hop = 0; lstat(o->path, &st) == 0 && S_ISLNK(st.st_mode); hop++) {
    char target[sizeof o->path];
    if (is_descriptor(&st)) {
      *descriptor = true;
      return BASE_OK;
    }
    const ssize_t n = readlink(o->path, target, sizeof target - 1);
    if (n < 0 || hop == HOPS) {
      return failed(o->path, n < 0 ? errno : ELOOP, err);
    }
    target[n] = '\0';
    const size_t folder = (target[0] == '/') ? 0 : folder_length(o->path);
    if (folder + (size_t)n >= sizeof o->path - 1) {
      return refuse(o->path, "points to a path that is too long", err);
    }
    memcpy(o->path + folder, target, (size_t)n + 1);
  }
  return BASE_OK;
}

static const char *kind_of(mode_t mode) {
  return S_ISDIR(mode) ? "is a folder" : S_ISSOCK(mode) ? "is a socket" : "is a block device";
}

static base_status stream_of(base_out *o, int fd, base_error *err) {
  o->to = (fd >= 0) ? fdopen(fd, "wb") : NULL;
  if (o->to != NULL) {
    return BASE_OK;
  }
  const int why = errno;
  if (fd >= 0) {
    (void)close(fd);
  }
  return (why == ENOMEM) ? BASE_FAIL(err, BASE_ENOMEM, "%.300s: no memory for a stream", o->path)
                         : failed(o->path, why, err);
}

/* A device, a FIFO, a descriptor. */
static base_status open_direct(base_out *o, int flags, base_error *err) {
  const struct timespec nap = {.tv_nsec = 20000000};
  const double until = base_seconds() + BASE_OUT_WAIT;
  int fd = open(o->path, O_WRONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY | flags);
  while (fd < 0 && errno == ENXIO && base_seconds() < until) { /* a FIFO without a reader */
    (void)nanosleep(&nap, NULL);
    fd = open(o->path, O_WRONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY | flags);
  }
  if (fd < 0 && errno == ENXIO) {
    return refuse(o->path, "nobody reads it", err);
  }
  if (fd >= 0 && fcntl(fd, F_SETFL, flags) != 0) { /* from here on a full pipe is waited for */
    const int why = errno;
    (void)close(fd);
    return failed(o->path, why, err);
  }
  return stream_of(o, fd, err);
}

/* Puts the k-th of the names beside the file that are tried into o->temporary. */
static void name_temporary(base_out *o, int k) {
  const size_t folder = folder_length(o->path);
  (void)snprintf(o->temporary, sizeof o->temporary, "%.*s%.200s.%ld-%d.tmp", (int)folder, o->path,
                 o->path + folder, (long)getpid(), k);
}

/* A name beside the file that nobody has. */
static int create_temporary(base_out *o) {
  int fd = -1;
  errno = EEXIST;
  for (int k = 0; fd < 0 && errno == EEXIST && k < TRIES; k++) {
    name_temporary(o, k);
    fd = open(o->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  }
  return fd;
}

/* A file without a name, of which nothing is left where the program is killed; -1 where the file system
 * has none, or where /proc, by which it gets its name, is not there. */
static int create_nameless(const base_out *o) {
  char folder[sizeof o->path];
  (void)snprintf(folder, sizeof folder, "%.*s.", (int)folder_length(o->path), o->path);
  return (access("/proc/self/fd", X_OK) == 0) ? open(folder, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666)
                                              : -1;
}

/* Gives the nameless file a temporary name, which can replace another in one step; false with errno. */
static bool link_nameless(base_out *o) {
  char self[64];
  (void)snprintf(self, sizeof self, "/proc/self/fd/%d", fileno(o->to));
  errno = EEXIST;
  for (int k = 0; errno == EEXIST && k < TRIES; k++) {
    name_temporary(o, k);
    if (linkat(AT_FDCWD, self, AT_FDCWD, o->temporary, AT_SYMLINK_FOLLOW) == 0) {
      return true;
    }
  }
  o->temporary[0] = '\0';
  return false;
}

/* `old`: the file that will be replaced, NULL where the name is free. `named`: a library opens it by name. */
static base_status open_whole(base_out *o, const struct stat *old, bool named, base_error *err) {
  struct stat out;
  if (old != NULL && faccessat(AT_FDCWD, o->path, W_OK, AT_EACCESS) != 0) {
    return failed(o->path, errno, err);
  }
  if (old != NULL && fstat(STDOUT_FILENO, &out) == 0 && out.st_dev == old->st_dev &&
      out.st_ino == old->st_ino) {
    return refuse(o->path, "is what standard output writes to", err);
  }
  int fd = named ? -1 : create_nameless(o);
  o->nameless = fd >= 0;
  if (!o->nameless) {
    fd = create_temporary(o);
  }
  if (fd < 0) {
    o->temporary[0] = '\0';
    return failed(o->path, errno, err);
  }
  bool good = true;
  if (old != NULL) { /* the owner is kept where the system lets us */
    good = fchown(fd, old->st_uid, old->st_gid) == 0 || errno == EPERM;
    good = good && fchmod(fd, old->st_mode & 07777) == 0;
  }
  const int why = errno;
  const base_status done = stream_of(o, fd, err);
  if (done == BASE_OK && good) {
    return BASE_OK;
  }
  if (!o->nameless) {
    (void)unlink(o->temporary);
  }
  if (done == BASE_OK) {
    (void)fclose(o->to);
    o->to = NULL;
  }
  return (done != BASE_OK) ? done : failed(o->path, why, err);
}

static base_status take_path(base_out *o, const char *path, base_error *err) {
  const size_t len = strlen(path);
  o->to = NULL;
  o->temporary[0] = '\0';
  o->nameless = false;
  if (len == 0 || len >= sizeof o->path) {
    return BASE_FAIL(err, BASE_EINVAL, "'%.80s%s: need the name of a file, of 1 to %zu characters",
                     path, len == 0 ? "'" : "...'", sizeof o->path - 1);
  }
  memcpy(o->path, path, len + 1);
  return (path[len - 1] == '/') ? refuse(path, "is the name of a folder", err) : BASE_OK;
}

static base_status open_any(base_out *o, bool regular, base_error *err) {
  struct stat st;
  bool descriptor;
  BASE_TRY(follow(o, &descriptor, err));
  const bool there = stat(o->path, &st) == 0;
  if (!there && errno != ENOENT) {
    return failed(o->path, errno, err);
  }
  if (there && (S_ISDIR(st.st_mode) || S_ISSOCK(st.st_mode) || S_ISBLK(st.st_mode))) {
    return refuse(o->path, kind_of(st.st_mode), err);
  }
  if (!descriptor && (!there || S_ISREG(st.st_mode))) {
    return open_whole(o, there ? &st : NULL, regular, err);
  }
  return regular ? refuse(o->path, "is not a regular file, which this format needs", err)
                 : open_direct(o, descriptor ? O_APPEND : 0, err);
}

base_status base_out_open(base_out *o, const char *path, base_error *err) {
  BASE_TRY(take_path(o, path, err));
  if (base_out_is_stdout(path)) {
    (void)snprintf(o->path, sizeof o->path, "stdout");
    o->to = stdout;
    return BASE_OK;
  }
  return open_any(o, false, err);
}

base_status base_out_open_regular(base_out *o, const char *path, base_error *err) {
  BASE_TRY(take_path(o, path, err));
  return base_out_is_stdout(path) ? refuse(path, "this format needs a regular file", err)
                                  : open_any(o, true, err);
}

base_status base_out_close(base_out *o, bool keep, base_error *err) {
  if (o->to == NULL) {
    return BASE_OK;
  }
  const bool whole = o->nameless || o->temporary[0] != '\0';
  errno = 0;
  /* what an earlier write could not put down is tried again here, and says why */
  bool good = fflush(o->to) == 0 && ferror(o->to) == 0;
  good = good && (!whole || !keep || fsync(fileno(o->to)) == 0);
  good = good && (!o->nameless || !keep || link_nameless(o));
  int why = errno;
  if (o->to != stdout && fclose(o->to) != 0 && good) {
    good = false;
    why = errno;
  }
  o->to = NULL;
  if (good && whole && keep && rename(o->temporary, o->path) != 0) {
    good = false; /* on the disk the name means the old or the new file, each of them whole */
    why = errno;
  }
  if (o->temporary[0] != '\0' && (!keep || !good)) {
    (void)unlink(o->temporary);
  }
  return (good || !keep) ? BASE_OK : failed(o->path, why, err);
}

base_status base_out_finish(base_out *o, base_status done, base_error *err) {
  const bool failed = o->to != NULL && ferror(o->to) != 0;
  const base_status closed =
      base_out_close(o, done == BASE_OK || failed, (done == BASE_OK || failed) ? err : NULL);
  return (done == BASE_OK || failed) ? closed : done;
}
