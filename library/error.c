/* error.c - the last error of each thread, and the version. */
#include "library/library.h"

#include <stdarg.h>
#include <stdio.h>

_Static_assert((int)LCP_INVALID == (int)BASE_EINVAL && (int)LCP_NO_MEMORY == (int)BASE_ENOMEM &&
                   (int)LCP_IO == (int)BASE_EIO && (int)LCP_UNSUPPORTED == (int)BASE_EUNSUPPORTED &&
                   (int)LCP_EXTERNAL == (int)BASE_EEXTERNAL &&
                   (int)LCP_UNSOLVED == (int)BASE_STATUS_COUNT,
               "public codes are those of base_status");

static _Thread_local char last[sizeof((base_error *)NULL)->text];

int library_failed(const base_error *err) {
  (void)snprintf(last, sizeof last, "%s", err->text);
  return (int)err->code;
}

int library_unsolved(const char *format, ...) {
  va_list ap;
  va_start(ap, format);
  (void)vsnprintf(last, sizeof last, format, ap);
  va_end(ap);
  return LCP_UNSOLVED;
}

const char *lcp_last_error(void) {
  return last;
}

const char *lcp_version(void) {
  return LCP_VERSION;
}

int lcp_api_version(void) {
  return LCP_API_VERSION;
}
