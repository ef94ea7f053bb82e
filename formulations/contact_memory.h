/* formulations/contact_memory.h - what a formulation remembers of each contact from one step to
 * the next, found again by contact id. An entry is `stride` doubles; a contact that was not listed
 * in the last step has no past. Both lists are sorted by id, so that matching is one merge. */
#pragma once

#include "problems/world/contact_set.h"

typedef struct contact_memory {
  int stride;
  int n, n_old, cap;
  void *mem; /* owned; the arrays below */
  uint64_t *id, *id_old;
  double *now, *old; /* stride per contact */
  int *match;        /* n: index in old, -1: new */
  double h_old;      /* step length of the remembered step [s], 0: none */
  double h_now;
} contact_memory;

/* Moves the present to the past and matches the contacts of c with it; new entries are zero. */
base_status contact_memory_begin(contact_memory *m, int stride, const contact_set *c,
                                 base_error *err);
void contact_memory_forget(contact_memory *m);
void contact_memory_close(contact_memory *m);

/* The past of contact i of the set, NULL if it has none. */
static inline const double *contact_memory_old(const contact_memory *m, int i) {
  return (m->match[i] < 0) ? NULL : m->old + (ptrdiff_t)m->match[i] * m->stride;
}
/* Where the present of contact i is written. */
static inline double *contact_memory_now(contact_memory *m, int i) {
  return m->now + (ptrdiff_t)i * m->stride;
}
