/* harness/util/json_out.h - JSON objects on stdout: members in the order they are set, doubles with 17
 * digits, NaN and Inf as null (never as a number). */
#pragma once

#include "lcp/base/printable.h"

#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>

/* Text that is not UTF-8, as a file name may be, is written with \xHH (base_printable). */
static inline void json_out_text(json_t *o, const char *key, const char *value) {
  char shown[4096];
  json_t *text = (value != NULL) ? json_string(value) : json_null();
  if (text == NULL) {
    text = json_string(base_printable(value, shown, sizeof shown));
  }
  (void)json_object_set_new(o, key, text);
}
static inline void json_out_real(json_t *o, const char *key, double value) {
  (void)json_object_set_new(o, key, isfinite(value) ? json_real(value) : json_null());
}
static inline void json_out_int(json_t *o, const char *key, long long value) {
  (void)json_object_set_new(o, key, json_integer(value));
}
static inline void json_out_bool(json_t *o, const char *key, bool value) {
  (void)json_object_set_new(o, key, json_boolean(value));
}

/* Prints one object and a newline, and gives the object back to jansson. */
static inline bool json_out_print(json_t *o, FILE *to) {
  const bool ok = json_dumpf(o, to, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) == 0;
  json_decref(o);
  return fputc('\n', to) != EOF && fflush(to) == 0 && ok;
}
