/* base/crew.h - threads that share the work of the one that calls them.
 *
 * Work comes in numbered parts. They are begun in the order of their numbers, by whoever is free, so that a part may wait for what an
 * earlier one does. A part must write the same whoever does it and whenever: then the bits do not depend on the number of threads.
 *
 * A thread works with the crew that it has taken up, or alone, which is how every thread begins; whoever does a part of several
 * works alone in it. So what is shared out need not be told who shares. */
#pragma once

#include "lcp/base/status.h"

enum { BASE_THREADS_MAX = 256 };

typedef struct base_crew base_crew; /* opaque: owns threads that sleep between two works */

/* threads: 1 to BASE_THREADS_MAX, the caller's among them; fewer where the system gives no more. */
base_status base_crew_open(base_crew **out, int threads, base_error *err);
void base_crew_close(base_crew *c); /* accepts NULL; nobody may have taken it up */

/* The crew of this thread from now on, NULL: none; returns that of before. */
base_crew *base_crew_take_up(base_crew *c);

/* Threads that share the work of this one, itself included. */
int base_crew_size(void);

/* All parts 0 .. parts-1 are done when it returns. `hand`: 0 .. base_crew_size()-1, of nobody else at that time. A single part is done here, with
 * the crew at its service. */
typedef void (*base_part)(void *context, int part, int hand);
void base_share(int parts, base_part part, void *context);

/* A range of `count` in parts of `size`: how many there are, and where one ends. */
static inline int base_parts(int count, int size) {
  return (count + size - 1) / size;
}
static inline int base_part_end(int part, int count, int size) {
  return (count < (part + 1) * size) ? count : (part + 1) * size;
}
