#include "harness/util/json_file.h"

#include "harness/util/folder.h"
#include "harness/util/whole_file.h"

#include <errno.h>
#include <string.h>

base_status json_file_write(const json_t *o, const char *dir, const char *name, base_error *err) {
  char path[1100];
  whole_file w;
  folder_file(dir, name, path, sizeof path);
  BASE_TRY(whole_file_open(&w, path, err));
  errno = 0;
  const bool good = json_dumpf(o, w.to, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) == 0;
  const int why = errno;
  BASE_TRY(whole_file_close(&w, good, err));
  return good ? BASE_OK
              : BASE_FAIL(err, BASE_EIO, "%s: %s", path,
                          why != 0 ? strerror(why) : "could not be written");
}

base_status json_file_read(const char *dir, const char *name, json_t **out, base_error *err) {
  char path[1100];
  json_error_t why;
  *out = NULL;
  folder_file(dir, name, path, sizeof path);
  FILE *from = fopen(path, "r");
  if (from == NULL) {
    return (errno == ENOENT) ? BASE_OK : BASE_FAIL(err, BASE_EIO, "%s: %s", path, strerror(errno));
  }
  *out = json_loadf(from, 0, &why);
  (void)fclose(from);
  if (json_is_object(*out)) {
    return BASE_OK;
  }
  json_decref(*out);
  *out = NULL;
  return BASE_FAIL(err, BASE_EINVAL, "%s:%d: not a JSON object", path, why.line);
}
