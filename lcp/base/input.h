/* base/input.h - every file that the suite reads: a regular one. A problem is read more than once (its
 * kind, its content, its hash) and its name stands in the command that repeats a run, so a FIFO, which
 * would also wait for ever for a writer, a device and a folder are refused. The name - is standard input, which
 * is read as a whole when it is opened first, and put back as a file in memory. */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>
#include <stdio.h>

/* Opens it for reading bytes. BASE_EINVAL: not a regular file. BASE_EIO: with the system's word. errno
 * holds the reason, ENOENT where there is no such file. */
base_status base_in_open(const char *path, FILE **out, base_error *err);

/* The same for text: stands behind a byte-order mark of UTF-8 where there is one. BASE_EINVAL: UTF-16. */
base_status base_in_text(const char *path, FILE **out, base_error *err);

bool base_in_is_stdin(const char *path);
