/* tests/support/scratch.h - files that an import test writes and removes. */
#pragma once

#include "tests/support/check.h"

#include <stdio.h>
#include <unistd.h>

/* This process's file with the given ending. */
static inline const char *scratch(const char *ending) {
  static char path[256];
  (void)snprintf(path, sizeof path, "%s/lcpbench_import_%d%s",
                 getenv("TMPDIR") != NULL ? getenv("TMPDIR") : "/tmp", (int)getpid(), ending);
  return path;
}

static inline int scratch_remove(void **state) {
  (void)state;
  (void)remove(scratch(".dat"));
  (void)remove(scratch(".hdf5"));
  return 0;
}
