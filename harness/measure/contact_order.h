/* harness/measure/contact_order.h - the contacts of a step in another order, the same one in every step.
 *
 * Sweeps, pivots and the answers of singular problems depend on the order in which contacts are
 * listed, which is an accident of the scene (Acary, Bremond & Huber 2018, section 3.4, for NSGS). Ids
 * are replaced by a one-to-one scramble of them with a seed, and the contacts sorted by what comes
 * out: a random permutation that a contact keeps while it lasts, and a contact set like any other. Contacts of two shapes stay
 * together, for formulations ask whether two shapes touch elsewhere: pairs are permuted, and the contacts of each. */
#pragma once

#include "formulations/formulation.h"

typedef struct contact_order {
  uint64_t seed; /* 0: as the scene lists them */
  void *mem;     /* owned */
  size_t bytes;
  int *from;       /* the contact that stands at each place */
  contact_set set; /* in this order; views into mem and into the set as given */
  double *impulse, *bias;
  unsigned char *mode;
} contact_order;

enum { CONTACT_ORDER_TEXT = 24 };

/* "given", or "random:N" with N >= 1. BASE_EINVAL otherwise. */
base_status contact_order_parse(const char *text, uint64_t *seed, base_error *err);

/* *out: c in this order, valid until the next call; c itself where the order is the given one. */
base_status contact_order_apply(contact_order *o, const contact_set *c, const contact_set **out,
                                base_error *err);

/* The answer to the set last handed out, per contact of c again. */
void contact_order_restore(contact_order *o, const contact_set *c, formulation_answer *a);
void contact_order_close(contact_order *o);
