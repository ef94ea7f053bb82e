/* base/gather.h - what the parts of a shared work find (base/crew.h), where nobody knows beforehand how much that is.
 *
 * Each part has a list of its own, which grows. Joined they follow each other in the order of the parts, so the result does not
 * depend on who did which part. */
#pragma once

#include "lcp/base/arena.h"
#include "lcp/base/status.h"

/* Of one part. Its neighbours are written to by other threads, so it has a cache line of its own. */
typedef struct base_list {
  _Alignas(BASE_ALIGN) unsigned char *at; /* owned */
  int n, cap;                             /* items */
  bool failed;                            /* there was no memory for one more */
} base_list;

typedef struct base_gather {
  size_t size; /* of an item [bytes] */
  int parts, cap;
  base_list *list; /* cap; owned. NULL: nothing is held */
} base_gather;

/* One empty list for each of `parts` parts of items of `size` bytes, the same in all calls; lists keep the memory that they have.
 * BASE_ENOMEM. */
base_status base_gather_begin(base_gather *g, int parts, size_t size, base_error *err);

/* Room for one more item at the end of the part's list, uninitialised; NULL without memory, which base_gather_count tells. */
void *base_gather_add(base_gather *g, int part);

/* How many items there are in all lists. BASE_ENOMEM: one of them had no memory; BASE_EUNSUPPORTED: more than fit into half an int. `what`
 * names them in the error. */
base_status base_gather_count(const base_gather *g, const char *what, int *n, base_error *err);

/* Copies them all to `to`, one list after the other. */
void base_gather_join(const base_gather *g, void *to);

void base_gather_close(base_gather *g);
