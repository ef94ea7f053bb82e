#include "lcp/base/clock.h"

#include <time.h>

static double read_clock(clockid_t id) {
  struct timespec t;
  (void)clock_gettime(id, &t); /* cannot fail for these two ids on Linux */
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double base_seconds(void) {
  return read_clock(CLOCK_MONOTONIC);
}

double base_cpu_seconds(void) {
  return read_clock(CLOCK_THREAD_CPUTIME_ID);
}
