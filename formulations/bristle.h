/* formulations/bristle.h - a bristle from one step to the next (MATHEMATICS 2.3.11). What it pulls with is remembered as a
 * vector in the world, three numbers, or where it has one row (a planar tangent, torsion) as that number; at the next step
 * that is projected onto the tangent plane, brought back to its length, and turned about the normal by the mean spin of the
 * two bodies. A planar tangent turns with the normal by itself. */
#pragma once

#include "formulations/contact_memory.h"

/* By which a contact's frame has turned over the step. */
typedef struct form_bristle_turn {
  double cosine, sine;
} form_bristle_turn;

/* Of contact g of the set. */
form_bristle_turn form_bristle_turn_of(const contact_set *c, int g);

/* What was remembered, over two rows of contact g: any tangential vector, a direction too. */
void form_bristle_to_frame(const contact_set *c, int g, form_bristle_turn by, const double *vector,
                           double *out);

/* What the springs of a kind of part pull with at contact g, over its rows in the set [N], [N m], as its past in the memory has it: of the
 * last law that had springs, if the contact was active ever since. Otherwise friction pulled with its impulses, and springs take over
 * from there. The contact has a past, and the memory is laid out for springs of that kind. */
void form_bristle_pull(const contact_set *c, int g, int kind, const contact_memory *memory,
                       double out[2]);

/* in[dim], rows t1 and t2 or only one, as it is remembered. */
void form_bristle_remember(const contact_set *c, int g, int dim, const double *in, double *vector);

/* Rows of a contact that belong to a kind of part (0 friction, 1 torsion, 2 rolling), and the first of them. */
int form_bristle_rows(contact_rows rows, int kind, int *first);

/* Which contacts have one stiffness together, because springs side by side add up. */
typedef enum form_bristle_shared {
  FORM_BRISTLE_EACH, /* none: the solver may let one of them carry all */
  FORM_BRISTLE_COPIES, /* those between the same bodies, at the same point and with the same rows to rounding */
  FORM_BRISTLE_PAIR, /* those between the same bodies: how many points stand for a face makes it no stiffer */
} form_bristle_shared;

/* Scratch: a contact by its bodies. */
typedef struct form_bristle_key {
  int body[2], at;
} form_bristle_key;

/* Of the n active contacts `group` of the set, in any order: out[i] = how many of them share the stiffness of contact i, itself
 * included. key: n. */
void form_bristle_sharers(const contact_set *c, int n, const int *group, form_bristle_shared shared,
                          form_bristle_key *key, int *out);
