/* base/output.h - every file that the suite writes.
 *
 *   a name that is free, a regular file   written without a name, flushed to the disk, then given its
 *                                         name: there whole or not at all, and nothing is left where the
 *                                         program is killed. Where the file system has no files without
 *                                         a name, and where a library writes: under a temporary name
 *   a symlink                             stays; what it points to is written
 *   a character device, a FIFO            written to as it is; a FIFO that nobody has opened for
 *                                         reading after BASE_OUT_WAIT is refused
 *   /dev/fd/N, /proc/self/fd/N            what the descriptor is open on is appended to
 *   - or /dev/stdout                      standard output
 *   a folder, a socket, a block device    refused */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>
#include <stdio.h>

#define BASE_OUT_WAIT 5.0 /* [s] */

typedef struct base_out {
  FILE *to;        /* NULL: not open */
  char path[1100]; /* the file itself, symlinks followed */
  char temporary
      [1200]; /* what is written until it is whole; "" where it has no name yet, or is written as it is */
  bool nameless; /* it gets a name when it is whole */
} base_out;

/* BASE_EINVAL: the path is empty or too long. BASE_EIO: refused, or with the system's word. BASE_ENOMEM:
 * no memory for the stream. */
base_status base_out_open(base_out *o, const char *path, base_error *err);

/* As base_out_open, for a library that opens o->temporary itself. BASE_EIO also: not a regular file. */
base_status base_out_open_regular(base_out *o, const char *path, base_error *err);

/* keep: what was written gets its name; BASE_EIO with the system's word where some of it could not be
 * written. Not kept, or failed: nothing is left of it and what had the name before stays (a device, a
 * FIFO and standard output keep what they have got). Nothing to do where it is not open. */
base_status base_out_close(base_out *o, bool keep, base_error *err);

/* Ends work that came to `done` and wrote here: kept where it is BASE_OK. Otherwise *err and `done` stand,
 * unless the file could not be written, which then is the reason and is told. */
base_status base_out_finish(base_out *o, base_status done, base_error *err);

/* Does this name stand for standard output? */
bool base_out_is_stdout(const char *path);
