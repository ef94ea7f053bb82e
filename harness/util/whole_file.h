/* harness/util/whole_file.h - files that are there whole or not at all: written under a temporary name,
 * flushed to the disk, then renamed. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>
#include <stdio.h>

typedef struct whole_file {
  FILE *to; /* NULL: not open */
  char path[1100], temporary[1110];
} whole_file;

/* Opens PATH.tmp for writing. BASE_EINVAL: the path is too long; BASE_EIO: with the system's word. */
base_status whole_file_open(whole_file *w, const char *path, base_error *err);

/* keep: what was written gets its name; otherwise, and where that fails, nothing is left of it and
 * what had the name before stays. Nothing to do where it is not open. */
base_status whole_file_close(whole_file *w, bool keep, base_error *err);
