#include "harness/util/whole_file.h"

#include <errno.h>
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
  const base_status word = (errno == ENOMEM) ? BASE_ENOMEM : BASE_EIO;
  return (w->to != NULL) ? BASE_OK : BASE_FAIL(err, word, "%s: %s", w->temporary, strerror(errno));
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
    return BASE_OK; /* on the disk the name means the old or the new file, each of them whole */
  }
  why = (why != 0) ? why : errno;
  (void)unlink(w->temporary);
  return (good && !keep) ? BASE_OK
                         : BASE_FAIL(err, BASE_EIO, "%s: %s", w->path,
                                     why != 0 ? strerror(why) : "could not be written");
}
