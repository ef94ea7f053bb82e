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

/* A copy of what is remembered, to come back to. */
typedef struct contact_past {
  int stride, n, cap;
  double h;       /* [s], as h_now */
  double *number; /* n ids, then stride numbers a contact; owned */
} contact_past;

/* The next contact_memory_begin after a recall finds what it would have found after the keep. */
base_status contact_memory_keep(const contact_memory *m, contact_past *past, base_error *err);
base_status contact_memory_recall(contact_memory *m, const contact_past *past, base_error *err);
void contact_memory_drop(contact_past *past);

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
