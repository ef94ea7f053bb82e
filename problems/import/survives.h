/* problems/import/survives.h - does a library survive a file? */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>

/* Runs body(ctx) in a child process of at most 60 s of processor time; *survived: it came to its
 * end. What it changes in memory is lost. libhdf5 1.10 reads through null pointers and loops for
 * ever on some damaged files (found by scripts/fuzz), which no check before can see. BASE_EEXTERNAL
 * if no child can be made. */
base_status survives(void (*body)(void *ctx), void *ctx, bool *survived, base_error *err);
