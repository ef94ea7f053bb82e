#include "harness/util/csv.h"

#include <string.h>

void csv_cell(const char *text, void (*put)(void *to, char c), void *to) {
  if (strpbrk(text, ",\"\n\r") == NULL) {
    for (; *text != '\0'; text++) {
      put(to, *text);
    }
    return;
  }
  put(to, '"');
  for (; *text != '\0'; text++) {
    if (*text == '"') {
      put(to, '"');
    }
    put(to, *text);
  }
  put(to, '"');
}

static void put_letter(void *to, char c) {
  (void)fputc(c, to);
}

void csv_put(const char *text, FILE *to) {
  csv_cell(text, put_letter, to);
}
