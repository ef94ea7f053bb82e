#include "harness/util/version.h"

const char *harness_version(void) {
  return "0.1.0";
}
