/* tests/fuzz/fuzz_file.h - the input of a libFuzzer target as a file in memory-backed storage, for
 * readers that take a path. One file per process, rewritten for every input. */
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Path of a file with these bytes; NULL if it could not be written. */
static inline const char *fuzz_file(const uint8_t *data, size_t size, const char *ending) {
  static char path[128];
  (void)snprintf(path, sizeof path, "/dev/shm/lcpbench_fuzz_%d%s", (int)getpid(), ending);
  FILE *f = fopen(path, "wb");
  if (f == NULL) {
    return NULL;
  }
  const size_t wrote = fwrite(data, 1, size, f);
  return (fclose(f) == 0 && wrote == size) ? path : NULL;
}
