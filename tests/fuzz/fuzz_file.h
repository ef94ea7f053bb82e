/* tests/fuzz/fuzz_file.h - the input of a libFuzzer target as a file in the working folder, for readers
 * that take a path. One file per folder, rewritten for every input. */
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Path of a file with these bytes; NULL if it could not be written. The path is relative and always
 * the same: libFuzzer sees the strings that are compared, so a process id in the path would make
 * every run mutate differently. scripts/fuzz gives each target a folder of its own. */
static inline const char *fuzz_file(const uint8_t *data, size_t size, const char *ending) {
  static char path[32];
  (void)snprintf(path, sizeof path, "fuzz_input%s", ending);
  FILE *f = fopen(path, "wb");
  if (f == NULL) {
    return NULL;
  }
  const size_t wrote = fwrite(data, 1, size, f);
  return (fclose(f) == 0 && wrote == size) ? path : NULL;
}
