#include "lcp/base/status.h"

#include <stdarg.h>
#include <stdio.h>

#define TEXT_(id, text) text,
static const char *const texts[] = {BASE_STATUS_LIST(TEXT_)};

const char *base_status_text(base_status s) {
  return ((unsigned)s < BASE_STATUS_COUNT) ? texts[s] : "unknown status";
}

base_status base_fail(base_error *err, base_status code, const char *where, const char *fmt, ...) {
  if (err != NULL) {
    err->code = code;
    err->where = where;
    va_list ap;
    va_start(ap, fmt);
    (void)vsnprintf(err->text, sizeof err->text, fmt, ap);
    va_end(ap);
  }
  return code;
}
