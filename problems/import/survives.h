/* problems/import/survives.h - does a library survive a file? */
#pragma once

#include "lcp/base/status.h"

#include <stdbool.h>

/* Runs body(ctx) in a child process of at most 60 s of processor time; *survived: it came to its
 * end. What it changes in memory is lost. libhdf5 1.10 reads through null pointers and loops for
 * ever on some damaged files (found by scripts/fuzz), which no check before can see. BASE_EEXTERNAL
 * if no child can be made. */
base_status survives(void (*body)(void *ctx), void *ctx, bool *survived, base_error *err);

/* Runs body(ctx) with at most `bytes` of address space more than the process has now: what a damaged
 * size asks for beyond that is refused to it as if the machine had no more. */
void survives_within(size_t bytes, void (*body)(void *ctx), void *ctx);
