#include "harness/util/json_file.h"

#include "harness/util/folder.h"
#include "lcp/base/input.h"
#include "lcp/base/output.h"

#include <errno.h>
#include <string.h>

base_status json_file_write(const json_t *o, const char *dir, const char *name, base_error *err) {
  char path[1100];
  base_out w;
  folder_file(dir, name, path, sizeof path);
  BASE_TRY(base_out_open(&w, path, err));
  errno = 0;
  const bool good = json_dumpf(o, w.to, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) == 0;
  const int why = errno;
  BASE_TRY(base_out_close(&w, good, err));
  return good ? BASE_OK
              : BASE_FAIL(err, BASE_EIO, "%s: %s", path,
                          why != 0 ? strerror(why) : "could not be written");
}

base_status json_file_read(const char *dir, const char *name, json_t **out, base_error *err) {
  char path[1100];
  json_error_t why;
  *out = NULL;
  folder_file(dir, name, path, sizeof path);
  FILE *from;
  const base_status opened = base_in_text(path, &from, err);
  if (opened != BASE_OK) {
    return (from == NULL && errno == ENOENT) ? BASE_OK : opened;
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
