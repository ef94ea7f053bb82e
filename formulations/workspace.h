/* formulations/workspace.h - the arrays of a formulation, carved from one block. */
#pragma once

#include "lcp/base/arena.h"
#include "lcp/base/status.h"

/* Runs layout on a measuring arena, replaces *mem (freed; NULL at first) by a block of that size, runs it again
 * on that. Nothing is copied. BASE_ENOMEM leaves *mem NULL. */
base_status form_memory(void **mem, void (*layout)(void *, base_arena *), void *state,
                        base_error *err);
