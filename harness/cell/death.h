/* harness/cell/death.h - the word that a process earns which ended without its result. */
#pragma once

#include "harness/cell/isolate.h"
#include "harness/measure/verdict.h"

/* end->how is not ISOLATE_DONE, or the work left no item. wall: the limit it had [s]. note: one line for a reader. */
run_status death_word(const isolate_end *end, double wall, char *note, size_t cap);
