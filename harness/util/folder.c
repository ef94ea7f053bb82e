#include "harness/util/folder.h"

#include "lcp/base/output.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

base_status folder_make(const char *path, base_error *err) {
  char part[1000]; /* leaves room for the names in it (folder_file) */
  if (path[0] == '\0' || strlen(path) >= sizeof part) {
    return BASE_FAIL(err, BASE_EINVAL, "folder '%.80s': need a name of 1 to %zu characters", path,
                     sizeof part - 1);
  }
  if (base_out_is_stdout(path)) {
    return BASE_FAIL(err, BASE_EINVAL, "%s: is standard output; need a folder (./- is one)", path);
  }
  (void)snprintf(part, sizeof part, "%s", path);
  for (char *at = part + 1; *at != '\0'; at++) {
    if (*at == '/') {
      *at = '\0';
      if (mkdir(part, 0777) != 0 && errno != EEXIST) {
        return BASE_FAIL(err, BASE_EIO, "%s: %s", part, strerror(errno));
      }
      *at = '/';
    }
  }
  struct stat st;
  if (mkdir(part, 0777) != 0 && errno != EEXIST) {
    return BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
  }
  return (stat(part, &st) == 0 && S_ISDIR(st.st_mode))
             ? BASE_OK
             : BASE_FAIL(err, BASE_EIO, "%s: is not a folder", path);
}

void folder_file(const char *dir, const char *name, char *buf, size_t cap) {
  (void)snprintf(buf, cap, "%s/%s", dir, name);
}
