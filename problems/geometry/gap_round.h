/* problems/geometry/gap_round.h - gap points of a disc or cylinder against a segment, a box or another one, part
 * of gap_spatial (shapes.h). At least one of the two pieces is a PIECE_DISC, neither is a point. */
#pragma once

#include "problems/geometry/shapes.h"

int gap_round(const piece *pa, const pose *at_a, const piece *pb, const pose *at_b, double margin,
              gap_point *out);
