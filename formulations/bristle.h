/* formulations/bristle.h - the deflection of a bristle from one step to the next (MATHEMATICS 2.3.11). It is remembered as a
 * vector in the world, three numbers, or where it has one row (a planar tangent, torsion) as that number; at the next step
 * it is projected onto the tangent plane, brought back to its length, and turned about the normal by the mean spin of the
 * two bodies. A planar tangent turns with the normal by itself. */
#pragma once

#include "problems/world/contact_set.h"

enum { BRISTLE_NUMBERS = 3 }; /* of one deflection as it is remembered */

/* By which a contact's frame has turned over the step. */
typedef struct form_bristle_turn {
  double cosine, sine;
} form_bristle_turn;

/* Of contact g of the set. */
form_bristle_turn form_bristle_turn_of(const contact_set *c, int g);

/* What was remembered, over two rows of contact g: any tangential vector, a direction too. */
void form_bristle_to_frame(const contact_set *c, int g, form_bristle_turn by, const double *vector,
                           double *out);

/* in[dim], rows t1 and t2 or only one, as it is remembered. */
void form_bristle_remember(const contact_set *c, int g, int dim, const double *in, double *vector);

/* Rows of a contact that belong to a kind of part (0 friction, 1 torsion, 2 rolling), and the first of them. */
int form_bristle_rows(contact_rows rows, int kind, int *first);
