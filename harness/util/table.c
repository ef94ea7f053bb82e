#include "harness/util/table.h"

#include "harness/util/csv.h"
#include "harness/util/json_out.h"
#include "lcp/base/nearest.h"

#include <string.h>

enum { TABLE_CELL = 512 };

base_status table_format(const char *format, base_error *err) {
  static const char words[] = "table|csv|json";
  char hint[BASE_NEAREST_HINT];
  if (strcmp(format, "table") == 0 || strcmp(format, "csv") == 0 || strcmp(format, "json") == 0) {
    return BASE_OK;
  }
  return BASE_FAIL(err, BASE_EINVAL, "--format %.100s: need table, csv or json%s", format,
                   base_nearest_word(format, words, hint));
}

/* A value as text; `digits` of a real. */
static const char *text_of(const json_t *v, int digits, const char *null, char buf[TABLE_CELL]) {
  if (json_is_string(v)) {
    return json_string_value(v);
  }
  if (json_is_real(v)) {
    (void)snprintf(buf, TABLE_CELL, "%.*g", digits, json_real_value(v));
  } else if (json_is_integer(v)) {
    (void)snprintf(buf, TABLE_CELL, "%lld", (long long)json_integer_value(v));
  } else {
    (void)snprintf(buf, TABLE_CELL, "%s",
                   json_is_true(v)    ? "true"
                   : json_is_false(v) ? "false"
                                      : null);
  }
  return buf;
}

/* Characters of UTF-8, not bytes. */
static int letters(const char *text) {
  int n = 0;
  for (const char *c = text; *c != '\0'; c++) {
    n += ((unsigned char)*c & 0xc0) != 0x80;
  }
  return n;
}

/* No blanks at the end of a line. */
static void put_padded(const char *text, int width, bool right, int *owed, FILE *to) {
  const int pad = width - letters(text);
  if (text[0] != '\0') {
    (void)fprintf(to, "%*s%s", *owed + (right ? pad : 0), "", text);
    *owed = 0;
  }
  *owed += 2 + (right && text[0] != '\0' ? 0 : pad);
}

static void print_words(const json_t *rows, const char *const *column, int n, FILE *to) {
  char buf[TABLE_CELL];
  int width[TABLE_COLUMNS];
  bool number[TABLE_COLUMNS];
  size_t i;
  const json_t *row;
  for (int c = 0; c < n; c++) {
    width[c] = letters(column[c]);
    number[c] = false;
    json_array_foreach(rows, i, row) {
      const json_t *v = json_object_get(row, column[c]);
      const int wide = letters(text_of(v, 3, "-", buf));
      width[c] = (wide > width[c]) ? wide : width[c];
      number[c] = number[c] || json_is_number(v);
    }
  }
  int owed = 0;
  for (int c = 0; c < n; c++) {
    put_padded(column[c], width[c], number[c], &owed, to);
  }
  (void)fputc('\n', to);
  json_array_foreach(rows, i, row) {
    owed = 0;
    for (int c = 0; c < n; c++) {
      put_padded(text_of(json_object_get(row, column[c]), 3, "-", buf), width[c], number[c], &owed,
                 to);
    }
    (void)fputc('\n', to);
  }
}

static void put_csv(const char *text, bool first, FILE *to) {
  (void)fputs(first ? "" : ",", to);
  csv_put(text, to);
}

static void print_csv(const json_t *rows, const char *const *column, int n, FILE *to) {
  char buf[TABLE_CELL];
  size_t i;
  const json_t *row;
  for (int c = 0; c < n; c++) {
    put_csv(column[c], c == 0, to);
  }
  (void)fputc('\n', to);
  json_array_foreach(rows, i, row) {
    for (int c = 0; c < n; c++) {
      put_csv(text_of(json_object_get(row, column[c]), 17, "", buf), c == 0, to);
    }
    (void)fputc('\n', to);
  }
}

bool table_print(json_t *rows, const char *const *column, const char *format, FILE *to) {
  int n = 0;
  while (n < TABLE_COLUMNS && column[n] != NULL) {
    n++;
  }
  if (strcmp(format, "json") == 0) {
    return json_out_print(rows, to);
  }
  (strcmp(format, "csv") == 0 ? print_csv : print_words)(rows, column, n, to);
  json_decref(rows);
  return fflush(to) == 0 && ferror(to) == 0;
}
