#include "harness/util/memory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef __GLIBC__
#include <malloc.h>

void memory_return_from(size_t bytes) {
  (void)mallopt(M_MMAP_THRESHOLD, (int)bytes);
  (void)mallopt(M_TRIM_THRESHOLD, (int)bytes);
}
#else
void memory_return_from(size_t bytes) {
  (void)bytes;
}
#endif

double memory_peak(void) {
  FILE *from = fopen("/proc/self/status", "r");
  char line[256];
  double kB = (double)NAN;
  while (from != NULL && fgets(line, sizeof line, from) != NULL) {
    if (strncmp(line, "VmHWM:", 6) == 0) {
      kB = strtod(line + 6, NULL);
    }
  }
  if (from != NULL) {
    (void)fclose(from);
  }
  return 1024.0 * kB;
}
