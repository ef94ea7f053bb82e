#include "harness/util/version.h"

#include "include/lcpbench/lcpbench.h"

const char *harness_version(void) {
  return LCP_VERSION;
}
