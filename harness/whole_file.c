#include "harness/whole_file.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

base_status whole_file_open(whole_file *w, const char *path, base_error *err) {
  w->to = NULL;
  if (strlen(path) >= sizeof w->path) {
    return BASE_FAIL(err, BASE_EINVAL, "%.80s...: path longer than %zu characters", path,
                     sizeof w->path - 1);
  }
  (void)snprintf(w->path, sizeof w->path, "%s", path);
  (void)snprintf(w->temporary, sizeof w->temporary, "%s.tmp", path);
  w->to = fopen(w->temporary, "wb");
  return (w->to != NULL) ? BASE_OK
                         : BASE_FAIL(err, BASE_EIO, "%s: %s", w->temporary, strerror(errno));
}

/* The new name on the disk too. Not every file system can; the file itself is there in any case. */
static void flush_folder(const char *path) {
  char folder[1100];
  const char *slash = strrchr(path, '/');
  (void)snprintf(folder, sizeof folder, "%.*s", slash != NULL ? (int)(slash - path) : 1,
                 slash != NULL ? path : ".");
  const int fd = open(folder[0] != '\0' ? folder : "/", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd >= 0) {
    (void)fsync(fd);
    (void)close(fd);
  }
}

base_status whole_file_close(whole_file *w, bool keep, base_error *err) {
  if (w->to == NULL) {
    return BASE_OK;
  }
  errno = 0;
  bool good = !keep || (fflush(w->to) == 0 && ferror(w->to) == 0 && fsync(fileno(w->to)) == 0);
  int why = errno;
  good = fclose(w->to) == 0 && good;
  w->to = NULL;
  if (good && keep && rename(w->temporary, w->path) == 0) {
    flush_folder(w->path);
    return BASE_OK;
  }
  why = (why != 0) ? why : errno;
  (void)unlink(w->temporary);
  return (good && !keep) ? BASE_OK
                         : BASE_FAIL(err, BASE_EIO, "%s: %s", w->path,
                                     why != 0 ? strerror(why) : "could not be written");
}
